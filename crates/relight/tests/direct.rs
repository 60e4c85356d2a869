//! Direct light of every type against closed forms.

mod common;

use std::f64::consts::PI;

use common::{Maker, at, emission, patch_irradiance, rig, scene};
use glam::Vec3;
use radfile::Side;
use relight::DirectLight;
use scene::{Rays, Scene, Surfaces};

const UP: Vec3 = Vec3::Y;
/// Receivers are moved off their surface by about 2e-6 of the scene; irradiance changes by a few times that.
const LIFT: f64 = 1e-4;

/// A floor of 4 m about the origin.
fn floor() -> Maker {
    let mut maker = Maker::new(1.0);
    maker.sheet(Vec3::new(-2.0, 0.0, -2.0), Vec3::Z * 4.0, Vec3::X * 4.0, [1, 1], &[Side::Front]);
    maker
}

fn finish(maker: Maker) -> Scene {
    scene(maker.finish().0, 0.5, [0.0; 3])
}

fn close(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance * wanted.abs(), "{found}, expected {wanted}");
}

#[test]
fn a_point_light_falls_off_with_the_square_and_the_cosine() {
    let scene = finish(floor());
    let light = rig(r#"{"type":"point","position":[0.3,1.5,-0.2],"intensity":[10,20,0]}"#);
    for x in [-1.5, 0.0, 0.3, 1.9] {
        let way = [0.3 - x, 1.5, -0.2];
        let square: f64 = way.iter().map(|v| v * v).sum();
        let e = at(&scene, &light, Vec3::new(x as f32, 0.0, 0.0), UP);
        close(e[0], 10.0 * 1.5 / square.powf(1.5), LIFT);
        close(e[1], 2.0 * e[0], 1e-12);
        assert_eq!(e[2], 0.0);
        assert_eq!(at(&scene, &light, Vec3::new(x as f32, 0.0, 0.0), -UP), [0.0; 3], "the other side is dark");
    }
}

#[test]
fn a_spot_is_full_inside_its_cone_and_dark_outside() {
    let scene = finish(floor());
    let spot = |penumbra: f32| {
        rig(&format!(
            r#"{{"type":"spot","position":[0,1,0],"direction":[0,-3,0],"intensity":[1,1,1],
                "half_angle_deg":40,"penumbra_deg":{penumbra}}}"#
        ))
    };
    // Irradiance relative to a point light at the same place.
    let strength = |degrees: f64, penumbra: f32| {
        let angle = degrees.to_radians();
        let e = at(&scene, &spot(penumbra), Vec3::new(angle.tan() as f32, 0.0, 0.0), UP)[0];
        e / angle.cos().powi(3)
    };
    close(strength(39.9, 0.0), 1.0, LIFT);
    assert_eq!(strength(40.1, 0.0), 0.0);
    close(strength(29.9, 10.0), 1.0, LIFT);
    close(strength(35.0, 10.0), 0.5, 1e-3);
    assert_eq!(strength(40.1, 10.0), 0.0);
    let fade: Vec<f64> = (300..=400).map(|d| strength(f64::from(d) / 10.0, 10.0)).collect();
    assert!(fade.windows(2).all(|w| w[0] >= w[1] - 1e-5), "the penumbra only falls: {fade:?}");
}

#[test]
fn parallel_light_lights_by_the_cosine_and_is_stopped_by_anything() {
    let mut maker = floor();
    maker.sheet(Vec3::new(0.5, 5.0, -9.0), Vec3::X * 9.0, Vec3::Z * 18.0, [1, 1], &[]);
    let scene = finish(maker);
    let light = rig(r#"{"type":"directional","direction":[0,-4,3],"irradiance":[5,5,5]}"#);
    close(at(&scene, &light, Vec3::new(-1.0, 0.0, 0.0), UP)[0], 5.0 * 0.8, 1e-6);
    assert_eq!(at(&scene, &light, Vec3::new(1.0, 0.0, 0.0), UP), [0.0; 3], "the sheet is in the way");
    assert_eq!(at(&scene, &light, Vec3::new(-1.0, 0.0, 0.0), -UP), [0.0; 3]);
}

/// Quad of 1 × 1 m straight above, emitting downwards.
const QUAD: &str = r#"{"type":"quad","corner":[-0.5,1,-0.5],"edge_u":[1,0,0],"edge_v":[0,0,1],"radiance":[2,2,2]}"#;

/// A plane element below the middle of a parallel square at distance 1: four times Howell's B-3 with sides 1/2.
fn factor_of_the_quad() -> f64 {
    let (x, p) = (0.5, 1.25f64.sqrt());
    4.0 / (2.0 * PI) * 2.0 * (x / p) * (x / p).atan()
}

#[test]
fn a_quad_in_full_view_has_the_catalogued_factor_and_no_noise() {
    let scene = finish(floor());
    close(at(&scene, &rig(QUAD), Vec3::ZERO, UP)[0], 2.0 * PI * factor_of_the_quad(), 1e-5);
    let upwards = QUAD.replace("[1,0,0]", "[0,0,1]").replacen("[0,0,1],\"rad", "[1,0,0],\"rad", 1);
    assert_eq!(at(&scene, &rig(&upwards), Vec3::ZERO, UP), [0.0; 3], "it emits from one side");
}

/// A sheet whose edge crosses the middle of the view hides half of the quad, by symmetry. 256 stratified
/// samples put about 16 on the edge, of which half go either way: 4/256 is two deviations.
#[test]
fn half_a_quad_behind_a_sheet_gives_half_the_light() {
    let mut maker = floor();
    maker.sheet(Vec3::new(0.0, 0.5, -3.0), Vec3::X * 3.0, Vec3::Z * 6.0, [1, 1], &[]);
    close(at(&finish(maker), &rig(QUAD), Vec3::ZERO, UP)[0], PI * factor_of_the_quad(), 4.0 / 256.0);
}

#[test]
fn a_quad_does_not_stand_in_the_way() {
    let scene = finish(floor());
    let both = rig(&format!(r#"{QUAD},{{"type":"point","position":[0,2,0],"intensity":[4,4,4]}}"#));
    close(at(&scene, &both, Vec3::ZERO, UP)[0], 2.0 * PI * factor_of_the_quad() + 1.0, 1e-4);
}

/// Every direction meets a wall of radiance 1, so the irradiance is π everywhere.
#[test]
fn walls_that_all_shine_give_pi_at_every_point() {
    let mut maker = Maker::new(1.0);
    maker.room(Vec3::new(-0.3, 0.2, 0.1), Vec3::new(1.0, 2.0, 3.0), [1; 3]);
    let scene = scene(maker.finish().0, 0.5, [1.0, 2.0, 0.0]);
    for i in 0..20 {
        let (x, y) = (0.001 + 0.0525 * i as f32, 0.999 - 0.05 * i as f32);
        for (p, n) in [
            (Vec3::new(x - 0.3, 0.2, 0.1 + 3.0 * y), Vec3::Y),
            (Vec3::new(-0.3, 0.2 + 2.0 * x, 0.1 + 3.0 * y), Vec3::X),
            (Vec3::new(x - 0.3, 0.2 + 2.0 * y, 3.1), Vec3::NEG_Z),
        ] {
            let e = at(&scene, &emission(), p, n);
            close(e[0], PI, 1e-5);
            close(e[1], 2.0 * PI, 1e-5);
            assert_eq!(e[2], 0.0);
        }
    }
}

#[test]
fn an_emitting_sheet_leaves_its_own_back_dark() {
    let mut maker = Maker::new(1.0);
    maker.sheet(Vec3::ZERO, Vec3::Z, Vec3::X, [1, 1], &[Side::Front]);
    let scene = scene(maker.finish().0, 0.5, [1.0; 3]);
    for normal in [UP, -UP] {
        assert_eq!(at(&scene, &emission(), Vec3::new(0.3, 0.0, 0.4), normal), [0.0; 3]);
        assert_eq!(at(&scene, &emission(), Vec3::new(0.3, -1.0, 0.4), normal), [0.0; 3], "below");
    }
    assert!(at(&scene, &emission(), Vec3::new(0.3, 1.0, 0.4), -UP)[0] > 0.1, "above");
}

/// 2 × 32 × 32 triangles are too many for closed forms: 512 points are drawn and 512 rays cast.
#[test]
fn a_crowd_of_emitting_triangles_gives_what_the_quad_gives() {
    let mut maker = Maker::new(1.0);
    maker.sheet(Vec3::new(-0.5, 1.0, -0.5), Vec3::X, Vec3::Z, [32, 32], &[Side::Front]);
    let crowd = scene(maker.finish().0, 0.5, [2.0; 3]);
    close(at(&crowd, &emission(), Vec3::ZERO, UP)[0], 2.0 * PI * factor_of_the_quad(), 0.01);
}

/// Where an emitting wall is near, drawn points alone would be off by whole multiples.
#[test]
fn a_crowd_of_emitting_triangles_all_around_gives_pi_even_beside_a_wall() {
    let mut maker = Maker::new(1.0);
    maker.room(Vec3::ZERO, Vec3::ONE, [10; 3]);
    let room = scene(maker.finish().0, 0.5, [1.0; 3]);
    for x in [0.5, 0.1, 0.01, 0.001] {
        close(at(&room, &emission(), Vec3::new(x, 0.0, 0.4), UP)[0], PI, 0.015);
    }
}

/// At the foot of a wall without end half of the cosine-weighted sky is hidden; 1024 Sobol rays
/// put about 32 on the border.
#[test]
fn a_wall_hides_half_of_the_sky() {
    let mut maker = floor();
    maker.sheet(Vec3::new(0.0, -1.0, -1e3), Vec3::Y * 1e3, Vec3::Z * 2e3, [1, 1], &[]);
    let light = rig(r#"{"type":"sky","radiance":[3,3,3]}"#);
    close(at(&finish(maker), &light, Vec3::new(0.001, 0.0, 0.0), UP)[0], 1.5 * PI, 16.0 / 512.0);
    close(at(&finish(floor()), &light, Vec3::ZERO, UP)[0], 3.0 * PI, 1e-12);
}

#[test]
fn patches_take_the_sky_that_was_measured_for_them() {
    let (mesh, patches) = floor().finish();
    let scene = scene(mesh, 0.5, [0.0; 3]);
    let (rays, surfaces) = (Rays::new(&scene.mesh), Surfaces::new(&scene.mesh, &scene.materials).unwrap());
    let light = DirectLight::new(&scene, &surfaces, &rays, &rig(r#"{"type":"sky","radiance":[1,2,0]}"#));
    let h = patch_irradiance(&light, &scene.mesh, &patches, &[0.25], 32);
    close(h[0][0].into(), PI / 4.0, 1e-6);
    close(h[0][1].into(), PI / 2.0, 1e-6);
}

/// A point light low over the middle of a patch: its flux through the square in closed form.
#[test]
fn a_patch_has_the_mean_of_its_points() {
    let (mesh, patches) = floor().finish();
    let scene = scene(mesh, 0.5, [0.0; 3]);
    let (rays, surfaces) = (Rays::new(&scene.mesh), Surfaces::new(&scene.mesh, &scene.materials).unwrap());
    let light = rig(r#"{"type":"point","position":[0,2,0],"intensity":[1,1,1]}"#);
    let light = DirectLight::new(&scene, &surfaces, &rays, &light);
    // A side of a cube about the light fills 4π/6 sr; the patch is twice as wide as the light is high, and Sobol points
    // of a smooth function miss its mean by less than 1/N.
    for (points, tolerance) in [(32, 0.03), (512, 0.002)] {
        let h = patch_irradiance(&light, &scene.mesh, &patches, &[0.0], points);
        close(h[0][0].into(), 4.0 * PI / 6.0 / 16.0, tolerance);
    }
}

/// All walls shine and so does a box in their midst, which hides parts of them: π everywhere. Each point has about one ray
/// for each of the triangles that it faces; a ratio of one is off by 4 %, one of all by 1.2 %.
#[test]
fn large_emitters_that_hide_each_other_light_a_patch_without_bias() {
    let mut maker = Maker::new(1.0);
    maker.room(Vec3::ZERO, Vec3::new(4.0, 2.5, 3.0), [1; 3]);
    let (low, [x, y, z]) = (Vec3::new(1.1, 0.3, 0.9), [Vec3::X * 1.2, Vec3::Y * 1.5, Vec3::Z * 0.9]);
    for (u, v, w) in [(x, y, z), (y, z, x), (z, x, y)] {
        maker.sheet(low + w, u, v, [1, 1], &[Side::Front]);
        maker.sheet(low, v, u, [1, 1], &[Side::Front]);
    }
    let (mesh, patches) = maker.finish();
    let scene = scene(mesh, 0.5, [1.0; 3]);
    let (rays, surfaces) = (Rays::new(&scene.mesh), Surfaces::new(&scene.mesh, &scene.materials).unwrap());
    let light = DirectLight::new(&scene, &surfaces, &rays, &emission());
    let h = patch_irradiance(&light, &scene.mesh, &patches, &vec![0.0; patches.len()], 32);
    let area: f64 = patches.area.iter().map(|&a| f64::from(a)).sum();
    let mean = patches.area.iter().zip(&h).map(|(&a, h)| f64::from(a * h[0])).sum::<f64>() / area;
    close(mean, PI, 0.02);
}

/// Two rooms with a wall of 1 mm, all kinds of light in one: the other has none at all.
#[test]
fn no_light_at_all_reaches_a_sealed_room() {
    let mut maker = Maker::new(0.5);
    maker.room(Vec3::ZERO, Vec3::splat(2.0), [4; 3]);
    let lit = maker.mesh.triangles.len();
    maker.room(Vec3::new(2.001, 0.0, 0.0), Vec3::splat(2.0), [4; 3]);
    maker.mesh.triangle_material[..lit].fill(1);
    let (mesh, patches) = maker.finish();
    let mut scene = scene(mesh, 0.5, [0.0; 3]);
    let lamp = radfile::Material { emission: [5.0; 3], ..scene.materials.materials[0].clone() };
    scene.materials.materials.push(lamp);
    let mut lights = rig(&format!(
        r#"{},{{"type":"point","position":[1.9,1,1],"intensity":[9,9,9]}},
           {{"type":"spot","position":[1.5,1,1],"direction":[1,0,0],"intensity":[9,9,9],"half_angle_deg":60}},
           {{"type":"directional","direction":[1,-1,0.3],"irradiance":[9,9,9]}},
           {{"type":"sky","radiance":[9,9,9]}}"#,
        QUAD.replace("-0.5", "0.9")
    ));
    lights.use_scene_emission = true;
    let (rays, surfaces) = (Rays::new(&scene.mesh), Surfaces::new(&scene.mesh, &scene.materials).unwrap());
    let light = DirectLight::new(&scene, &surfaces, &rays, &lights);
    let h = patch_irradiance(&light, &scene.mesh, &patches, &vec![0.0; patches.len()], 32);
    assert!(h[..lit / 2].iter().all(|h| h[0] > 1.0), "the first room is bright");
    assert!(h[lit / 2..].iter().all(|h| *h == [0.0; 3]), "the second is dark");
}

#[test]
fn lights_are_where_the_scene_file_says_however_far_from_its_origin() {
    let mut scene = finish(floor());
    scene.mesh.origin = [4e6, -1e6, 5e5];
    let light = rig(r#"{"type":"point","position":[4000000,-999998,500000],"intensity":[8,8,8]}"#);
    close(at(&scene, &light, Vec3::ZERO, UP)[0], 2.0, LIFT);
    let points = relight::surface_points(&scene.mesh, &[[4000001.5, -1e6, 5e5]], &[[0.0, 2.0, 0.0]]);
    assert_eq!((points[0].position, points[0].normal), (Vec3::X * 1.5, UP));
}
