//! CIE 171:2006, tests 5.6 and 5.8, from scene file to irradiance.

use std::f64::consts::PI;

use allbounce_tests::{
    data,
    mesh_text::{MeshText, Paint},
    patch_light::PatchLight,
    shapes::{Plate, inside_of_box},
    workbench::{Point, Workbench},
};
use serde::Deserialize;
use serde_json::json;

#[derive(Deserialize)]
struct Tables {
    diffuse_reflection: DiffuseReflection,
    internal_reflection: InternalReflection,
}

#[derive(Deserialize)]
struct DiffuseReflection {
    points: Vec<Factor>,
}

#[derive(Deserialize)]
struct Factor {
    id: String,
    #[serde(flatten)]
    point: Point,
    printed: f64,
    exact: f64,
}

#[derive(Deserialize)]
struct InternalReflection {
    rooms: Vec<Room>,
}

#[derive(Deserialize)]
struct Room {
    reflectance: f64,
    printed: f64,
    exact: f64,
}

fn tables() -> Tables {
    serde_json::from_value(data("cie_171.json")).expect("the tables")
}

/// Test 5.6, scenario 2: light that a diffuse floor (ρ = 0.30) sends to black surfaces, E = ρ E_floor F.
///
/// The floor is lit evenly by a beam along the wall that is measured, slanting in below the ceiling. Walls without
/// points are left out: black ones would send nothing back.
#[test]
fn a_lit_floor_sends_to_wall_and_ceiling_what_the_table_says() {
    let floor = Paint::matt("floor", [0.3; 3]);
    let black = Paint::matt("black", [0.0; 3]);
    let mut mesh = MeshText::default();
    Plate { corner: [0.0; 3], u: [4.0, 0.0, 0.0], v: [0.0, 4.0, 0.0] }.add(&mut mesh, floor);
    Plate { corner: [0.0; 3], u: [0.0, 0.0, 3.0], v: [4.0, 0.0, 0.0] }.add(&mut mesh, black);
    Plate { corner: [0.0, 0.0, 3.0], u: [0.0, 4.0, 0.0], v: [4.0, 0.0, 0.0] }.add(&mut mesh, black);
    let bench = Workbench::new(&mesh);
    bench.bake(&["--patches", "2000", "--rays", "65536", "--one-sided", "--bounces", "1"]);

    // 4.5 m sideways on 3 m down; the floor gets the cosine of 1 W/m².
    let beam = json!({ "type": "directional", "direction": [4.5, 0, -3], "irradiance": [1, 1, 1] });
    let floor = 3.0 / f64::hypot(4.5, 3.0);
    let factors = tables().diffuse_reflection.points;
    let points: Vec<Point> = factors.iter().map(|f| f.point).collect();
    let light = |options: &[&str]| {
        let [red, ..] = bench.relight(&json!({ "lights": [beam] }), &points, options);
        assert!(red.direct.iter().all(|&e| e == 0.0), "the beam must miss the points: {:?}", red.direct);
        red.indirect.into_iter().map(|e| 100.0 * e / (0.3 * floor)).collect::<Vec<f64>>()
    };
    let (dense, packed) = (light(&["--bounces", "1"]), light(&[]));
    for ((factor, dense), packed) in factors.iter().zip(dense).zip(packed) {
        let Factor { id, printed, exact, .. } = factor;
        let [dense_error, packed_error] = [dense, packed].map(|found| found / exact - 1.0);
        println!(
            "{id}: {printed} printed, {dense:.3} ({:+.3} %), packed {:+.3} %",
            100.0 * dense_error,
            100.0 * packed_error
        );
        assert!((printed - exact).abs() < 0.006, "{id}: {printed} is not {exact} rounded");
        assert!(dense_error.abs() < 5e-3, "{id}: {dense}, exactly {exact}");
        assert!(packed_error.abs() < 1e-2, "{id}: {packed} packed, exactly {exact}");
    }
}

/// Test 5.8: in a closed room of one reflectance the mean of indirect light is ρ Φ / (S (1 − ρ)), theory.md (8.2).
///
/// Three reflectances a bake, one in each colour. The mean over the patches is exact but for the noise of the lamp's
/// light on them; the mean over points adds what interpolation does to light that falls off towards the edges.
#[test]
fn a_closed_room_keeps_the_light_that_the_table_says() {
    let walls = inside_of_box([0.0; 3], [4.0; 3]);
    let intensity = 10_000.0 / (4.0 * PI);
    let lamp = json!({ "type": "point", "position": [2, 2, 2], "intensity": [intensity, intensity, intensity] });
    let lights = json!({ "lights": [lamp] });
    let middles = |steps: usize| (0..steps).map(move |k| (k as f64 + 0.5) / steps as f64);
    let on = |wall: &Plate| {
        let (wall, normal) = (*wall, wall.normal());
        middles(24).flat_map(move |s| middles(24).map(move |t| Point { position: wall.at(s, t), normal }))
    };
    let points: Vec<Point> = walls.iter().flat_map(on).collect();

    for rooms in tables().internal_reflection.rooms.chunks(3) {
        let reflectance = std::array::from_fn(|c| rooms.get(c).map_or(0.5, |room| room.reflectance));
        let mut mesh = MeshText::default();
        walls.iter().for_each(|wall| wall.add(&mut mesh, Paint::matt("wall", reflectance)));
        let bench = Workbench::new(&mesh);
        let bake = bench.bake(&["--patches", "1200", "--rays", "4096", "--one-sided"]);
        let light = PatchLight::new(&bake, &lights);
        let [dense_points, packed_points] =
            [&["--bounces", "300"][..], &[]].map(|o| bench.relight(&lights, &points, o));
        for (colour, Room { reflectance, printed, exact }) in rooms.iter().enumerate() {
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
            let found = [
                light.mean(&light.indirect, colour),
                light.mean(&light.packed, colour),
                mean(&dense_points[colour].indirect),
                mean(&packed_points[colour].indirect),
            ];
            let [dense, packed, at_points, packed_at_points] = found.map(|e| e / exact - 1.0);
            println!(
                "ρ = {reflectance}: {printed} lx printed, {:.3} ({:+.4} %); packed {:+.4} %; points {:+.4} %, packed {:+.4} %",
                found[0],
                100.0 * dense,
                100.0 * packed,
                100.0 * at_points,
                100.0 * packed_at_points
            );
            assert!((printed / exact - 1.0).abs() < 5e-3, "{printed} is not {exact} rounded");
            assert!(dense.abs() < 5e-4, "ρ = {reflectance}: {} lx, exactly {exact}", found[0]);
            assert!(packed.abs() < 5e-3 && at_points.abs() < 1e-2 && packed_at_points.abs() < 1e-2, "{found:?}");
        }
    }
}
