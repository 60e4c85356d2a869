//! From container to container, and what is refused.

mod walls;

use formfactor::{Budget, Error, Params, form_factors, memory_needed, run};
use radfile::{Builder, Container, FormFactors, Mesh, Patches, Provenance, Quiet, Record, Step};
use walls::{inside_of_box, whole};

fn step() -> Step {
    Step { stage: "formfactor".into(), version: "1".into(), options: "--rays 64".into(), inputs: vec![] }
}

fn run_on(input: &Container) -> formfactor::Result<Container> {
    let mut output = None;
    run(input, &Params::rays(64, 1), step(), &Quiet, &mut |builder| {
        output = Some(builder.finish()?);
        Ok(())
    })?;
    Ok(output.expect("the sink was called"))
}

#[test]
fn form_factors_join_what_was_in_the_container() {
    let room = whole(&inside_of_box([0.0; 3], [1.0; 3]));
    let mut builder = Builder::new();
    room.mesh.write(&mut builder);
    room.patches.write(&mut builder);
    builder.array("stranger", 0, &[2], vec![1u32, 2]);
    builder.array("pack.blocks", 0, &[1], vec![0u8]);
    let input = builder.finish().expect("a container");
    let output = run_on(&input).expect("mesh and patches are there");
    let stored = FormFactors::read(&output).expect("form factors");
    let (direct, _) = form_factors(&room.mesh, &room.patches, &Params::rays(64, 1), &Quiet).expect("form factors");
    assert!(stored == direct, "the container holds other form factors");
    assert!(output.has("stranger") && !output.has("pack.blocks"), "what was made from older form factors is gone");
    assert_eq!(Patches::read(&output).expect("patches"), room.patches);
    assert_eq!(Provenance::read(&output).expect("provenance").steps, [step()]);
    assert!(run_on(&output).expect("a second run").as_bytes().len() > input.as_bytes().len());
}

#[test]
fn a_container_without_patches_says_which_stage_makes_them() {
    let room = whole(&inside_of_box([0.0; 3], [1.0; 3]));
    let mut builder = Builder::new();
    room.mesh.write(&mut builder);
    let error = run_on(&builder.finish().expect("a container")).err().expect("no patches");
    assert!(matches!(error, Error::Container(_)));
    assert_eq!(error.to_string(), "section patches.area is missing; it is written by `allbounce voxel-simplify`");
}

#[test]
fn nothing_to_measure_is_refused() {
    let room = whole(&inside_of_box([0.0; 3], [1.0; 3]));
    let text = |mesh: &Mesh, patches: &Patches, rays| {
        let result = form_factors(mesh, patches, &Params::rays(rays, 0), &Quiet);
        result.expect_err("nothing to measure").to_string()
    };
    assert_eq!(
        text(&Mesh::default(), &Patches::default(), 1),
        "there are no patches; make them with `allbounce voxel-simplify`"
    );
    assert_eq!(text(&room.mesh, &room.patches, 0), "rays a patch: 0, expected at least 2");
}

#[test]
fn budgets_that_say_nothing_are_refused() {
    let room = whole(&inside_of_box([0.0; 3], [1.0; 3]));
    let text = |target, max_rays| {
        let params = Params { budget: Budget::Error { target, max_rays }, seed: 0 };
        form_factors(&room.mesh, &room.patches, &params, &Quiet).expect_err("no budget").to_string()
    };
    assert_eq!(text(0.01, 100), "rays a patch: 100, expected at least 256");
    for target in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let expected = format!("error of irradiance: {target}, expected a number above 0, such as 0.01");
        assert_eq!(text(target, 4096), expected);
    }
}

#[test]
fn memory_grows_with_the_square_of_the_patches() {
    let matrix = 4 * 10_000 * 10_000;
    let by_error = Budget::Error { target: 0.01, max_rays: 4096 };
    assert_eq!(memory_needed(10_000, Budget::Rays(64)), 2 * matrix + 2048 * 10_000);
    assert_eq!(memory_needed(10_000, by_error), 3 * matrix + 2048 * 10_000);
    assert_eq!(memory_needed(usize::MAX, by_error), u64::MAX);
}
