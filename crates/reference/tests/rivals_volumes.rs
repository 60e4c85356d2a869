//! Reflective shadow maps and light propagation volumes against the path tracer.

mod common;

use std::{fs, io, path::PathBuf};

use common::{empty, furnace, paint, rig, sheet};
use glam::{DVec3, Vec3};
use radfile::Quiet;
use reference::{
    PathTracer, PointEstimate, Sampling, Stop,
    rivals::{LightPropagationVolumes, ReflectiveShadowMaps, Rival, Setting, ShadowMapParams, VolumeParams},
};
use scene::{Folder, ImportOptions, LightRig, NO_TRIANGLE, Rays, Scene, SurfacePoint, Surfaces, import};

/// What a rival is made of; the rest is asked of it.
type Make = for<'a> fn(Setting<'a>) -> Box<dyn Rival + 'a>;

fn receiver(position: Vec3, normal: Vec3) -> SurfacePoint {
    SurfacePoint { position, normal, triangle: NO_TRIANGLE }
}

fn with_setting<T>(scene: &Scene, receivers: &[SurfacePoint], work: impl FnOnce(Setting) -> T) -> T {
    let rays = Rays::new(&scene.mesh);
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials).expect("textures of the tests are sound");
    work(Setting { scene, surfaces: &surfaces, rays: &rays, receivers })
}

/// What a rival says, and what is true.
fn both(scene: &Scene, rig: &LightRig, at: &[SurfacePoint], paths: u32, make: Make) -> (Vec<Vec3>, Vec<PointEstimate>) {
    with_setting(scene, at, |setting| {
        let found = make(setting).indirect(rig, &Quiet);
        let position: Vec<[f64; 3]> =
            at.iter().map(|p| (p.position.as_dvec3() + DVec3::from(scene.mesh.origin)).to_array()).collect();
        let normal: Vec<[f32; 3]> = at.iter().map(|p| p.normal.to_array()).collect();
        let sampling = Sampling { stop: Stop::Samples(paths), seed: 1 };
        let tracer = PathTracer::new(scene, setting.surfaces, setting.rays, rig);
        let truth = tracer.points(&position, &normal, &sampling, &Quiet).0;
        (found.into_iter().map(Vec3::from).collect(), truth)
    })
}

/// Mean over points and channels.
fn mean(values: impl ExactSizeIterator<Item = [f64; 3]>) -> f64 {
    let n = values.len() as f64;
    values.flatten().sum::<f64>() / (3.0 * n)
}

fn mean_found(found: &[Vec3]) -> f64 {
    mean(found.iter().map(|v| v.as_dvec3().to_array()))
}

struct Assets;

impl Folder for Assets {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        fs::read(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../assets/cornell").join(name))
    }

    fn list(&self, _folder: &str) -> Vec<String> {
        Vec::new()
    }
}

/// The Cornell box, a light over it, and points on its floor, ceiling and two walls.
fn cornell(lights: &str) -> (Scene, LightRig, Vec<SurfacePoint>) {
    let (scene, _) = import("cornell.obj", &Assets, ImportOptions::default()).expect("the box of the repository");
    let text = String::from_utf8(Assets.read(lights).expect("lights of the repository")).expect("text");
    let at = |i: usize| 0.06 + 0.43 * (i as f32 + 0.5) / 6.0;
    let mut points = Vec::new();
    for (i, j) in (0..36).map(|k| (k % 6, k / 6)) {
        let (a, b) = (at(i), at(j));
        points.push(receiver(Vec3::new(a, 0.5488, b), -Vec3::Y));
        points.push(receiver(Vec3::new(a, b, 0.5592), -Vec3::Z));
        points.push(receiver(Vec3::new(0.0, a, b), Vec3::X));
        // The boxes stand on the rest of the floor.
        points.push(receiver(Vec3::new(a, 0.0, 0.06 * (j as f32 + 0.5) / 6.0), Vec3::Y));
    }
    (scene, LightRig::from_json(&text).expect("sound lights"), points)
}

/// A floor of 4 m and a wall along its edge.
fn corner() -> Scene {
    let mut scene = empty();
    let grey = paint(&mut scene, [0.5; 3], [0.0; 3]);
    sheet(&mut scene, grey, Vec3::new(-2.0, 0.0, -2.0), Vec3::Z * 4.0, Vec3::X * 4.0);
    sheet(&mut scene, grey, Vec3::new(-2.0, 0.0, -2.0), Vec3::Y * 3.0, Vec3::Z * 4.0);
    scene
}

#[test]
fn where_nothing_is_hidden_shadow_maps_are_one_bounce() {
    let scene = corner();
    let lights = [
        r#"{"type":"point","position":[0.2,1.5,0.3],"intensity":[10,5,2]}"#,
        r#"{"type":"spot","position":[1,2,0],"direction":[-2,-1,0],"intensity":[10,5,2],"half_angle_deg":35,"penumbra_deg":9}"#,
        r#"{"type":"directional","direction":[-1,-1,0.2],"irradiance":[10,5,2]}"#,
        r#"{"type":"quad","corner":[0.5,2,-0.5],"edge_u":[1,0,0],"edge_v":[0,0,1],"radiance":[9,5,2]}"#,
        r#"{"type":"sky","radiance":[2,1,1]}"#,
    ];
    let at: Vec<SurfacePoint> = (1..7)
        .flat_map(|i| {
            let far = 0.5 * i as f32;
            [
                receiver(Vec3::new(far - 2.0, 0.0, 0.2 * far - 0.4), Vec3::Y),
                receiver(Vec3::new(-2.0, 0.8 * far, 0.3), Vec3::X),
            ]
        })
        .collect();
    for light in lights {
        // Maps of the sky are many and small, and share the samples.
        let tolerance = if light.contains("sky") { 0.05 } else { 0.04 };
        let make: Make = |setting| {
            let params = ShadowMapParams { side: 1024, samples: 1 << 16, shared_maps: 256, offset: 1e-3, reach: 1.0 };
            Box::new(ReflectiveShadowMaps::new(setting, params))
        };
        let (found, truth) = both(&scene, &rig(light), &at, 1 << 14, make);
        for (p, (found, truth)) in found.iter().zip(&truth).enumerate() {
            for c in 0..3 {
                let (found, truth) = (f64::from(found[c]), truth.single.value[c]);
                assert!((found - truth).abs() < tolerance * truth, "{light}, point {p}: {found}, expected {truth}");
            }
        }
    }
}

#[test]
fn in_an_empty_room_shadow_maps_are_one_bounce() {
    let room = furnace(0.5, 0.0, Vec3::ONE);
    let bulb = rig(r#"{"type":"point","position":[0.3,0.6,0.4],"intensity":[1,1,1]}"#);
    let at: Vec<SurfacePoint> = (0..36)
        .flat_map(|k| {
            let (a, b) = ((k % 6) as f32 / 6.0 + 0.08, (k / 6) as f32 / 6.0 + 0.08);
            [receiver(Vec3::new(a, 0.0, b), Vec3::Y), receiver(Vec3::new(0.0, a, b), Vec3::X)]
        })
        .collect();
    let make: Make = |setting| Box::new(ReflectiveShadowMaps::new(setting, ShadowMapParams::default()));
    let (found, truth) = both(&room, &bulb, &at, 1024, make);
    let share = mean_found(&found) / mean(truth.iter().map(|t| t.single.value));
    assert!((share - 1.0).abs() < 0.02, "{share} of one bounce");
}

#[test]
fn less_reach_leaves_light_out() {
    let scene = corner();
    let lamp = rig(r#"{"type":"point","position":[0.2,1.5,0.3],"intensity":[10,5,2]}"#);
    let at = [receiver(Vec3::new(-2.0, 1.0, 0.3), Vec3::X)];
    let light = |reach: f32| {
        let params = ShadowMapParams { samples: 8192, reach, ..ShadowMapParams::default() };
        with_setting(&scene, &at, |s| ReflectiveShadowMaps::new(s, params).indirect(&lamp, &Quiet))[0][0]
    };
    let (near, all) = (light(0.3), light(1.0));
    assert!(near < 0.9 * all && near > 0.1 * all, "{near} of {all}");
}

fn shadow_maps<'a>(setting: Setting<'a>) -> Box<dyn Rival + 'a> {
    let params = ShadowMapParams { side: 128, samples: 1024, ..ShadowMapParams::default() };
    Box::new(ReflectiveShadowMaps::new(setting, params))
}

fn volumes<'a>(setting: Setting<'a>) -> Box<dyn Rival + 'a> {
    let params = VolumeParams { cells: 8, steps: 64, map_side: 64, ..VolumeParams::default() };
    Box::new(LightPropagationVolumes::new(setting, params))
}

#[test]
fn in_the_cornell_box_unhidden_light_is_too_much_and_volumes_lose_some() {
    let (scene, rig, at) = cornell("point.json");
    let (found, truth) = both(&scene, &rig, &at, 256, shadow_maps);
    let single = mean(truth.iter().map(|t| t.single.value));
    let excess = mean_found(&found) / single;
    assert!(excess > 1.0 && excess < 1.5, "shadow maps give {excess} of one bounce: nothing stands in the way");
    let (found, truth) = both(&scene, &rig, &at, 256, volumes);
    let share = mean_found(&found) / mean(truth.iter().map(|t| t.indirect.value));
    assert!(share > 0.75 && share < 1.1, "volumes give {share} of all bounces");
}

#[test]
fn no_light_gives_none_and_threads_change_nothing() {
    for make in [shadow_maps as Make, volumes] {
        let (scene, lamp, at) = cornell("lamp.json");
        with_setting(&scene, &at, |setting| {
            let dark = make(setting).indirect(&LightRig::default(), &Quiet);
            assert!(dark.iter().all(|&light| light == [0.0; 3]));
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
                pool.install(|| make(setting).indirect(&lamp, &Quiet))
            };
            let (one, three) = (on(1), on(3));
            assert!(one == three, "the same bits on one thread and on three");
            assert!(one.iter().flatten().all(|x| x.is_finite() && *x >= 0.0) && one.iter().flatten().any(|x| *x > 0.0));
        });
    }
}
