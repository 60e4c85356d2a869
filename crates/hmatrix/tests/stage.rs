//! From container to container, and all bounces from the operator of one.

#[path = "../../dxt-pack/tests/common/mod.rs"]
mod common;

use common::{Room, room, symmetric_form_factors};
use hmatrix::{Error, Params, Solve, read, run};
use radfile::{
    Builder, Container, FormFactors, HierarchicalOperator, Kernel, Operator, Patches, Provenance, Quiet, Record, Step,
};

fn step(stage: &str) -> Step {
    Step { stage: stage.into(), version: "1".into(), options: String::new(), inputs: Vec::new() }
}

/// A container as `series` leaves it, with a section that this version does not know.
fn solved(room: &Room) -> Container {
    let (p, n) = (&room.patches, room.operator.n);
    let w = symmetric_form_factors(p);
    let values: Vec<f32> = (0..n * n).map(|at| w[at] * (p.area[at % n] / p.area[at / n]).sqrt()).collect();
    let factors = FormFactors { values: values.into(), sky: vec![0.0; n].into() };
    let mut builder = Builder::new();
    p.write(&mut builder);
    factors.write(&mut builder);
    room.operator.write(&mut builder);
    builder.array::<u8>("x.note", 0, &[3], vec![1, 2, 3]);
    builder.provenance(None, step("series")).unwrap();
    builder.finish().unwrap()
}

fn run_on(input: &Container, params: &Params) -> hmatrix::Result<Container> {
    let mut output = None;
    run(input, params, step("hmatrix"), &Quiet, &mut |builder| {
        output = Some(builder.finish()?);
        Ok(())
    })?;
    Ok(output.expect("the sink was called"))
}

#[test]
fn the_dense_matrices_go_unless_they_are_kept_and_the_rest_stays() {
    let room = room(6, 3);
    let input = solved(&room);
    let output = run_on(&input, &Params::default()).unwrap();
    for gone in ["series.meta", "series.values", "formfactor.values"] {
        assert!(!output.has(gone), "{gone}");
    }
    assert_eq!(Patches::read(&output).unwrap(), room.patches);
    assert_eq!(radfile::read_sky(&output).unwrap().len(), room.patches.len());
    assert_eq!(output.data(output.section("x.note").unwrap()), [1, 2, 3]);
    let steps = Provenance::read(&output).unwrap().steps;
    assert_eq!(steps.iter().map(|s| &s.stage[..]).collect::<Vec<_>>(), ["series", "hmatrix"]);
    let (matrix, certificate) = read(&output).unwrap();
    assert_eq!((matrix.patches(), matrix.channels(), certificate.bounces), (216, 3, None));
    assert!(certificate.l2_mean > 0.0 && certificate.l2_mean < 0.007 && certificate.vis99 > certificate.l2_mean);

    let kept = run_on(&input, &Params { keep_dense: true, ..Params::default() }).unwrap();
    assert_eq!(Operator::read(&kept).unwrap(), room.operator);
    let again = run_on(&kept, &Params::default()).unwrap();
    assert_eq!(HierarchicalOperator::read(&again).unwrap(), HierarchicalOperator::read(&output).unwrap());
    let error = run_on(&output, &Params::default()).map(|_| ()).expect_err("there is nothing to pack").to_string();
    assert!(error.contains("series.meta"), "{error}");
}

/// The light of one bounce, solved, is that of all bounces, and one bounce takes fewer bytes.
#[test]
fn one_bounce_gives_the_light_of_all() {
    let room = room(10, 3);
    let input = solved(&room);
    let params = Params { kernel: Kernel::OneBounce, ..Params::error(0.01) };
    let packed = run_on(&input, &params).unwrap();
    let (matrix, certificate) = read(&packed).unwrap();
    assert_eq!((matrix.channels(), certificate.kernel, certificate.bounces), (1, Kernel::OneBounce, None));
    assert!(certificate.l2_mean < 0.013 && certificate.l2_mean > 0.005, "{certificate:?}");

    // A lamp near a corner of the floor, after its first reflection.
    let (p, n) = (&room.patches, room.operator.n);
    let lit = |i: usize| if i < 20 { (20 - i) as f32 } else { 0.1 };
    let x: Vec<[f32; 3]> = (0..n).map(|i| p.reflectance[i].map(|r| r * p.area[i].sqrt() * lit(i))).collect();
    let mut y = vec![[0.0; 3]; n];
    let mut workspace = matrix.workspace();
    let product = |x: &[[f32; 3]], y: &mut [[f32; 3]]| matrix.multiply(x, y, &mut workspace);
    let products = Solve::new(n).all_bounces(product, &p.reflectance, 1e-3, &x, &mut y);
    assert!((4..20).contains(&products), "{products} products");
    let [mut error, mut light] = [0.0f64; 2];
    for (i, y) in y.iter().enumerate() {
        for c in 0..3 {
            let row = &room.operator.channel(c)[i * n..][..n];
            let exact: f64 = row.iter().zip(&x).map(|(k, x)| f64::from(*k) * f64::from(x[c])).sum();
            error += (f64::from(y[c]) - exact).powi(2);
            light += exact * exact;
        }
    }
    let l2 = (error / light).sqrt();
    assert!(l2 < 0.03, "L2 of a light that is more uneven than most: {l2}");
    let all = run_on(&input, &Params::error(0.01)).unwrap();
    let bytes = |c: &Container| HierarchicalOperator::read(c).unwrap().blocks.len();
    assert!(bytes(&packed) < bytes(&all), "{} and {}", bytes(&packed), bytes(&all));
}

#[test]
fn a_stream_that_its_certificate_does_not_describe_is_refused() {
    let output = run_on(&solved(&room(4, 1)), &Params::default()).unwrap();
    let mut packed = HierarchicalOperator::read(&output).unwrap();
    packed.certificate.channels = 3;
    let mut builder = Builder::from_input(&output, |s| !s.name.starts_with("hmatrix."));
    packed.write(&mut builder);
    let error = read(&builder.finish().unwrap()).map(|_| ()).expect_err("one channel");
    assert!(matches!(error, Error::Certificate { .. }), "{error}");
    let coloured = Params { kernel: Kernel::OneBounce, ..Params::default() };
    let room = room(4, 3);
    let error = hmatrix::compress(&room.operator, &room.patches, &coloured, &Quiet).map(|_| ()).expect_err("colour");
    assert!(matches!(error, Error::Coloured), "{error}");
}
