//! Everything in a container is reordered together.

mod common;

use common::scene;
use permute::{Error, Order, Params, Report, memory_needed, run};
use radfile::{
    Builder, Container, FLAG_PATCH_ORDER, FLAG_REQUIRED, FormFactors, Operator, Patches, Permutation, Provenance,
    Quiet, Record, Step,
};

fn step() -> Step {
    Step { stage: "permute".into(), version: "0".into(), options: String::new(), inputs: vec![] }
}

fn params(order: Order) -> Params {
    Params { order }
}

/// The scene with a three-channel operator whose channels differ.
fn input() -> Container {
    let (patches, factors, grey) = scene(6);
    let values: Vec<f32> = (1..=3).flat_map(|c| grey.values.iter().map(move |v| v * c as f32)).collect();
    let operator = Operator { channels: 3, bounces: Some(4), values: values.into(), ..grey };
    let mut builder = Builder::new();
    patches.write(&mut builder);
    factors.write(&mut builder);
    operator.write(&mut builder);
    builder.array("someone.notes", 0, &[3], vec![1u8, 2, 3]);
    builder.finish().unwrap()
}

fn output(input: &Container, params: &Params) -> Result<(Container, Report), Error> {
    let mut out = None;
    let mut sink = |builder: &Builder<'_>| {
        out = Some(builder.finish()?);
        Ok(())
    };
    let report = run(input, params, step(), &Quiet, &mut sink)?;
    Ok((out.unwrap(), report))
}

/// Irradiance from radiosity-like light: A^{-1/2} K A^{1/2} (ρ H + M).
fn gather(patches: &Patches, operator: &Operator, direct: &[[f32; 3]]) -> Vec<[f64; 3]> {
    let n = patches.len();
    let root = |i: usize| f64::from(patches.area[i]).sqrt();
    let light = |j: usize, c: usize| {
        f64::from(patches.reflectance[j][c]) * f64::from(direct[j][c]) + f64::from(patches.emission[j][c])
    };
    (0..n)
        .map(|i| {
            std::array::from_fn(|c| {
                let row = &operator.channel(c)[i * n..][..n];
                (0..n).map(|j| f64::from(row[j]) * root(j) * light(j, c)).sum::<f64>() / root(i)
            })
        })
        .collect()
}

#[test]
fn the_reordered_operator_gathers_the_same_light_for_the_reordered_patches() {
    let input = input();
    let (patches, operator) = (Patches::read(&input).unwrap(), Operator::read(&input).unwrap());
    let direct: Vec<[f32; 3]> = patches.position.iter().map(|p| p.map(|x| x.abs())).collect();
    let before = gather(&patches, &operator, &direct);
    for order in Order::ALL {
        let (out, report) = output(&input, &params(order)).unwrap();
        let table = Permutation::read(&out).unwrap();
        let (patches, operator) = (Patches::read(&out).unwrap(), Operator::read(&out).unwrap());
        assert_eq!((operator.channels, operator.bounces), (3, Some(4)));
        let after = gather(&patches, &operator, &table.apply(&direct));
        for (found, expected) in after.as_flattened().iter().zip(table.apply(&before).as_flattened()) {
            // The same products in another sequence: rounding of f64.
            assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{} {found} {expected}", order.name());
        }
        assert_eq!(report.moved == 0, order == Order::None);
    }
}

#[test]
fn reordering_and_back_is_the_same_bit_for_bit() {
    let input = input();
    let (out, _) = output(&input, &params(Order::Greedy)).unwrap();
    let back = Permutation::new(Permutation::read(&out).unwrap().old_to_new()).unwrap();
    let restored = Patches::read(&out).unwrap().permuted(&back);
    assert_eq!(restored, Patches::read(&input).unwrap());
    let (k, first) = (Operator::read(&out).unwrap(), Operator::read(&input).unwrap());
    for colour in 0..3 {
        assert!(back.apply_to_matrix(k.channel(colour)) == first.channel(colour));
    }
    let (f, first) = (FormFactors::read(&out).unwrap(), FormFactors::read(&input).unwrap());
    assert!(back.apply_to_matrix(&f.values) == first.values[..]);
    assert!(back.apply(&f.sky) == first.sky[..]);
}

#[test]
fn the_locator_finds_the_same_patch_under_its_new_number() {
    let input = input();
    let (out, _) = output(&input, &params(Order::Hilbert)).unwrap();
    let (before, after) = (Patches::read(&input).unwrap(), Patches::read(&out).unwrap());
    for face in 0..before.len() as u32 {
        let old = before.locator.patch_at(face, [0.5; 3]).unwrap() as usize;
        let new = after.locator.patch_at(face, [0.5; 3]).unwrap() as usize;
        assert_eq!(before.position[old], after.position[new]);
        assert_eq!(before.pieces_of(old), after.pieces_of(new));
        assert!(after.pieces_of(new).iter().all(|p| p.face == face));
    }
}

#[test]
fn the_table_always_leads_back_to_the_first_order() {
    let input = input();
    let (once, _) = output(&input, &params(Order::Morton)).unwrap();
    let (twice, _) = output(&once, &params(Order::NormalHilbert)).unwrap();
    let first = Patches::read(&input).unwrap();
    let last = Patches::read(&twice).unwrap();
    let table = Permutation::read(&twice).unwrap();
    assert_eq!(table.apply(&first.position), last.position);
    assert_eq!(table.apply(&first.emission), last.emission);
    // Positions decide alone, so a detour over another order changes nothing (no two patches share a key here).
    let (direct, _) = output(&input, &params(Order::NormalHilbert)).unwrap();
    assert_eq!(Permutation::read(&direct).unwrap(), table);
    assert_eq!(Provenance::read(&twice).unwrap().steps.len(), 2);
}

#[test]
fn the_report_shows_what_the_order_gained() {
    let (_, report) = output(&input(), &Params::default()).unwrap();
    assert_eq!(report.order, "normal-hilbert");
    let (d, tiles) = (report.neighbour_difference.unwrap(), report.zero_tiles.unwrap());
    assert!(d.after < 0.6 * d.random && tiles.after > tiles.before, "{report:?}");
}

#[test]
fn parts_that_are_not_there_are_not_needed() {
    let input = input();
    let only_patches = Builder::from_input(&input, |s| s.name.starts_with("patches.")).finish().unwrap();
    let (out, report) = output(&only_patches, &Params::default()).unwrap();
    assert!(!out.has("series.values") && !out.has("formfactor.sky"));
    assert_eq!((report.neighbour_difference, report.zero_tiles), (None, None));

    let without_values = Builder::from_input(&input, |s| s.name != "formfactor.values").finish().unwrap();
    let (out, _) = output(&without_values, &Params::default()).unwrap();
    let sky = radfile::read_sky(&input).unwrap();
    assert_eq!(radfile::read_sky(&out).unwrap(), Permutation::read(&out).unwrap().apply(sky));
}

#[test]
fn unknown_sections_stay_unless_they_follow_the_order_of_patches() {
    let input = input();
    let mut builder = Builder::from_input(&input, |_| true);
    builder.array("someone.per_patch", FLAG_PATCH_ORDER, &[1], vec![0u8]);
    builder.array("series.history", FLAG_PATCH_ORDER, &[1], vec![0u8]);
    builder.meta("accuracy.meta", 0, &"what the bake was measured to be in the old order");
    let (out, report) = output(&builder.finish().unwrap(), &Params::default()).unwrap();
    assert_eq!(report.dropped, ["someone.per_patch", "series.history"]);
    assert!(!out.has("someone.per_patch") && !out.has("series.history"));
    assert!(out.has("someone.notes") && !out.has("accuracy.meta"));
}

#[test]
fn what_was_made_for_the_present_order_forbids_another() {
    let input = input();
    for (section, stage) in [("pack.blocks", "dxt-pack"), ("transfer.weight", "transfer")] {
        let mut builder = Builder::from_input(&input, |_| true);
        builder.array(section, FLAG_REQUIRED | FLAG_PATCH_ORDER, &[1], vec![0u8]);
        let text = output(&builder.finish().unwrap(), &Params::default()).err().unwrap().to_string();
        assert!(
            text.contains(section) && text.contains(&format!("permute comes before `allbounce {stage}`")),
            "{text}"
        );
    }
    let mut builder = Builder::from_input(&input, |_| true);
    builder.array("mesh.uv", FLAG_REQUIRED | FLAG_PATCH_ORDER, &[1], vec![0u8]);
    let error = output(&builder.finish().unwrap(), &Params::default()).err().unwrap();
    assert!(
        error.to_string().starts_with("section mesh.uv is marked as required and as following the order"),
        "{error}"
    );
}

#[test]
fn parts_about_other_patches_are_refused() {
    let input = input();
    let with = |write: &dyn Fn(&mut Builder)| {
        let mut builder = Builder::from_input(&input, |_| true);
        write(&mut builder);
        let error = output(&builder.finish().unwrap(), &Params::default()).err().unwrap();
        assert!(matches!(error, Error::Container(_)), "{error}");
        error.to_string()
    };
    const FLAGS: u32 = FLAG_REQUIRED | FLAG_PATCH_ORDER;
    let text = with(&|b| b.array("series.values", FLAGS, &[1, 3, 3], vec![0.0_f32; 9]));
    assert!(text.contains("operator") && text.contains("made for 3 patches"), "{text}");
    let text = with(&|b| {
        b.array("formfactor.values", FLAGS, &[2, 2], vec![0.0_f32; 4]);
        b.array("formfactor.sky", FLAGS, &[2], vec![1.0_f32; 2]);
    });
    assert!(text.contains("made for 2 patches"), "{text}");
    let text = with(&|b| b.array("permute.new_to_old", FLAG_REQUIRED, &[2], vec![1_u32, 0]));
    assert!(text.contains("permutation") && text.contains("made for 2 patches"), "{text}");
    let empty = output(&Builder::new().finish().unwrap(), &Params::default()).err().unwrap();
    assert!(empty.to_string().contains("voxel-simplify"), "{empty}");
}

#[test]
fn memory_is_a_copy_of_operator_and_form_factors() {
    assert_eq!(memory_needed(3000, 3), 4 * 9_000_000 * 4);
    assert_eq!(memory_needed(1000, 1), 8_000_000);
}
