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
    bench.bake(&["--patches", "2000", "--rays", "32768", "--one-sided"]);

    // 4.5 m sideways on 3 m down; the floor gets the cosine of 1 W/m².
    let beam = json!({ "type": "directional", "direction": [4.5, 0, -3], "irradiance": [1, 1, 1] });
    let floor = 3.0 / f64::hypot(4.5, 3.0);
    let factors = tables().diffuse_reflection.points;
    let points: Vec<Point> = factors.iter().map(|f| f.point).collect();
    // The gather looks at the floor from the point; interpolation takes what the operator gives to the patches around.
    for (way, options, tolerance) in [
        ("gathered with 65536 rays", &["--gather-rays", "65536"][..], 1e-3),
        ("gathered", &[], 5e-3),
        ("interpolated, dense", &["--transfer", "interpolate", "--bounces", "1"], 5e-3),
        ("interpolated, packed", &["--transfer", "interpolate"], 5e-3),
    ] {
        let [red, ..] = bench.relight(&json!({ "lights": [beam] }), &points, options);
        assert!(red.direct.iter().all(|&e| e == 0.0), "the beam must miss the points: {:?}", red.direct);
        for (Factor { id, printed, exact, .. }, e) in factors.iter().zip(red.indirect) {
            let error = 100.0 * e / (0.3 * floor) / exact - 1.0;
            println!("{way}, {id}: {printed} printed, {exact} exactly, {:+.3} %", 100.0 * error);
            assert!((printed - exact).abs() < 0.006, "{id}: {printed} is not {exact} rounded");
            assert!(error.abs() < tolerance, "{id}, {way}: off by {:.3} %", 100.0 * error);
        }
    }
}

/// Test 5.8: in a closed room of one reflectance the mean of indirect light is ρ Φ / (S (1 − ρ)), theory.md (8.2).
///
/// Three reflectances a bake, one in each colour. The mean over the patches is exact but for the noise of the lamp's
/// light on them; the mean over points adds the last gather.
#[test]
fn a_closed_room_keeps_the_light_that_the_table_says() {
    let walls = inside_of_box([0.0; 3], [4.0; 3]);
    let intensity = 10_000.0 / (4.0 * PI);
    let lamp = json!({ "type": "point", "position": [2, 2, 2], "intensity": [intensity, intensity, intensity] });
    let lights = json!({ "lights": [lamp] });
    let middles = |steps: usize| (0..steps).map(move |k| (k as f64 + 0.5) / steps as f64);
    let on = |wall: &Plate| {
        let (wall, normal) = (*wall, wall.normal());
        middles(12).flat_map(move |s| middles(12).map(move |t| Point { position: wall.at(s, t), normal }))
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
            assert!(packed.abs() < 2e-3 && at_points.abs() < 5e-3 && packed_at_points.abs() < 5e-3, "{found:?}");
        }
    }
}
