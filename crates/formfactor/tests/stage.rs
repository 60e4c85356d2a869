//! From container to container, and what is refused.

mod walls;

use formfactor::{Error, Params, form_factors, memory_needed, run};
use radfile::{Builder, Container, FormFactors, Mesh, Patches, Provenance, Quiet, Record, Step};
use walls::{inside_of_box, whole};

fn step() -> Step {
    Step { stage: "formfactor".into(), version: "1".into(), options: "--rays 64".into(), inputs: vec![] }
}

fn run_on(input: &Container) -> formfactor::Result<Container> {
    let mut output = None;
    run(input, &Params { rays: 64, seed: 1 }, step(), &Quiet, &mut |builder| {
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
    let (direct, _) =
        form_factors(&room.mesh, &room.patches, &Params { rays: 64, seed: 1 }, &Quiet).expect("form factors");
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
        let result = form_factors(mesh, patches, &Params { rays, seed: 0 }, &Quiet);
        result.expect_err("nothing to measure").to_string()
    };
    assert_eq!(
        text(&Mesh::default(), &Patches::default(), 1),
        "there are no patches; make them with `allbounce voxel-simplify`"
    );
    assert_eq!(text(&room.mesh, &room.patches, 0), "0 rays a patch measure nothing, expected at least 1");
}

#[test]
fn memory_grows_with_the_square_of_the_patches() {
    assert_eq!(memory_needed(10_000), 4 * 10_000 * 10_000 + 256 * 10_000);
    assert_eq!(memory_needed(usize::MAX), u64::MAX);
}
