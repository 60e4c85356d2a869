//! Patches from tiny to huge in one room.

use std::f64::consts::PI;

use allbounce_tests::{
    mesh_text::{MeshText, Paint},
    patch_light::PatchLight,
    shapes::{Facing, inside_of_box, outside_of_box, sphere},
    workbench::Workbench,
};
use radfile::{FormFactors, Patches, Record};
use serde_json::json;

fn ratio_of_areas(area: &[f64]) -> f64 {
    area.iter().fold(0.0f64, |a, &b| a.max(b)) / area.iter().fold(f64::INFINITY, |a, &b| a.min(b))
}

/// A room with floating cubes of 30 cm, 5 cm and 1 cm, one reflectance: every identity holds, and the mean of all
/// light is Φ / (S (1 − ρ)), theory.md (8.2).
#[test]
fn crumbs_in_a_hall_keep_every_identity() {
    let rho = 0.8;
    let mut mesh = MeshText::default();
    let wall = Paint::matt("wall", [rho; 3]);
    inside_of_box([0.0; 3], [6.0, 5.0, 3.0]).iter().for_each(|w| w.add(&mut mesh, wall));
    for (x, edge) in [(1.0, 0.3), (2.5, 0.05), (4.0, 0.01)] {
        let low = [x, 2.0, 1.0];
        outside_of_box(low, low.map(|c| c + edge)).iter().for_each(|w| w.add(&mut mesh, wall));
    }
    let bench = Workbench::new(&mesh);
    let bake = bench.bake(&["--voxel", "0.7m", "--rays", "16384", "--one-sided"]);
    bench.verify();
    let light = PatchLight::new(
        &bake,
        &json!({ "lights": [{ "type": "point", "position": [3, 2.5, 2], "intensity": [1, 1, 1] }] }),
    );
    let ratio = ratio_of_areas(&light.area);
    assert!(ratio > 1e3, "areas differ by {ratio} only: not a test");

    let (factors, patches) = (FormFactors::read(&bake).expect("factors"), Patches::read(&bake).expect("patches"));
    for i in 0..factors.len() {
        let sum: f64 = factors.row(i).iter().map(|&f| f64::from(f)).sum();
        assert!((sum - 1.0).abs() < 1e-6 && factors.sky[i] == 0.0, "row {i} of {} m² sums to {sum}", patches.area[i]);
        for j in 0..i {
            let (there, back) =
                (light.area[i] * f64::from(factors.row(i)[j]), light.area[j] * f64::from(factors.row(j)[i]));
            assert!((there - back).abs() <= 2e-7 * there.max(back), "pair {i}, {j}: {there} and {back}");
        }
    }
    let direct = light.mean(&light.direct, 0);
    for (way, indirect, tolerance) in [("dense", &light.indirect, 1e-5), ("packed", &light.packed, 1e-2)] {
        let deviation = light.mean(indirect, 0) / (direct * rho / (1.0 - rho)) - 1.0;
        println!("{} patches, areas differ {ratio:.0} times, {way}: {deviation:+.1e}", light.area.len());
        assert!(deviation.abs() < tolerance, "{way}: {deviation}");
    }
    // The lamp's flux falls on the walls and the crumbs, and nowhere else.
    let surface: f64 = light.area.iter().sum();
    assert!((direct * surface / (4.0 * PI) - 1.0).abs() < 2e-3, "{} of 4π W", direct * surface);
}

/// Two concentric spheres: with F = 1 from the inner one and A_1/A_2 back, light is the solution of two equations.
#[test]
fn a_bead_in_a_globe_gets_what_two_equations_say() {
    let (bead, globe) = ([0.7, 0.2, 0.9], [0.5, 0.8, 0.9]);
    let mut mesh = MeshText::default();
    let glow = Paint { name: "globe", reflectance: globe, emission: [1.0 / PI; 3] };
    sphere(&mut mesh, glow, 2.0, [12, 24, 0], Facing::Inwards);
    sphere(&mut mesh, Paint::matt("bead", bead), 0.1, [8, 12, 0], Facing::Outwards);
    let bake = Workbench::new(&mesh).bake(&["--voxel", "0.6m", "--rays", "16384", "--one-sided"]);
    let light = PatchLight::new(&bake, &json!({ "use_scene_emission": true, "lights": [] }));
    let patches = Patches::read(&bake).expect("patches");
    let of_bead: Vec<bool> = patches.emission.iter().map(|e| e[0] == 0.0).collect();
    let area = |bead: bool| light.area.iter().zip(&of_bead).filter(|(_, b)| **b == bead).map(|(a, _)| a).sum::<f64>();
    let mean = |values: &[[f64; 3]], bead: bool, colour: usize| {
        let chosen = (0..values.len()).filter(|&i| of_bead[i] == bead);
        chosen.map(|i| light.area[i] * values[i][colour]).sum::<f64>() / area(bead)
    };
    println!("areas differ {:.0} times", ratio_of_areas(&light.area));
    // The polyhedra's own areas: their faces' flatness changes nothing in the exchange between convex and closed.
    let back = area(true) / area(false);
    for colour in 0..3 {
        let [r1, r2] = [f64::from(bead[colour] as f32), f64::from(globe[colour] as f32)];
        // H_1 = B_2, H_2 = back B_1 + (1 − back) B_2 with B_1 = r1 H_1 and B_2 = 1 + r2 H_2.
        let seen = back * r1 + 1.0 - back;
        let b2 = 1.0 / (1.0 - r2 * seen);
        for (is_bead, exact) in [(true, b2), (false, seen * b2)] {
            let found = mean(&light.direct, is_bead, colour) + mean(&light.indirect, is_bead, colour);
            println!("colour {colour}, bead {is_bead}: {found:.5}, exactly {exact:.5} ({:+.1e})", found / exact - 1.0);
            assert!((found / exact - 1.0).abs() < 5e-3, "colour {colour}, bead {is_bead}: {found}, exactly {exact}");
        }
    }
}
