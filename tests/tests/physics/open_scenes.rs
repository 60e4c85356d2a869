//! A sphere with an opening: every part of its wall sees the same share of sky, so its light has a closed form.
//!
//! The wall sees f = (1 − cos θ)/2 of sky where the opening ends at the polar angle θ. Light that falls on the wall,
//! in whatever pattern, is spread evenly by the first reflection, and theory.md (7.4) becomes
//! H_ind = H⁰ ρ (1 − f) / (1 − ρ (1 − f)), with H⁰ the mean over the wall. Under an even sky H⁰ = π L f everywhere, and
//! the opening absorbs like a surface of absorptance α / (1 − (1 − α)(1 − f)).
//! Source: E. M. Sparrow, V. K. Jonsson, Absorption and emission characteristics of diffuse spherical enclosures,
//! J. Heat Transfer 84, 1962.

use std::f64::consts::PI;

use allbounce_tests::{
    mesh_text::{MeshText, Paint},
    patch_light::PatchLight,
    shapes::{Facing, sphere},
    workbench::Workbench,
};
use radfile::{Container, read_sky};
use serde_json::{Value, json};

const RINGS: usize = 24;
const SECTORS: usize = 48;
/// Open down to 60 degrees: a quarter of the sphere is missing.
const OPEN: usize = 8;
const REFLECTANCE: [f64; 3] = [0.3, 0.8, 0.95];

fn cavity() -> Container {
    let mut mesh = MeshText::default();
    sphere(&mut mesh, Paint::matt("wall", REFLECTANCE), 1.0, [RINGS, SECTORS, OPEN], Facing::Inwards);
    Workbench::new(&mesh).bake(&["--voxel", "0.3m", "--rays", "4096", "--one-sided"])
}

/// What the wall sees of the sky on average: the opening sees nothing but wall, so A f = area of the opening.
fn sky_share(light: &PatchLight) -> f64 {
    let radius = (PI * OPEN as f64 / RINGS as f64).sin();
    let (n, wall) = (SECTORS as f64, light.area.iter().sum::<f64>());
    0.5 * n * radius * radius * (2.0 * PI / n).sin() / wall
}

fn lit(cavity: &Container, light: Value) -> PatchLight {
    PatchLight::new(cavity, &json!({ "lights": [light] }))
}

/// Largest and mean deviation of indirect light, relative.
fn deviation(light: &PatchLight, values: &[[f64; 3]], colour: usize, exact: f64) -> (f64, f64) {
    let worst = values.iter().map(|h| (h[colour] / exact - 1.0).abs()).fold(0.0, f64::max);
    (worst, light.mean(values, colour) / exact - 1.0)
}

fn assert_even(light: &PatchLight, direct: impl Fn(usize) -> f64, f: f64) {
    for (colour, rho) in REFLECTANCE.into_iter().enumerate() {
        let exact = direct(colour) * rho * (1.0 - f) / (1.0 - rho * (1.0 - f));
        let (worst, mean) = deviation(light, &light.indirect, colour, exact);
        let (packed, packed_mean) = deviation(light, &light.packed, colour, exact);
        println!("ρ = {rho}: mean {mean:+.1e}, worst {worst:.1e}; packed mean {packed_mean:+.1e}, worst {packed:.1e}");
        assert!(mean.abs() < 5e-3 && worst < 4e-2, "ρ = {rho}: mean {mean}, worst {worst}");
        assert!(packed_mean.abs() < 1e-2, "ρ = {rho}: packed mean {packed_mean}");
    }
}

#[test]
fn a_spherical_cavity_under_the_sky_is_as_bright_as_its_closed_form() {
    let cavity = cavity();
    let light = lit(&cavity, json!({ "type": "sky", "radiance": [1, 1, 1] }));
    let f = sky_share(&light);
    assert!((f - 0.25).abs() < 2e-3, "the inscribed polyhedron is nearly the sphere: {f}");
    let seen: f64 = read_sky(&cavity).expect("sky").iter().zip(&light.area).map(|(&s, a)| f64::from(s) * a).sum();
    let seen = seen / light.area.iter().sum::<f64>();
    assert!((seen / f - 1.0).abs() < 1e-3, "the wall sees {seen} of sky, exactly {f}");
    assert_even(&light, |_| PI * f, f);

    for (colour, rho) in REFLECTANCE.into_iter().enumerate() {
        let total = light.mean(&light.direct, colour) + light.mean(&light.indirect, colour);
        // What the wall absorbs over what comes in through the opening, whose area is f of the wall's.
        let found = (1.0 - rho) * total / (PI * f);
        let exact = (1.0 - rho) / (1.0 - rho * (1.0 - f));
        println!("absorptance {found:.5}, exactly {exact:.5}");
        assert!((found / exact - 1.0).abs() < 2e-3, "absorptance {found}, exactly {exact}");
    }
}

/// The lamp hangs off the middle, near the wall, and still all of the wall is equally bright.
#[test]
fn a_spherical_cavity_evens_out_the_light_of_a_lamp() {
    let light = lit(&cavity(), json!({ "type": "point", "position": [0.3, 0.1, -0.5], "intensity": [1, 1, 1] }));
    assert_even(&light, |colour| light.mean(&light.direct, colour), sky_share(&light));
}
