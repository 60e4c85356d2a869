//! Interreflection against what energy says, and what standard errors promise.

mod common;

use std::f64::consts::PI;

use common::{At, close, emission, empty, furnace, one, paint, rig, room, sheet, trace, with, within};
use glam::Vec3;
use radfile::Quiet;
use reference::{FLOOR, Sampling, Stop};
use scene::{Camera, Scene, Sobol};

const UP: [f32; 3] = [0.0, 1.0, 0.0];

/// Points all over the walls of a room, as many on each as its share of the area.
fn on_walls(size: Vec3, count: u32) -> Vec<At> {
    let [a, b, c] = [size.y * size.z, size.x * size.z, size.x * size.y];
    let sobol = Sobol::new(5);
    (0..count)
        .map(|i| {
            let [x, y, pick, side] = sobol.sample(i);
            let axis = match pick * (a + b + c) {
                p if p < a => 0,
                p if p < a + b => 1,
                _ => 2,
            };
            let (mut point, mut normal) = ([0.0; 3], [0.0; 3]);
            (point[(axis + 1) % 3], point[(axis + 2) % 3]) =
                (f64::from(x * size[(axis + 1) % 3]), f64::from(y * size[(axis + 2) % 3]));
            (point[axis], normal[axis]) = if side < 0.5 { (0.0, 1.0) } else { (f64::from(size[axis]), -1.0) };
            (point, normal)
        })
        .collect()
}

#[test]
fn in_a_furnace_light_is_the_same_everywhere_and_known() {
    for rho in [0.5f64, 0.9] {
        let scene = furnace(rho as f32, 1.0, Vec3::new(2.0, 1.0, 3.0));
        for (position, normal) in [([0.7, 0.0, 1.1], UP), ([2.0, 0.999, 0.001], [-1.0, 0.0, 0.0])] {
            let light = one(&scene, &emission(), position, normal, 1 << 13);
            within(light.direct, PI, 4.0, 0.004);
            within(light.single, rho * PI, 4.0, 0.006);
            within(light.indirect, rho / (1.0 - rho) * PI, 4.0, 0.03);
        }
    }
}

#[test]
fn a_furnace_of_one_percent_converges_fast() {
    let scene = furnace(0.5, 1.0, Vec3::ONE);
    let stop = Stop::RelativeError { error: 0.01, max_samples: 1 << 18 };
    let (light, report) = trace(&scene, &emission(), &[([0.5, 0.0, 0.5], UP)], stop, 1);
    assert!(report.points_short_of_error == 0 && light[0].samples <= 6000, "{} paths", light[0].samples);
    within(light[0].indirect, PI, 4.0, 0.01);
}

/// White furnace: with emission 1 - ρ every surface has the radiance 1, whatever its ρ, so E = π.
#[test]
fn in_a_white_furnace_of_several_paints_irradiance_is_pi() {
    let mut scene = empty();
    let paints = [0.2f32, 0.5, 0.85].map(|rho| paint(&mut scene, [rho; 3], [1.0 - rho; 3]));
    room(&mut scene, paints[0], Vec3::ZERO, Vec3::splat(3.0));
    // A box within; its fronts look outwards where the axes are mirrored.
    room(&mut scene, paints[1], Vec3::new(1.8, 1.0, 1.8), Vec3::splat(-0.8));
    sheet(&mut scene, paints[2], Vec3::new(0.001, 0.0, 0.0), Vec3::Y * 2.0, Vec3::Z * 2.0);
    for (position, normal) in [([2.0, 0.0, 0.4], UP), ([1.4, 1.0, 1.4], UP), ([0.001, 0.3, 0.3], [1.0, 0.0, 0.0])] {
        let light = one(&scene, &emission(), position, normal, 1 << 15);
        let total = light.direct.value[0] + light.indirect.value[0];
        let error = light.direct.error[0] + light.indirect.error[0];
        assert!((total - PI).abs() < 4.0 * error && error < 0.03 * PI, "{total} ± {error} at {position:?}");
    }
}

/// CIE 171:2006, test 5.8: in a closed room of uniform ρ the area mean of indirect irradiance is
/// Φ ρ / (S (1 - ρ)), here of 10,000 lm in a cube of 4 m, whose mean direct irradiance is 104.17 lx.
#[test]
fn the_mean_over_a_room_is_that_of_cie_test_5_8() {
    let size = Vec3::splat(4.0);
    let intensity = 10_000.0 / (4.0 * PI);
    let lamp =
        rig(&format!(r#"{{"type":"point","position":[2,2,2],"intensity":[{intensity},{intensity},{intensity}]}}"#));
    for rho in [0.1f64, 0.5, 0.9] {
        let (_, report) = trace(&furnace(rho as f32, 0.0, size), &lamp, &on_walls(size, 1024), Stop::Samples(512), 3);
        close(report.mean_direct[0], 10_000.0 / 96.0, 2e-3);
        close(report.mean_indirect[0], 10_000.0 / 96.0 * rho / (1.0 - rho), 6e-3);
    }
}

#[test]
fn a_sealed_room_is_exactly_dark_behind_a_wall_without_thickness() {
    let mut scene = empty();
    let white = paint(&mut scene, [0.9; 3], [0.0; 3]);
    room(&mut scene, white, Vec3::new(-3.3, 0.1, 0.7), Vec3::new(3.3, 2.0, 2.0));
    room(&mut scene, white, Vec3::new(0.0, 0.1, 0.7), Vec3::new(2.7, 2.0, 2.0));
    let lamp = rig(r#"{"type":"point","position":[-1,1,1.7],"intensity":[10,10,10]}"#);
    let size = Vec3::new(2.7, 2.0, 2.0);
    let mut points = on_walls(size, 64);
    points.iter_mut().for_each(|(p, _)| (p[1], p[2]) = (p[1] + 0.1, p[2] + 0.7));
    let (light, report) = trace(&scene, &lamp, &points, Stop::Samples(4096), 1);
    assert!(report.rays > 1_000_000);
    for (light, at) in light.iter().zip(&points) {
        assert_eq!((light.direct.value, light.indirect.value), ([0.0; 3], [0.0; 3]), "{at:?}");
    }
}

#[test]
fn one_sided_backs_are_black_and_two_sided_ones_reflect() {
    // A sheet that shows its back to the floor.
    let mut scene = empty();
    let white = paint(&mut scene, [0.8; 3], [0.0; 3]);
    sheet(&mut scene, white, Vec3::new(-1.0, 1.0, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0);
    let lamp = rig(r#"{"type":"point","position":[0,0.5,0.9],"intensity":[1,1,1]}"#);
    let light = |scene: &Scene| one(scene, &lamp, [0.0; 3], UP, 1024).indirect.value[0];
    assert!(light(&scene) > 0.05);
    scene.mesh.one_sided = true;
    assert_eq!(light(&scene), 0.0);
}

/// Standard errors are honest: over seeds, the truth is within one of them for about 68 %, within two for 95 %.
#[test]
fn standard_errors_are_calibrated() {
    let rho = 0.7f64;
    let scene = furnace(rho as f32, 1.0, Vec3::new(2.0, 1.0, 3.0));
    let truth = [PI, rho * PI, rho / (1.0 - rho) * PI];
    for (stop, seeds) in [(Stop::Samples(1024), 600), (Stop::RelativeError { error: 0.02, max_samples: 1 << 16 }, 200)]
    {
        let mut z: [Vec<f64>; 3] = Default::default();
        for seed in 0..seeds {
            let (light, _) = trace(&scene, &emission(), &[([0.7, 0.0, 1.1], UP)], stop, seed);
            for (z, (m, truth)) in
                z.iter_mut().zip([light[0].direct, light[0].single, light[0].indirect].iter().zip(truth))
            {
                z.push((m.value[0] - truth) / m.error[0]);
            }
        }
        for z in z {
            let n = z.len() as f64;
            let within = |sigmas: f64| z.iter().filter(|z| z.abs() <= sigmas).count() as f64 / n;
            let mean = z.iter().sum::<f64>() / n;
            // Counts of 600 (200) seeds scatter by 2 % (3 %), their mean by 0.04 (0.07).
            assert!((0.60..0.76).contains(&within(1.0)), "{} within one, {stop:?}", within(1.0));
            assert!((0.90..0.985).contains(&within(2.0)), "{} within two, {stop:?}", within(2.0));
            assert!(mean.abs() < 0.25, "mean z {mean}, {stop:?}");
        }
    }
}

#[test]
fn the_relative_error_that_was_asked_for_is_reached_or_told() {
    let size = Vec3::new(2.0, 1.0, 3.0);
    let scene = furnace(0.8, 0.0, size);
    let lamp = rig(r#"{"type":"point","position":[0.3,0.8,0.3],"intensity":[1,2,3]}"#);
    let points = on_walls(size, 32);
    let luminance = |rgb: [f64; 3]| 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    let stop = Stop::RelativeError { error: 0.02, max_samples: 1 << 16 };
    let (light, report) = trace(&scene, &lamp, &points, stop, 1);
    assert_eq!(report.points_short_of_error, 0);
    let least = FLOOR * luminance(report.mean_indirect);
    for point in &light {
        // The paint is grey and the lamp is not: channels are in proportion, so are their errors.
        let error = luminance(point.indirect.error);
        assert!(error <= 0.0201 * luminance(point.indirect.value).max(least), "{point:?}");
    }
    let stop = Stop::RelativeError { error: 1e-4, max_samples: 1000 };
    let (light, report) = trace(&scene, &lamp, &points, stop, 1);
    assert_eq!(report.points_short_of_error, 32);
    assert!(light.iter().all(|p| (1000..1064).contains(&p.samples)));
}

#[test]
fn answers_are_the_same_bits_for_any_number_of_threads_and_others_for_other_seeds() {
    let size = Vec3::new(2.0, 1.0, 3.0);
    let scene = furnace(0.6, 0.5, size);
    let mut lights = rig(r#"{"type":"point","position":[0.3,0.8,0.3],"intensity":[1,1,1]}"#);
    lights.use_scene_emission = true;
    let stop = Stop::RelativeError { error: 0.03, max_samples: 1 << 14 };
    let in_pool = |threads: usize, seed: u32| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| trace(&scene, &lights, &on_walls(size, 16), stop, seed))
    };
    assert_eq!(in_pool(1, 4), in_pool(3, 4));
    assert_ne!(in_pool(1, 4).0, in_pool(1, 5).0);
}

#[test]
fn a_picture_shows_radiance_emission_and_sky() {
    // A lamp of 1 m at z = -1 that looks at the camera, with a black border of sky.
    let mut scene = empty();
    let lamp = paint(&mut scene, [0.0; 3], [2.0, 3.0, 4.0]);
    let white = paint(&mut scene, [0.5; 3], [0.0; 3]);
    sheet(&mut scene, lamp, Vec3::new(-1.0, -0.5, -1.0), Vec3::X, Vec3::Y);
    sheet(&mut scene, white, Vec3::new(0.0, -0.5, -1.0), Vec3::X, Vec3::Y);
    let mut lights = rig(
        r#"{"type":"directional","direction":[0,0,-1],"irradiance":[3.14159265,0,0]},{"type":"sky","radiance":[0,0,1]}"#,
    );
    let camera = Camera { origin: [0.0; 3], target: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0], fov_x_deg: 90.0 };
    let picture =
        |lights: &_, stop| with(&scene, lights, |t| t.picture(&camera, [4, 4], &Sampling { stop, seed: 1 }, &Quiet));
    let (shown, report) = picture(&lights, Stop::Samples(64));
    assert_eq!((report.paths, shown.pixels.len()), (1024, 16));
    assert_eq!(shown.pixels[0], [0.0, 0.0, 1.0], "the first row is above both sheets");
    assert_eq!(shown.pixels[4], [0.0; 3], "the lamp is off, and black");
    let white = shown.pixels[4 + 3];
    assert!((white[0] - 0.5).abs() < 1e-4 && (white[2] - 0.5).abs() < 1e-4, "{white:?}: ρ E / π of sun and sky");
    lights.use_scene_emission = true;
    let (shown, report) = picture(&lights, Stop::RelativeError { error: 0.01, max_samples: 1 << 12 });
    assert_eq!((shown.pixels[4], report.pixels_short_of_error), ([2.0, 3.0, 4.0], 0));
}

#[test]
fn a_scene_far_from_the_origin_is_as_good_as_one_near_it() {
    let mut scene = furnace(0.5, 0.0, Vec3::splat(2.0));
    scene.mesh.origin = [487_000.0, 300.0, 5_450_000.0];
    let lamp = rig(r#"{"type":"point","position":[487001,301,5450001],"intensity":[1,1,1]}"#);
    let light = one(&scene, &lamp, [487_001.0, 300.0, 5_450_001.0], UP, 64);
    close(light.direct.value[0], 1.0, 1e-4);
    assert!(light.indirect.value[0] > 0.1);
}
