//! Form factors through the whole program: at UTM coordinates, and to a target error.

use std::{fmt::Write, path::Path};

use allbounce_tests::{asset, program::allbounce, reference::shared, text};
use radfile::{Container, FormFactors, Patches, Record};
use serde_json::Value;

/// A room of 4 × 2.5 × 3 m with a box of 1 m on its floor, walls inwards, scaled and moved.
fn room(scale: f64, offset: [f64; 3]) -> String {
    let mut obj = String::new();
    let boxes: [([f64; 3], [f64; 3], bool); 2] =
        [([0.0; 3], [4.0, 2.5, 3.0], true), ([1.0, 0.001, 1.25], [2.0, 1.001, 2.25], false)];
    for (low, high, inwards) in boxes {
        for axis in 0..3 {
            for side in [low, high] {
                let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut corners = [[low[b], low[c]], [high[b], low[c]], [high[b], high[c]], [low[b], high[c]]];
                if (side == high) == inwards {
                    corners.reverse();
                }
                for [y, z] in corners {
                    let mut p = [0.0; 3];
                    (p[axis], p[b], p[c]) = (side[axis], y, z);
                    let [x, y, z]: [f64; 3] = std::array::from_fn(|a| p[a] * scale + offset[a]);
                    writeln!(obj, "v {x:.4} {y:.4} {z:.4}").expect("a string");
                }
                obj.push_str("f -4 -3 -2 -1\n");
            }
        }
    }
    obj
}

/// Patches and form factors of a scene file.
fn factors(scene: &str, folder: &Path, options: &[&str]) -> (Patches, FormFactors<'static>, Value) {
    let [simple, output, report] = ["1.rad", "2.rad", "2.json"].map(|name| text(&folder.join(name)));
    allbounce(["voxel-simplify", scene, "-o", &simple, "--patches", options[0], "-q"]).done();
    let args = ["formfactor", &simple, "-o", &output, "--report", &report, "-q"];
    allbounce(args.iter().chain(&options[1..])).done();
    let container = Container::open(Path::new(&output)).expect("a container");
    let f = FormFactors::read(&container).expect("form factors");
    let owned = FormFactors { values: f.values.into_owned().into(), sky: f.sky.into_owned().into() };
    let report = std::fs::read_to_string(report).expect("a report");
    (Patches::read(&container).expect("patches"), owned, serde_json::from_str(&report).expect("JSON"))
}

/// RMS difference of rows relative to their RMS length, by area.
fn difference(patches: &Patches, a: &FormFactors, b: &FormFactors) -> f64 {
    let (mut error, mut length) = (0.0, 0.0);
    for (i, &area) in patches.area.iter().enumerate() {
        for (&a, &b) in a.row(i).iter().zip(b.row(i)) {
            error += f64::from(area) * f64::from(a - b).powi(2);
            length += f64::from(area) * f64::from(a).powi(2);
        }
    }
    (error / length).sqrt()
}

/// Coordinates of 5 million leave single precision half a metre; they are centred in double precision first.
#[test]
fn a_room_at_utm_coordinates_has_the_form_factors_of_one_at_the_origin() {
    let folder = tempfile::tempdir().expect("a folder");
    let of = |scale: f64, offset: [f64; 3]| {
        let scene = folder.path().join("room.obj");
        std::fs::write(&scene, room(scale, offset)).expect("a file");
        factors(&text(&scene), folder.path(), &["200", "--rays", "4096"])
    };
    let (patches, here, _) = of(1.0, [0.0; 3]);
    for (scale, offset) in [(1.0, [5e5, 20.0, 4_649_776.0]), (1000.0, [5e8, 2e4, 4.649_776e9])] {
        let (moved, there, report) = of(scale, offset);
        assert_eq!(moved.len(), patches.len(), "scale {scale}");
        let areas = moved.area.iter().zip(&patches.area).map(|(a, b)| (a / b) as f64 / scale.powi(2) - 1.0);
        let worst = areas.fold(0.0f64, |m, e| m.max(e.abs()));
        let found = difference(&patches, &here, &there);
        println!("scale {scale}: rows differ by {found:.2e}, areas by {worst:.2e}");
        assert!(worst < 1e-4, "areas differ by {worst}");
        assert!(found < 2e-3, "rows differ by {found} of their length");
        assert_eq!((report["escaped"].as_u64(), report["absorbed"].as_u64()), (Some(0), Some(0)), "the room leaks");
    }
}

#[test]
fn the_cornell_box_at_utm_coordinates_has_its_form_factors() {
    let Some(utm) = shared("scenes/dirty/CornellBox_utm.obj") else { return };
    let Some(original) = shared("scenes/cornell_box/CornellBox-Original.obj") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let of = |scene: &Path| factors(&text(scene), folder.path(), &["300", "--rays", "4096"]);
    let ((patches, here, _), (moved, there, _)) = (of(&original), of(&utm));
    assert_eq!(moved.len(), patches.len());
    let found = difference(&patches, &here, &there);
    println!("Cornell box at UTM coordinates: rows differ by {found:.2e}");
    assert!(found < 2e-3, "rows differ by {found} of their length");
}

/// Indirect irradiance of lamps that hang where the report's do not: a metre before every 67th patch, shining on
/// what that patch sees by `shadows`.
fn light(patches: &Patches, f: &FormFactors, shadows: &FormFactors) -> Vec<Vec<f64>> {
    let vector = |v: [f32; 3]| v.map(f64::from);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let sees = |i: usize, at: usize| i == at || shadows.row(at)[i] > 0.0;
    let direct = |i: usize, at: usize| {
        let (p, n, q, m) = (patches.position[i], patches.normal[i], patches.position[at], patches.normal[at]);
        let (p, n, q, m) = (vector(p), vector(n), vector(q), vector(m));
        let away: [f64; 3] = std::array::from_fn(|a| q[a] + m[a] - p[a]);
        let square = dot(away, away) + f64::from(patches.area[i]) / std::f64::consts::PI;
        if sees(i, at) { (dot(away, n) / square.powf(1.5)).max(0.0) } else { 0.0 }
    };
    let n = patches.len();
    let rho: Vec<f64> = patches.reflectance.iter().map(|r| f64::from(r[0] + r[1] + r[2]) / 3.0).collect();
    let solve = |at: usize| {
        let mut light = vec![0.0; n];
        for _ in 0..30 {
            let b: Vec<f64> = (0..n).map(|j| rho[j] * (light[j] + direct(j, at))).collect();
            light = (0..n).map(|i| f.row(i).iter().zip(&b).map(|(f, b)| f64::from(*f) * b).sum()).collect();
        }
        light
    };
    (0..n).step_by(67).map(solve).collect()
}

/// One per cent of final light in the bundled apartment, judged by 16 times the rays, under lamps that hang nearer to
/// surfaces than those of the report.
#[test]
fn the_apartment_needs_less_than_4000_rays_for_one_per_cent() {
    let folder = tempfile::tempdir().expect("a folder");
    let of = |options: &[&str]| factors(&asset("apartment/apartment.obj"), folder.path(), options);
    let (patches, coarse, report) = of(&["1300", "--ff-error", "1%"]);
    let mean = report["rays_mean"].as_f64().expect("a number");
    assert!(report["target_met"] == true && mean < 4000.0, "{report}");
    let rays = (16.0 * mean).round().to_string();
    let (_, fine, _) = of(&["1300", "--rays", &rays, "--seed", "7"]);
    let even = mean.round().to_string();
    let (_, even, _) = of(&["1300", "--rays", &even]);
    let truth = light(&patches, &fine, &fine);
    let error = |f: &FormFactors| {
        let relative = |(a, b): (&Vec<f64>, &Vec<f64>)| {
            let square =
                |e: &dyn Fn(usize) -> f64| (0..b.len()).map(|i| f64::from(patches.area[i]) * e(i).powi(2)).sum::<f64>();
            square(&|i| a[i] - b[i]) / square(&|i| b[i])
        };
        (light(&patches, f, &fine).iter().zip(&truth).map(relative).sum::<f64>() / truth.len() as f64).sqrt()
    };
    let (by_error, evenly) = (error(&coarse), error(&even));
    println!(
        "{mean:.0} rays a patch: error {by_error:.4}, said {}, spread evenly {evenly:.4}",
        report["irradiance_error"]
    );
    assert!(by_error < 0.01, "error {by_error} against 16 times the rays");
}
