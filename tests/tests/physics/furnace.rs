//! Closed rooms that are equally bright everywhere, theory.md (7.1).
//!
//! Walls of reflectance ρ that emit 1 − ρ give an irradiance of exactly 1, for every ρ and any shape: in three
//! colours one room tests three reflectances.

use std::f64::consts::PI;

use allbounce_tests::{
    mesh_text::{MeshText, Paint},
    patch_light::PatchLight,
    shapes::{Plate, inside_of_box},
    workbench::{Point, Workbench},
};
use radfile::Container;
use serde_json::json;

/// A room of 3 × 2 × 2.5 m with walls that emit 1 − ρ, and its bake.
///
/// The import takes no reflectance above 0.99; what is beyond is written into the patches, before anything is computed.
fn furnace(reflectance: [f64; 3]) -> (Workbench, Container) {
    let paint = Paint { name: "glow", reflectance, emission: reflectance.map(|rho| (1.0 - rho) / PI) };
    let mut mesh = MeshText::default();
    inside_of_box([0.0; 3], [3.0, 2.0, 2.5]).iter().for_each(|wall| wall.add(&mut mesh, paint));
    let bench = Workbench::new(&mesh);
    let small = ["--patches", "300", "--one-sided"];
    let bake = bench.bake_in_stages(&small, &["--rays", "1024"], |patches| {
        patches.reflectance.fill(reflectance.map(|rho| rho as f32));
    });
    (bench, bake)
}

/// Points of every wall, near its edges, too.
fn points() -> Vec<Point> {
    let steps = [0.02, 0.3, 0.5, 0.9];
    let on = |wall: &Plate| {
        let (wall, normal) = (*wall, wall.normal());
        steps.into_iter().flat_map(move |s| steps.map(|t| Point { position: wall.at(s, t), normal }))
    };
    inside_of_box([0.0; 3], [3.0, 2.0, 2.5]).iter().flat_map(on).collect()
}

#[test]
fn a_white_furnace_is_equally_bright_everywhere() {
    let lights = json!({ "use_scene_emission": true, "lights": [] });
    for reflectance in [[0.5, 0.9, 0.99], [0.999; 3]] {
        let (bench, bake) = furnace(reflectance);
        let patches = PatchLight::new(&bake, &lights);
        let at_points = bench.relight(&lights, &points(), &[]);
        for (colour, rho) in reflectance.into_iter().enumerate() {
            let off = |direct: f64, indirect: f64| (direct + indirect - 1.0).abs();
            let direct = patches.direct.iter().map(|h| h[colour]);
            let dense = direct.zip(&patches.indirect).map(|(d, h)| off(d, h[colour])).fold(0.0, f64::max);
            let light = &at_points[colour];
            let packed = light.direct.iter().zip(&light.indirect).map(|(&d, &i)| off(d, i)).fold(0.0, f64::max);
            println!("ρ = {rho}: patches off by {dense:.1e}, points through the packed operator by {packed:.1e}");
            // Walls emit what single precision leaves of 1 − ρ.
            assert!(dense < 1e-4 && packed < 1e-2, "ρ = {rho}: off by {dense} and {packed}");
            assert!(light.direct.iter().all(|d| (d / (1.0 - rho) - 1.0).abs() < 1e-4), "ρ = {rho}: direct light");
        }
    }
}

/// The solve itself, in double precision and as stored.
#[test]
fn the_operator_holds_the_furnace_identity_up_to_a_reflectance_of_999() {
    for reflectance in [[0.5, 0.9, 0.99], [0.999; 3]] {
        let (bench, _) = furnace(reflectance);
        bench.verify();
        for channel in bench.report("series")["channel"].as_array().expect("channels") {
            let error = |name: &str| channel[name].as_f64().expect(name);
            let (solved, stored) = (error("furnace_max_error"), error("furnace_max_error_stored"));
            println!("{}: {solved:.1e} solved, {stored:.1e} stored", channel["name"]);
            assert!(solved < 1e-6 && stored < 1e-5, "{solved} solved, {stored} stored");
        }
    }
}
