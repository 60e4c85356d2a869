//! Light by shadow maps against light by rays, on a box of the Cornell kind.

mod common;

use common::{Room, cornell, diagonal_operator, difference, gpu, inside, room, wall};
use gpu_runtime::{Gpu, GpuRuntime, Params};
use radfile::{PointRows, Quiet, Rows};
use relight::{PatchSamples, Relighter};
use scene::{Light, LightRig, Rays};

fn runtime(gpu: &Gpu, room: &Room, params: &Params) -> GpuRuntime {
    let packed = diagonal_operator(room.patches.len() as u32, 0.5);
    GpuRuntime::new(gpu, &room.bake(), &packed, params).expect("it fits")
}

fn rig(light: Light) -> LightRig {
    LightRig { lights: vec![light], ..LightRig::default() }
}

/// H⁰ by rays, from the same points on the patches; `area` rays for each of them towards an area light.
fn traced(room: &Room, rig: &LightRig, area: u32) -> Vec<[f32; 3]> {
    let operator = diagonal_operator(room.patches.len() as u32, 0.5).into();
    let rays = Rays::new(&room.scene.mesh);
    let relighter = Relighter::new(&room.scene, &rays, &room.patches, &room.elements, &operator, &room.sky).unwrap();
    relighter.element_light(&relighter.direct_light(rig), &PatchSamples { points: 32, area }, &Quiet)
}

fn lights() -> Vec<(&'static str, Light)> {
    vec![
        ("point", Light::Point { position: [2.7, 2.5, 4.9], intensity: [9.0, 8.0, 7.0] }),
        (
            "spot",
            Light::Spot {
                position: [4.8, 0.6, 5.0],
                direction: [-2.4, 2.0, -4.0],
                intensity: [9.0; 3],
                half_angle_deg: 35.0,
                penumbra_deg: 10.0,
            },
        ),
        (
            "wide spot",
            Light::Spot {
                position: [1.0, 0.6, 2.0],
                direction: [2.4, 2.0, -1.0],
                intensity: [9.0; 3],
                half_angle_deg: 80.0,
                penumbra_deg: 0.0,
            },
        ),
        (
            "quad",
            Light::Quad {
                corner: [2.1, 2.2, 5.49],
                edge_u: [0.0, 1.05, 0.0],
                edge_v: [1.3, 0.0, 0.0],
                radiance: [15.0, 12.0, 8.0],
            },
        ),
    ]
}

/// Three percent is the requirement, for the mean; what remains from patch to patch are the texels along the edges
/// of shadows.
#[test]
fn shadow_maps_give_the_light_of_rays() {
    let Some(gpu) = gpu() else { return };
    let room = cornell(12);
    let runtime = runtime(&gpu, &room, &Params::default());
    for (name, light) in lights() {
        let rig = rig(light);
        let (mean, rms) = difference(&runtime.patch_direct(&rig).unwrap(), &traced(&room, &rig, 64));
        println!("{name}: mean {:+.3} %, rms {:.2} % of the mean", 100.0 * mean, 100.0 * rms);
        assert!(mean.abs() < 0.01 && rms < 0.03, "{name}: mean {mean}, rms {rms}");
    }
}

/// The sun comes through an open ceiling.
#[test]
fn parallel_light_is_that_of_rays() {
    let Some(gpu) = gpu() else { return };
    let mut walls = inside([0.0; 3], [5.5, 5.6, 5.5], 12);
    walls.remove(1);
    walls.extend(common::block([3.6, 1.7], [0.83, 0.83], 1.65, -17.0, 4));
    let room = room(&walls);
    let rig = rig(Light::Directional { direction: [0.3, 0.5, -1.0], irradiance: [3.0, 2.0, 1.0] });
    let runtime = runtime(&gpu, &room, &Params::default());
    let (mean, rms) = difference(&runtime.patch_direct(&rig).unwrap(), &traced(&room, &rig, 1));
    println!("directional: mean {:+.3} %, rms {:.2} % of the mean", 100.0 * mean, 100.0 * rms);
    assert!(mean.abs() < 0.01 && rms < 0.03, "mean {mean}, rms {rms}");
}

/// A shining panel of the scene and a quad in its place light alike; both are compared with rays.
#[test]
fn shining_surfaces_light_like_rays_say() {
    let Some(gpu) = gpu() else { return };
    let mut walls = inside([0.0; 3], [5.5, 5.6, 5.5], 8);
    let mut panel = wall([2.1, 2.2, 5.4], [0.0, 1.05, 0.0], [1.3, 0.0, 0.0], [2, 2]);
    panel.emission = [15.0, 12.0, 8.0];
    walls.push(panel);
    let room = room(&walls);
    let runtime = runtime(&gpu, &room, &Params { emitter_samples: 64, ..Params::default() });
    assert_eq!(runtime.report().emitters, 64);
    let rig = LightRig { use_scene_emission: true, ..LightRig::default() };
    let (mean, rms) = difference(&runtime.patch_direct(&rig).unwrap(), &traced(&room, &rig, 64));
    println!("emission: mean {:+.3} %, rms {:.2} % of the mean", 100.0 * mean, 100.0 * rms);
    assert!(mean.abs() < 0.02 && rms < 0.03, "mean {mean}, rms {rms}");
    let dark = runtime.patch_direct(&LightRig::default()).unwrap();
    assert!(dark.iter().all(|h| *h == [0.0; 3]), "without use_scene_emission nothing shines");
}

/// Light at points, free of sampling: H = I cos / d² in the open, exactly.
#[test]
fn a_lamp_over_a_floor_obeys_the_inverse_square_law() {
    let Some(gpu) = gpu() else { return };
    let room = room(&[wall([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [2, 2])]);
    let runtime = runtime(&gpu, &room, &Params { patch_samples: 4, ..Params::default() });
    let position: Vec<[f32; 3]> = (0..200).map(|i| [0.019 * i as f32 - 1.9, 0.3, 0.0]).collect();
    let normal = vec![[0.0, 0.0, 1.0]; 200];
    let empty = |n: usize| PointRows::Interpolated(Rows { row_start: vec![0; n + 1], ..Rows::default() });
    let rows = empty(200);
    let lamp = Light::Point { position: [0.1, 0.2, 1.5], intensity: [6.0, 3.0, 1.0] };
    let found = runtime.relight_points(&rig(lamp), &position, &normal, &rows).unwrap().direct;
    for (p, h) in position.iter().zip(&found) {
        let d2 = (p[0] - 0.1).powi(2) + 0.01 + 1.5 * 1.5;
        let expected = 6.0 * 1.5 / (d2 * d2.sqrt());
        assert!((h[0] - expected).abs() < 1e-4 * expected, "at {p:?}: {} instead of {expected}", h[0]);
    }
    // Points that face away are dark, and so are points under the floor.
    let away = runtime.relight_points(&rig(lamp), &position, &vec![[0.0, 0.0, -1.0]; 200], &rows).unwrap().direct;
    let below: Vec<[f32; 3]> = position.iter().map(|p| [p[0], p[1], -0.5]).collect();
    let below = runtime.relight_points(&rig(lamp), &below, &normal, &rows).unwrap().direct;
    assert!(away.iter().chain(&below).all(|h| *h == [0.0; 3]));
    let text = runtime.relight_points(&rig(lamp), &position, &normal, &empty(199)).unwrap_err().to_string();
    assert_eq!(text, "200 points have 200 normals and 199 rows of weights");
}

/// A closed room stays dark but for points within a texel of where a wall stands on the floor: 5 mm of 4 m here, so
/// 0.2 % of the light that would fall in without walls, and a few of a patch's 32 points at worst. Rays have none of it.
#[test]
fn a_closed_room_is_dark_under_lamps_outside() {
    let Some(gpu) = gpu() else { return };
    let room = room(&inside([0.0; 3], [4.0, 4.0, 3.0], 6));
    let runtime = runtime(&gpu, &room, &Params::default());
    // What each brings to a surface that faces it in the middle of the room, W/m2.
    for (open, light) in [
        (6.2, Light::Point { position: [6.0, 2.0, 1.5], intensity: [100.0; 3] }),
        (10.0, Light::Directional { direction: [0.3, 0.5, -1.0], irradiance: [10.0; 3] }),
        (
            9.0,
            Light::Quad {
                corner: [1.0, 3.0, 3.5],
                edge_u: [2.0, 0.0, 0.0],
                edge_v: [0.0, -2.0, 0.0],
                radiance: [9.0; 3],
            },
        ),
    ] {
        let found = runtime.patch_direct(&rig(light)).unwrap();
        let values = found.as_flattened();
        let mean = values.iter().sum::<f32>() / values.len() as f32 / open;
        let brightest = values.iter().fold(0.0f32, |m, &h| m.max(h)) / open;
        println!("{}: mean {:.4} %, brightest patch {:.3} %", light.kind(), 100.0 * mean, 100.0 * brightest);
        assert!(mean < 0.001 && brightest < 0.03, "{} leaks {mean}, brightest {brightest}", light.kind());
    }
}

#[test]
fn the_same_frame_has_the_same_bits() {
    let Some(gpu) = gpu() else { return };
    let room = cornell(4);
    let runtime = runtime(&gpu, &room, &Params::default());
    let rig = rig(lights()[3].1);
    assert_eq!(runtime.relight(&rig).unwrap(), runtime.relight(&rig).unwrap());
}
