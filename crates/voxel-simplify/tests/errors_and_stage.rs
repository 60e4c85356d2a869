//! Scenes that cannot be simplified are refused in one sentence; the others become a container.

mod common;

use common::{Build, at_voxel, furnished, v};
use radfile::{Container, Patches, Provenance, Quiet, Record, Step, Texture, Wrap};
use scene::Scene;
use voxel_simplify::{Mode, Params, Resolution, run, voxel_simplify};

fn refusal(scene: &Scene, params: &Params) -> String {
    voxel_simplify(scene, params, &Quiet).expect_err("this must be refused").to_string()
}

#[track_caller]
fn says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{message:?} does not say {part:?}");
    }
}

#[test]
fn a_mesh_without_triangles_is_refused() {
    says(&refusal(&Build::new().scene(), &at_voxel(1.0)), &["no triangles"]);
}

#[test]
fn vertices_that_are_no_points_are_refused() {
    let mut build = furnished();
    build.mesh.positions[5][1] = f32::NAN;
    says(&refusal(&build.scene(), &at_voxel(1.0)), &["vertex 5", "NaN", "repair"]);
}

#[test]
fn triangles_without_area_are_refused_if_there_are_no_others() {
    let mut build = Build::new();
    build.triangle([v(0.0, 0.0, 0.0), v(1.0, 1.0, 1.0), v(2.0, 2.0, 2.0)], 0);
    says(&refusal(&build.scene(), &at_voxel(1.0)), &["none of the 1 triangles has an area"]);
}

#[test]
fn voxel_sizes_that_are_no_length_are_refused() {
    let scene = furnished().scene();
    for size in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        says(&refusal(&scene, &at_voxel(size)), &[&format!("voxel size {size} m"), "positive finite length"]);
    }
}

#[test]
fn no_patches_are_not_a_number_of_patches() {
    let params = Params { resolution: Resolution::Patches(0), ..Params::default() };
    says(&refusal(&furnished().scene(), &params), &["0 patches", "at least 1"]);
}

#[test]
fn voxels_beyond_what_a_cell_number_holds_are_refused_with_one_that_would_do() {
    says(&refusal(&furnished().scene(), &at_voxel(1e-7)), &["voxels of 0.0000001 m", "2097152", "at least 0.00000190"]);
}

#[test]
fn voxels_far_larger_than_the_scene_are_refused_with_its_size() {
    let scene = furnished().scene();
    let extent = (0..3).map(|a| {
        let along = scene.mesh.positions.iter().map(|p| p[a]);
        along.clone().fold(f32::MIN, f32::max) - along.fold(f32::MAX, f32::min)
    });
    let extent = extent.fold(0.0, f32::max);
    for voxel in [101.0 * extent, 1e30] {
        let message = refusal(&scene, &at_voxel(voxel));
        let found =
            format!("voxels of {voxel} m are more than 100 times as large as the scene, which is {extent} m long");
        says(&message, &[&found, "use voxels well below", "or give a number of patches"]);
    }
    let (patches, _) = common::simplify(&scene, 99.0 * extent);
    assert!(!patches.is_empty(), "one voxel around everything is coarse, but no mistake");
}

#[test]
fn voxels_that_would_not_fit_into_memory_are_refused_with_one_that_would_do() {
    let scene = furnished().scene();
    let message = refusal(&scene, &at_voxel(1e-4));
    says(&message, &["pieces", "MiB", "the limit is 8192 MiB", "use voxels of about"]);
    let params = Params { resolution: Resolution::Patches(u32::MAX), ..Params::default() };
    says(&refusal(&scene, &params), &["or fewer patches"]);
}

#[test]
fn a_scene_that_sees_nothing_is_refused() {
    let mut build = Build::new();
    build.triangle([v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0)], 0);
    let scene = build.scene();
    for mode in [Mode::Clusters, Mode::Faces] {
        for resolution in [Resolution::Voxel(0.3), Resolution::Patches(20)] {
            let params = Params { resolution, mode, ..Params::default() };
            says(&refusal(&scene, &params), &["sees any surface", "128 rays", "open on all sides"]);
        }
    }
    let keep = Params { visibility_rays: 0, ..at_voxel(0.3) };
    assert!(voxel_simplify(&scene, &keep, &Quiet).is_ok(), "with 0 rays every patch is kept");
}

#[test]
fn textures_that_cannot_be_decoded_are_refused_by_name() {
    let mut scene = furnished().scene();
    let wrap = [Wrap::Repeat, Wrap::Repeat];
    scene.materials.textures.push(Texture { name: "wood.png".into(), bytes: b"no picture".to_vec(), wrap });
    scene.materials.materials[0].reflectance_texture = Some(0);
    scene.mesh.uv = vec![[0.0; 2]; scene.mesh.positions.len()];
    says(&refusal(&scene, &at_voxel(1.0)), &["wood.png"]);
}

#[test]
fn what_the_sink_says_is_handed_on() {
    let full = &mut |_: &radfile::Builder| Err(radfile::Error::invariant("disk", "it is full"));
    let message =
        run(&furnished().scene(), &at_voxel(1.0), None, step(), &Quiet, full).expect_err("refused").to_string();
    says(&message, &["disk", "it is full"]);
}

#[test]
fn the_container_holds_the_scene_its_patches_and_where_they_came_from() {
    let scene = furnished().scene();
    let mut container = None;
    let report = run(&scene, &at_voxel(0.5), None, step(), &Quiet, &mut |builder| {
        container = Some(builder.finish()?);
        Ok(())
    })
    .expect("sound");
    let container: Container = container.expect("the sink was called");
    let (patches, _) = common::simplify(&scene, 0.5);
    assert!(Patches::read(&container).expect("patches") == patches);
    let read = Scene::read(&container).expect("a scene");
    assert!(read.mesh == scene.mesh && read.materials == scene.materials);
    assert_eq!(Provenance::read(&container).expect("provenance").steps, [step()]);
    assert_eq!(report.patches, patches.len());
    let json = serde_json::to_string(&report).expect("a report is plain data");
    assert!(json.contains("\"area_error\""), "{json}");
}

fn step() -> Step {
    Step { stage: "voxel-simplify".into(), version: "0".into(), options: "--voxel 0.5m".into(), inputs: vec![] }
}
