//! Voxel cone tracing and precomputed transfer against closed forms and against paths.

mod common;
#[path = "../../scene/tests/disk/mod.rs"]
mod disk;

use std::{f64::consts::PI, path::Path};

use common::{emission, empty, furnace, paint, rig, sheet};
use glam::Vec3;
use radfile::Quiet;
use reference::{
    PathTracer, Sampling, Stop,
    rivals::{ConeParams, Harmonics, HarmonicsParams, Rival, Setting, VoxelCones},
};
use scene::{ImportOptions, LightRig, Rays, Scene, Sobol, SurfacePoint, Surfaces, square_to_triangle};

fn with<T>(scene: &Scene, receivers: &[SurfacePoint], work: impl FnOnce(Setting) -> T) -> T {
    let rays = Rays::new(&scene.mesh);
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials).expect("textures of the tests are sound");
    work(Setting { scene, surfaces: &surfaces, rays: &rays, receivers })
}

/// About `count` points on the fronts of a scene.
fn points(scene: &Scene, count: f32) -> Vec<SurfacePoint> {
    let across = |t: usize| {
        let [a, b, c] = scene.mesh.corners(t).map(Vec3::from);
        (a, b, c, (b - a).cross(c - a))
    };
    let triangles = 0..scene.mesh.triangles.len();
    let total: f32 = triangles.clone().map(|t| across(t).3.length()).sum();
    let on = |t: usize| {
        let (a, b, c, normal) = across(t);
        let here = (count * normal.length() / total).round() as u32;
        (0..here).map(move |i| {
            let [x, y, ..] = Sobol::new(t as u32).sample(i);
            let (u, v) = square_to_triangle(x, y);
            let position = a + u * (b - a) + v * (c - a);
            SurfacePoint { position, normal: normal.normalize(), triangle: t as u32 }
        })
    };
    triangles.flat_map(on).collect()
}

fn mean(light: &[[f32; 3]]) -> f64 {
    light.iter().flatten().map(|&x| f64::from(x)).sum::<f64>() / (3 * light.len()) as f64
}

fn harmonics() -> HarmonicsParams {
    HarmonicsParams { centres: 16, bounces: 4, paths: 128, ..HarmonicsParams::default() }
}

#[test]
fn harmonics_give_what_a_wide_floor_reflects_of_the_sky() {
    let mut scene = empty();
    let grey = paint(&mut scene, [0.5; 3], [0.0; 3]);
    sheet(&mut scene, grey, Vec3::new(-500.0, 0.0, -500.0), Vec3::Z * 1000.0, Vec3::X * 1000.0);
    let below = SurfacePoint { position: Vec3::Y, normal: -Vec3::Y, triangle: scene::NO_TRIANGLE };
    let sky = rig(r#"{"type":"sky","radiance":[1,2,3]}"#);
    let params = HarmonicsParams { centres: 0, paths: 1 << 12, ..harmonics() };
    let light = with(&scene, &[below], |s| Harmonics::new(s, params, &Quiet).indirect(&sky, &Quiet))[0];
    for (c, found) in light.into_iter().enumerate() {
        common::close(f64::from(found), 0.5 * PI * (c + 1) as f64, 0.02);
    }
}

#[test]
fn harmonics_in_a_furnace_add_a_bounce_with_each_bounce() {
    let scene = furnace(0.5, 1.0, Vec3::ONE);
    let receivers = points(&scene, 100.0);
    let light = |bounces| {
        let params = HarmonicsParams { bounces, light_samples: 2048, ..harmonics() };
        with(&scene, &receivers, |s| mean(&Harmonics::new(s, params, &Quiet).indirect(&emission(), &Quiet)))
    };
    let (one, two, all) = (light(1), light(2), light(24));
    common::close(two, 1.5 * one, 0.03);
    common::close(all, 2.0 * one, 0.03);
    // ρ / (1 − ρ) π L; centres near walls are lit by few of the points that stand for their light.
    common::close(all, PI, 0.15);
}

#[test]
fn cones_in_a_furnace_see_the_same_light_everywhere() {
    let scene = furnace(0.5, 1.0, Vec3::ONE);
    let receivers = points(&scene, 200.0);
    let light = |bounces| {
        let params = ConeParams { resolution: 32, bounces, ..ConeParams::default() };
        with(&scene, &receivers, |s| mean(&VoxelCones::new(s, params).indirect(&emission(), &Quiet)))
    };
    let (one, two) = (light(1), light(2));
    println!("furnace: {} and {} of the truth", one / (0.5 * PI), two / (0.75 * PI));
    // Known error: cones miss what is nearer than their start, and are not all held back by walls seen at a slant.
    common::close(one, 0.5 * PI, 0.1);
    common::close(two, 0.75 * PI, 0.12);
}

#[test]
fn voxels_take_no_more_than_is_asked_for() {
    let scene = furnace(0.5, 1.0, Vec3::new(1.0, 2.0, 3.0));
    with(&scene, &[], |s| {
        for resolution in [2, 17, 64] {
            let params = ConeParams { resolution, ..ConeParams::default() };
            let (need, has) = (VoxelCones::bytes_needed(&s, &params), VoxelCones::new(s, params).bytes());
            assert!(has <= need && need < 12 * has, "{has} bytes of {need} at {resolution} cells");
        }
    });
}

#[test]
fn both_are_linear_in_the_lights() {
    let scene = furnace(0.5, 0.0, Vec3::ONE);
    let receivers = points(&scene, 60.0);
    let lamp = |i: f32| rig(&format!(r#"{{"type":"point","position":[0.4,0.5,0.6],"intensity":[{i},{i},{i}]}}"#));
    with(&scene, &receivers, |setting| {
        let cones = ConeParams { resolution: 16, ..ConeParams::default() };
        let rivals: [Box<dyn Rival + '_>; 2] =
            [Box::new(Harmonics::new(setting, harmonics(), &Quiet)), Box::new(VoxelCones::new(setting, cones))];
        for mut rival in rivals {
            let name = rival.name();
            let [none, once, twice] =
                [LightRig::default(), lamp(1.0), lamp(2.0)].map(|rig| rival.indirect(&rig, &Quiet));
            assert!(none.iter().flatten().all(|&x| x == 0.0), "{name}: there is light without lights");
            assert!(mean(&once) > 0.0, "{name}: there is none with a lamp");
            for (once, twice) in once.iter().flatten().zip(twice.iter().flatten()) {
                assert!((twice - 2.0 * once).abs() <= 1e-4 * twice.abs() + 1e-6, "{name}: {once} and {twice}");
            }
        }
    });
}

#[test]
fn both_are_about_right_in_the_cornell_box() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/cornell");
    let (scene, _) =
        scene::import("cornell.obj", &disk::Disk(folder.clone()), ImportOptions::default()).expect("a sound scene");
    let receivers = points(&scene, 300.0);
    with(&scene, &receivers, |setting| {
        let params = HarmonicsParams { centres: 32, paths: 256, ..harmonics() };
        let cones = ConeParams::default();
        let mut rivals: [Box<dyn Rival + '_>; 2] =
            [Box::new(Harmonics::new(setting, params, &Quiet)), Box::new(VoxelCones::new(setting, cones))];
        for lights in ["lamp", "point"] {
            let text = std::fs::read_to_string(folder.join(lights).with_extension("json")).expect("a lights file");
            let rig = LightRig::from_json(&text).expect("a sound lights file");
            let position: Vec<_> = receivers.iter().map(|r| r.position.as_dvec3().to_array()).collect();
            let normal: Vec<_> = receivers.iter().map(|r| r.normal.to_array()).collect();
            let sampling = Sampling { stop: Stop::Samples(256), seed: 3 };
            let tracer = PathTracer::new(setting.scene, setting.surfaces, setting.rays, &rig);
            let (truth, _) = tracer.points(&position, &normal, &sampling, &Quiet);
            for rival in &mut rivals {
                let light = rival.indirect(&rig, &Quiet);
                let wanted: Vec<[f32; 3]> = truth.iter().map(|t| t.indirect.value.map(|x| x as f32)).collect();
                let bias = mean(&light) / mean(&wanted) - 1.0;
                let squares = light.iter().zip(&wanted).map(|(a, b)| Vec3::from(*a).distance_squared(Vec3::from(*b)));
                let rms = (squares.map(f64::from).sum::<f64>() / (3 * light.len()) as f64).sqrt() / mean(&wanted);
                println!("{lights}, {}: bias {:+.0} %, RMS {:.0} %", rival.name(), 100.0 * bias, 100.0 * rms);
                assert!(bias.abs() < 0.3 && rms < 0.5, "{lights}, {}: {bias} and {rms}", rival.name());
            }
        }
    });
}
