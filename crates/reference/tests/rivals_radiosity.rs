//! Virtual lights, radiosity by gathering and by shooting, against closed forms and the path tracer.

mod common;
#[path = "common/cut.rs"]
mod cut;

use common::{emission, empty, furnace, paint, rig, sheet, with};
use cut::{by_rays, cut};
use glam::Vec3;
use radfile::{FormFactors, Quiet};
use reference::{
    Sampling, Stop,
    rivals::{InstantParams, InstantRadiosity, PatchLight, Radiosity, Rival, Setting, Shooting, ShootingParams},
};
use scene::{Folder, ImportOptions, LightRig, NO_TRIANGLE, Rays, Scene, SurfacePoint, Surfaces};

/// Hands a setting to `work`.
fn set<T>(scene: &Scene, receivers: &[SurfacePoint], work: impl FnOnce(Setting) -> T) -> T {
    let rays = Rays::new(&scene.mesh);
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials).expect("textures of the tests are sound");
    work(Setting { scene, surfaces: &surfaces, rays: &rays, receivers })
}

fn receiver(position: [f32; 3], normal: Vec3) -> SurfacePoint {
    SurfacePoint { position: Vec3::from(position), normal, triangle: NO_TRIANGLE }
}

/// Direct and indirect irradiance by the path tracer, and their standard errors, mean of the channels.
fn truth(scene: &Scene, rig: &LightRig, receivers: &[SurfacePoint], samples: u32) -> [Vec<(f64, f64)>; 2] {
    let position: Vec<[f64; 3]> = receivers.iter().map(|r| r.position.as_dvec3().to_array()).collect();
    let normal: Vec<[f32; 3]> = receivers.iter().map(|r| r.normal.to_array()).collect();
    let sampling = Sampling { stop: Stop::Samples(samples), seed: 1 };
    let points = with(scene, rig, |tracer| tracer.points(&position, &normal, &sampling, &Quiet)).0;
    let grey = |m: reference::Measured| (mean(&m.value), mean(&m.error));
    [points.iter().map(|p| grey(p.direct)).collect(), points.iter().map(|p| grey(p.indirect)).collect()]
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Grey values of an answer.
fn grey(light: &[[f32; 3]]) -> Vec<f64> {
    light.iter().map(|c| mean(&c.map(f64::from))).collect()
}

/// Virtual lights of several seeds: mean over them of the mean over receivers, and its standard error.
fn instant(setting: Setting, rig: &LightRig, params: InstantParams, seeds: u32) -> (f64, f64) {
    let one =
        |seed| mean(&grey(&InstantRadiosity::new(setting, InstantParams { seed, ..params }).indirect(rig, &Quiet)));
    let each: Vec<f64> = (0..seeds).map(one).collect();
    let middle = mean(&each);
    let variance = each.iter().map(|x| (x - middle).powi(2)).sum::<f64>() / f64::from(seeds - 1);
    (middle, (variance / f64::from(seeds)).sqrt())
}

/// A corner of three sheets below a roof, open to two sides; `lamp` is the radiance of the roof's lower side.
fn porch(lamp: f32) -> Scene {
    let mut scene = empty();
    let (red, pale) = (paint(&mut scene, [0.8, 0.3, 0.2], [0.0; 3]), paint(&mut scene, [0.7; 3], [0.0; 3]));
    let roof = paint(&mut scene, [0.5; 3], [lamp; 3]);
    sheet(&mut scene, pale, Vec3::ZERO, Vec3::Z * 3.0, Vec3::X * 4.0);
    sheet(&mut scene, red, Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 2.0);
    sheet(&mut scene, pale, Vec3::ZERO, Vec3::Y * 2.0, Vec3::Z * 3.0);
    sheet(&mut scene, roof, Vec3::new(1.0, 2.0, 0.0), Vec3::X, Vec3::Z);
    scene
}

const LIGHTS: [&str; 5] = [
    r#"{"type":"point","position":[1,1.2,2],"intensity":[3,2,1]}"#,
    r#"{"type":"spot","position":[3,1.8,2.5],"direction":[-1,-1,-1],"intensity":[9,5,1],"half_angle_deg":40,"penumbra_deg":20}"#,
    r#"{"type":"directional","direction":[-1,-2,-1.5],"irradiance":[4,5,6]}"#,
    r#"{"type":"quad","corner":[2,1.5,1],"edge_u":[1,0,0],"edge_v":[0,0.3,1],"radiance":[2,4,6]}"#,
    r#"{"type":"sky","radiance":[1,2,3]}"#,
];

#[test]
fn virtual_lights_of_every_kind_of_light_have_no_bias() {
    let at = [
        receiver([1.3, 0.0, 1.1], Vec3::Y),
        receiver([2.9, 0.0, 2.0], Vec3::Y),
        receiver([2.2, 0.9, 0.0], Vec3::Z),
        receiver([0.0, 1.1, 1.7], Vec3::X),
    ];
    let (dark, lit) = (porch(0.0), porch(5.0));
    let each = LIGHTS.iter().map(|light| (&dark, rig(light)));
    let all = LightRig { use_scene_emission: true, ..rig(&LIGHTS.join(",")) };
    for (scene, rig) in each.chain([(&lit, emission()), (&lit, all)]) {
        let [_, indirect] = truth(scene, &rig, &at, 1 << 14);
        let wanted = mean(&indirect.iter().map(|t| t.0).collect::<Vec<_>>());
        let noise = indirect.iter().map(|t| t.1 * t.1).sum::<f64>().sqrt() / at.len() as f64;
        let params = InstantParams { paths: 1024, nearest: 0.0, seed: 0 };
        let (found, error) = set(scene, &at, |setting| instant(setting, &rig, params, 16));
        assert!(
            (found - wanted).abs() < 4.0 * error.hypot(noise),
            "{found} ± {error}, expected {wanted} ± {noise}: {rig:?}"
        );
        assert!(error < 0.02 * wanted, "{found} ± {error} of {rig:?} shows nothing");
    }
}

#[test]
fn direct_light_is_that_of_the_path_tracer() {
    let at =
        [receiver([1.3, 0.0, 1.1], Vec3::Y), receiver([2.2, 0.9, 0.0], Vec3::Z), receiver([0.0, 1.1, 1.7], Vec3::X)];
    let scene = porch(5.0);
    let all = LightRig { use_scene_emission: true, ..rig(&LIGHTS.join(",")) };
    let [direct, _] = truth(&scene, &all, &at, 1 << 14);
    set(&scene, &at, |setting| {
        let lights = setting.lights(&all);
        for (point, (wanted, error)) in at.iter().zip(direct) {
            let each: Vec<f64> =
                (0..64).map(|seed| mean(&lights.irradiance(point, 64, seed).as_dvec3().to_array())).collect();
            let found = mean(&each);
            let own = (each.iter().map(|x| (x - found).powi(2)).sum::<f64>() / 63.0 / 64.0).sqrt();
            assert!((found - wanted).abs() < 4.0 * error.hypot(own), "{found} ± {own}, expected {wanted} ± {error}");
            assert!(own < 0.01 * wanted, "± {own} of {wanted} shows nothing");
        }
    });
}

#[test]
fn virtual_lights_light_a_furnace_as_the_closed_form_does() {
    // E = ρ / (1 - ρ) π L of all bounces, L = 2.
    let scene = furnace(0.6, 2.0, Vec3::new(2.0, 3.0, 4.0));
    let at = [receiver([1.0, 0.0, 2.0], Vec3::Y), receiver([0.0, 1.5, 1.5], Vec3::X)];
    let wanted = 0.6 / 0.4 * 2.0 * std::f64::consts::PI;
    let params = InstantParams { paths: 1024, nearest: 0.0, seed: 0 };
    let (found, error) = set(&scene, &at, |setting| instant(setting, &emission(), params, 16));
    assert!((found - wanted).abs() < 4.0 * error && error < 0.02 * wanted, "{found} ± {error}, expected {wanted}");
    let (clamped, _) = set(&scene, &at, |s| instant(s, &emission(), InstantParams { nearest: 4.0, ..params }, 16));
    assert!(clamped < 0.95 * wanted, "clamping loses light: {clamped}, {wanted} without");
}

const LIGHT: PatchLight = PatchLight { points: 16, samples: 4 };
/// Nothing is left.
const ALL: ShootingParams = ShootingParams { shots: 1 << 20, unshot: 1e-5, ambient: false };

#[test]
fn radiosity_in_a_furnace_is_the_closed_form_bounce_by_bounce() {
    // Every patch sees all patches by their area, as on a sphere; all have E = π L.
    let (rho, scene) = (0.6, furnace(0.6, 2.0, Vec3::new(1.0, 2.0, 3.0)));
    let patches = cut(&scene, 0.4);
    let (n, all) = (patches.len(), patches.area.iter().sum::<f32>());
    let values = (0..n * n).map(|at| patches.area[at % n] / all).collect();
    let f = FormFactors { values, sky: vec![0.0; n].into() };
    let at = [receiver([0.5, 0.0, 1.0], Vec3::Y), receiver([0.0, 0.5, 1.5], Vec3::X)];
    let close = |found: Vec<[f32; 3]>, share: f64| {
        let wanted = share * rho / (1.0 - rho) * 2.0 * std::f64::consts::PI;
        found.as_flattened().iter().for_each(|&x| assert!((f64::from(x) / wanted - 1.0).abs() < 1e-2, "{x}, {wanted}"));
    };
    set(&scene, &at, |setting| {
        for bounces in [1, 2, 5, 40] {
            let found = Radiosity::new(setting, &patches, &f, bounces, LIGHT).indirect(&emission(), &Quiet);
            close(found, 1.0 - rho.powi(bounces as i32));
        }
        close(Shooting::new(setting, &patches, &f, ALL, LIGHT).indirect(&emission(), &Quiet), 1.0);
        // Before the first shot all that there is is the ambient term.
        let none = ShootingParams { shots: 0, unshot: 0.0, ambient: true };
        close(Shooting::new(setting, &patches, &f, none, LIGHT).indirect(&emission(), &Quiet), 1.0);
    });
}

struct Disk(std::path::PathBuf);

impl Folder for Disk {
    fn read(&self, name: &str) -> std::io::Result<Vec<u8>> {
        std::fs::read(self.0.join(name))
    }

    fn list(&self, _folder: &str) -> Vec<String> {
        vec![]
    }
}

#[test]
fn all_agree_with_the_path_tracer_in_the_cornell_box() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/cornell");
    let options = ImportOptions { one_sided: true };
    let (scene, _) = scene::import("cornell.obj", &Disk(folder.clone()), options).expect("the box");
    let patches = cut(&scene, 0.002);
    let f = by_rays(&scene.mesh, &patches, 512);
    let at: Vec<SurfacePoint> = (0..patches.len())
        .step_by(patches.len() / 40)
        .map(|i| receiver(patches.position[i], Vec3::from(patches.normal[i])))
        .collect();
    for name in ["lamp.json", "point.json"] {
        let rig = LightRig::from_json(&std::fs::read_to_string(folder.join(name)).expect("lights")).expect("lights");
        let [_, indirect] = truth(&scene, &rig, &at, 1 << 11);
        let wanted: Vec<f64> = indirect.iter().map(|t| t.0).collect();
        let noise = indirect.iter().map(|t| t.1 * t.1).sum::<f64>().sqrt() / at.len() as f64;
        let level = mean(&wanted);
        let rms = |found: &[f64], wanted: &[f64]| {
            (found.iter().zip(wanted).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / found.len() as f64).sqrt() / level
        };
        set(&scene, &at, |setting| {
            let gathered =
                |bounces| grey(&Radiosity::new(setting, &patches, &f, bounces, LIGHT).indirect(&rig, &Quiet));
            let (many, one) = (gathered(24), gathered(1));
            assert!(rms(&many, &wanted) < 0.15 && (mean(&many) / level - 1.0).abs() < 0.03, "{many:?}, {wanted:?}");
            assert!(mean(&one) < 0.9 * level, "one bounce is not all");
            let shot = grey(&Shooting::new(setting, &patches, &f, ALL, LIGHT).indirect(&rig, &Quiet));
            assert!(rms(&shot, &many) < 1e-3, "shooting is not gathering: {}", rms(&shot, &many));

            let params = InstantParams { paths: 1024, nearest: 0.0, seed: 0 };
            let (found, error) = instant(setting, &rig, params, 16);
            assert!((found - level).abs() < 4.0 * error.hypot(noise), "{found} ± {error}, expected {level} ± {noise}");
            assert!(error < 0.02 * level, "{found} ± {error} shows nothing");
            let (clamped, _) = instant(setting, &rig, InstantParams { nearest: 0.5, ..params }, 16);
            assert!(clamped < 0.95 * found, "clamping loses light: {clamped}, {found} without");
        });
    }
}
