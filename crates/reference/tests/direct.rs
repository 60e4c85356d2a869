//! Light of every type against closed forms.
//!
//! Form factor of a rectangle from a differential element: J. R. Howell, A Catalog of Radiation Heat Transfer
//! Configuration Factors, B-3 (element parallel to the rectangle, below its corner).

mod common;

use std::f64::consts::PI;

use common::{At, close, emission, empty, furnace, one, paint, rig, sheet, trace, within};
use glam::Vec3;
use radfile::{Texture, Wrap};
use reference::Stop;
use scene::{LightRig, Scene};

const UP: [f32; 3] = [0.0, 1.0, 0.0];
/// Receivers are raised by about 2e-6 of the scene; irradiance of near lamps changes by a few times that.
const LIFT: f64 = 1e-4;

/// A black floor of 4 m about the origin.
fn floor() -> Scene {
    let mut scene = empty();
    let black = paint(&mut scene, [0.0; 3], [0.0; 3]);
    sheet(&mut scene, black, Vec3::new(-2.0, 0.0, -2.0), Vec3::Z * 4.0, Vec3::X * 4.0);
    scene
}

/// From an element to a parallel rectangle of `a` × `b` at distance `c` whose corner is above the element.
fn corner_factor(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / p * (y / p).atan() + y / q * (x / q).atan()) / (2.0 * PI)
}

#[test]
fn a_point_light_falls_off_with_the_square_and_the_cosine() {
    let scene = floor();
    let lamp = rig(r#"{"type":"point","position":[0.3,1.5,-0.2],"intensity":[10,20,0]}"#);
    for x in [-1.5, 0.0, 0.3, 1.9] {
        let square: f64 = [0.3 - x, 1.5, -0.2].iter().map(|v| v * v).sum();
        let light = one(&scene, &lamp, [x, 0.0, 0.0], UP, 64).direct;
        close(light.value[0], 10.0 * 1.5 / square.powf(1.5), LIFT);
        close(light.value[1], 2.0 * light.value[0], 1e-6);
        assert_eq!((light.value[2], light.error), (0.0, [0.0; 3]), "lamps without extent are exact");
        assert_eq!(one(&scene, &lamp, [x, 0.0, 0.0], [0.0, -1.0, 0.0], 64).direct.value, [0.0; 3], "below is dark");
    }
}

#[test]
fn a_spot_is_full_inside_its_cone_fades_in_its_penumbra_and_ends() {
    let scene = floor();
    let strength = |degrees: f64, penumbra: f32| {
        let lamp = rig(&format!(
            r#"{{"type":"spot","position":[0,1,0],"direction":[0,-3,0],"intensity":[1,1,1],
                "half_angle_deg":40,"penumbra_deg":{penumbra}}}"#
        ));
        let angle = degrees.to_radians();
        one(&scene, &lamp, [angle.tan(), 0.0, 0.0], UP, 64).direct.value[0] / angle.cos().powi(3)
    };
    for inside in [0.0, 20.0, 39.9] {
        close(strength(inside, 0.0), 1.0, LIFT);
    }
    assert_eq!(strength(40.1, 0.0), 0.0);
    close(strength(29.9, 10.0), 1.0, LIFT);
    close(strength(35.0, 10.0), 0.5, 10.0 * LIFT);
    assert_eq!(strength(40.1, 10.0), 0.0);
}

#[test]
fn a_sun_gives_its_irradiance_times_the_cosine_and_casts_shadows() {
    let mut scene = floor();
    sheet(&mut scene, 0, Vec3::new(-1.0, 0.5, -0.5), Vec3::X * 0.5, Vec3::Z);
    let sun = rig(r#"{"type":"directional","direction":[3,-4,0],"irradiance":[10,5,1]}"#);
    let at = |x: f64| one(&scene, &sun, [x, 0.0, 0.0], UP, 64).direct.value;
    close(at(1.5)[0], 8.0, 1e-5);
    close(at(1.5)[1], 4.0, 1e-5);
    // The sheet at height 0.5 from x = -1 to -0.5 shades the floor 0.375 m further on.
    for (x, lit) in [(-0.65, 8.0), (-0.6, 0.0), (-0.2, 0.0), (-0.1, 8.0)] {
        close(at(x)[0], lit, 1e-5);
    }
}

#[test]
fn a_quad_gives_radiance_times_pi_times_its_form_factor_on_its_own_side_only() {
    let scene = floor();
    let quad = |v: i32| {
        rig(&format!(r#"{{"type":"quad","corner":[0,1,0],"edge_u":[1,0,0],"edge_v":[0,0,{v}],"radiance":[2,2,2]}}"#))
    };
    let wanted = 2.0 * PI * corner_factor(1.0, 1.0, 1.0);
    within(one(&scene, &quad(1), [0.0; 3], UP, 1 << 16).direct, wanted, 4.0, 2e-3);
    assert_eq!(one(&scene, &quad(-1), [0.0; 3], UP, 4096).direct.value, [0.0; 3], "its back is dark");
}

#[test]
fn a_quad_does_not_occlude() {
    let scene = floor();
    let quad = r#"{"type":"quad","corner":[-1,1,-1],"edge_u":[2,0,0],"edge_v":[0,0,2],"radiance":[0,0,0]}"#;
    let lamp = r#"{"type":"point","position":[0,2,0],"intensity":[4,4,4]}"#;
    close(one(&scene, &rig(&format!("{quad},{lamp}")), [0.0; 3], UP, 64).direct.value[0], 1.0, LIFT);
}

#[test]
fn a_quad_that_touches_is_as_calm_as_a_far_one() {
    let scene = floor();
    // 1 mm above the floor and 2 m wide: as good as a sky.
    let near = rig(r#"{"type":"quad","corner":[-1,0.001,-1],"edge_u":[2,0,0],"edge_v":[0,0,2],"radiance":[1,1,1]}"#);
    within(one(&scene, &near, [0.0; 3], UP, 4096).direct, PI, 4.0, 1e-3);
    // An emitting wall that stands on the floor, seen from 1 mm in front of it: nearly half of the hemisphere.
    let mut scene = floor();
    let lamp = paint(&mut scene, [0.0; 3], [1.0; 3]);
    sheet(&mut scene, lamp, Vec3::new(0.0, 0.0, -2.0), Vec3::Y * 4.0, Vec3::Z * 4.0);
    let light = one(&scene, &emission(), [0.001, 0.0, 0.0], UP, 1 << 14).direct;
    close(light.value[0], PI / 2.0, 0.02);
    assert!(light.error[0] < 0.01 * light.value[0], "{light:?}");
}

#[test]
fn emission_leaves_the_front_only() {
    let mut scene = floor();
    let lamp = paint(&mut scene, [0.0; 3], [3.0; 3]);
    sheet(&mut scene, lamp, Vec3::new(0.0, 1.0, 0.0), Vec3::X, Vec3::Z);
    let wanted = 3.0 * PI * corner_factor(1.0, 1.0, 1.0);
    within(one(&scene, &emission(), [0.0; 3], UP, 1 << 16).direct, wanted, 4.0, 2e-3);
    let above: At = ([0.0, 2.0, 0.0], [0.0, -1.0, 0.0]);
    let (light, _) = trace(&scene, &emission(), &[above], Stop::Samples(1 << 12), 1);
    assert_eq!(light[0].direct.value, [0.0; 3], "its back is dark");
    let off = one(&scene, &LightRig::default(), [0.0; 3], UP, 256);
    assert_eq!(off.direct.value, [0.0; 3], "emission shines only where it is asked to");
}

#[test]
fn textured_emission_shines_where_its_texels_do() {
    let mut scene = floor();
    let lamp = paint(&mut scene, [0.0; 3], [4.0; 3]);
    let first = scene.mesh.positions.len();
    sheet(&mut scene, lamp, Vec3::new(-1.0, 1.0, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0);
    // The half of the lamp at x < 0 is black, the other white: both texels, each far from the border between.
    let mut bytes = Vec::new();
    let mut texels = image::GrayImage::new(256, 1);
    (128..256).for_each(|x| texels.put_pixel(x, 0, image::Luma([255])));
    texels.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).expect("a small picture");
    scene.materials.textures.push(Texture { name: "half.png".into(), bytes, wrap: [Wrap::Clamp; 2] });
    scene.materials.materials[lamp as usize].emission_texture = Some(0);
    scene.mesh.uv = scene.mesh.positions.iter().map(|p| [0.5 * (p[0] + 1.0), 0.5]).collect();
    assert_eq!(scene.mesh.uv[first], [0.0, 0.5]);
    // The bright half is two rectangles of 1 × 1 with a common corner above the origin.
    let wanted = 4.0 * PI * 2.0 * corner_factor(1.0, 1.0, 1.0);
    within(one(&scene, &emission(), [0.0; 3], UP, 1 << 16).direct, wanted, 4.0, 3e-3);
}

#[test]
fn a_sky_over_an_open_plane_is_pi_and_under_a_roof_less() {
    let mut scene = floor();
    let sky = rig(r#"{"type":"sky","radiance":[1,2,3]}"#);
    let open = one(&scene, &sky, [0.5, 0.0, 0.5], UP, 256).direct;
    (0..3).for_each(|c| close(open.value[c], PI * (c + 1) as f64, 1e-6));
    sheet(&mut scene, 0, Vec3::new(0.0, 1.0, 0.0), Vec3::X, Vec3::Z);
    let covered = one(&scene, &rig(r#"{"type":"sky","radiance":[1,1,1]}"#), [0.0; 3], UP, 1 << 16).direct;
    within(covered, PI * (1.0 - corner_factor(1.0, 1.0, 1.0)), 4.0, 1e-3);
}

#[test]
fn a_lit_sheet_gives_the_other_its_form_factor_as_first_bounce() {
    // A white sheet 1 m above a black floor, lit from below by a sun from straight below: E = 1 on it, all of it.
    let mut scene = empty();
    let black = paint(&mut scene, [0.0; 3], [0.0; 3]);
    let white = paint(&mut scene, [0.8; 3], [0.0; 3]);
    sheet(&mut scene, black, Vec3::new(-0.2, 0.0, -0.2), Vec3::Z * 0.1, Vec3::X * 0.1);
    sheet(&mut scene, white, Vec3::new(0.0, 1.0, 0.0), Vec3::X, Vec3::Z);
    let sun = rig(r#"{"type":"directional","direction":[0,1,0],"irradiance":[1,1,1]}"#);
    let light = one(&scene, &sun, [0.0; 3], UP, 1 << 16);
    within(light.single, 0.8 * corner_factor(1.0, 1.0, 1.0), 4.0, 3e-3);
    assert_eq!(light.single, light.indirect, "nothing lights the sheet a second time");
}

#[test]
fn many_lamps_are_chosen_without_bias() {
    // Lamps of very different strength; those behind the wall reach nothing.
    let mut scene = furnace(0.6, 0.0, Vec3::splat(2.0));
    let black = paint(&mut scene, [0.0; 3], [0.0; 3]);
    sheet(&mut scene, black, Vec3::new(1.5, 0.0, 0.0), Vec3::Y * 2.0, Vec3::Z * 2.0);
    let lamp =
        |x: f64, y: f64, i: f64| format!(r#"{{"type":"point","position":[{x},{y},1],"intensity":[{i},{i},{i}]}}"#);
    let each = [lamp(0.4, 1.0, 5.0), lamp(1.2, 1.8, 0.3), lamp(1.7, 1.0, 50.0)];
    let light = |lamps: &str| one(&scene, &rig(lamps), [0.5, 0.0, 0.7], UP, 1 << 15).indirect;
    let sum: f64 = each.iter().map(|l| light(l).value[0]).sum();
    let all = light(&each.join(","));
    assert!((all.value[0] - sum).abs() < 5.0 * all.error[0] && all.error[0] < 0.01 * sum, "{all:?}, expected {sum}");
    assert_eq!(light(&each[2]).value, [0.0; 3]);
}
