//! The whole pipeline against points that another renderer path-traced.

use std::path::{Path, PathBuf};

use allbounce_tests::{
    program::allbounce,
    reference::{Score, Table, score, shared},
    text,
};

/// Bakes a scene and evaluates a reference set; `None` where the set is absent.
fn answer(folder: &Path, scene: &str, lights: &str, set: &str, patches: u32) -> Option<(Table, Table)> {
    let (scene, lights) = (shared(&format!("scenes/{scene}"))?, shared(&format!("reference/lights/{lights}"))?);
    let reference = Table::read(&shared(&format!("reference/results/{set}"))?);
    let file = |name: &str| -> PathBuf { folder.join(name) };
    let (bake, points, out) = (file("bake.rad"), file("points.csv"), file("out.csv"));
    reference.export(&["id", "px", "py", "pz", "nx", "ny", "nz"], &points);
    let count = patches.to_string();
    // Only points are asked for, which gather by themselves; vertices may be as rough as they like.
    let rough = ["--gather-rays", "16", "--gather-error", "50%", "--quiet"];
    allbounce(["bake", &text(&scene), "-o", &text(&bake), "--patches", &count].iter().chain(&rough)).done();
    allbounce([
        "relight",
        &text(&bake),
        "--lights",
        &text(&lights),
        "--points",
        &text(&points),
        "-o",
        &text(&out),
        "--quiet",
    ])
    .done();
    Some((Table::read(&out), reference))
}

fn scores(answer: &Table, reference: &Table) -> (Score, Score) {
    let of = |name: &str| score(&answer.grey(name), &reference.grey(name), &reference.grey(&format!("se_{name}")));
    (of("direct"), of("indirect"))
}

#[test]
fn cornell_box_with_its_lamp_agrees_with_the_path_tracer() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some((ours, theirs)) =
        answer(folder.path(), "cornell_box/cornell_box.glb", "cornell_area.json", "cornell_area.csv", 2500)
    else {
        return;
    };
    let (direct, indirect) = scores(&ours, &theirs);
    println!("direct {direct:?}\nindirect {indirect:?}");
    assert!(direct.bias.abs() < 0.02 && direct.rms < 0.02, "{direct:?}");
    assert!(indirect.bias.abs() < 0.006 && indirect.rms < 0.025, "{indirect:?}");
}

#[test]
fn cornell_box_with_a_bulb_agrees_with_the_path_tracer() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some((ours, theirs)) =
        answer(folder.path(), "cornell_box/cornell_box.glb", "cornell_point.json", "cornell_point.csv", 2500)
    else {
        return;
    };
    let (direct, indirect) = scores(&ours, &theirs);
    println!("direct {direct:?}\nindirect {indirect:?}");
    assert!(direct.bias.abs() < 0.02, "{direct:?}");
    assert!(indirect.bias.abs() < 0.006 && indirect.rms < 0.025, "{indirect:?}");
}

#[test]
fn a_sealed_room_beside_a_lit_one_stays_exactly_dark() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some((ours, theirs)) = answer(folder.path(), "rooms/rooms.glb", "rooms_room0.json", "rooms_room0.csv", 2000)
    else {
        return;
    };
    // The fourth room lies beyond z = -11.28 m (rooms_info.json beside the scene).
    let depth = theirs.column("pz");
    let sealed: Vec<usize> = (0..depth.len()).filter(|&i| depth[i] < -11.28).collect();
    // The sealed room adds nothing to either mean, so these are the biases of the lit points.
    let (lit_direct, lit_indirect) = scores(&ours, &theirs);
    println!("{} points in the sealed room; direct {lit_direct:?}, indirect {lit_indirect:?}", sealed.len());
    assert!(lit_direct.bias.abs() < 0.02, "{lit_direct:?}");
    assert!(lit_indirect.bias.abs() < 0.005 && lit_indirect.rms < 0.03, "{lit_indirect:?}");
    assert!(sealed.len() > 100, "{} points", sealed.len());
    // Elsewhere it is dark under furniture: no light of the floor around it leaks there.
    let truth = theirs.grey("indirect");
    let mean = truth.iter().sum::<f64>() / truth.len() as f64;
    let (direct, indirect) = (ours.grey("direct"), ours.grey("indirect"));
    for i in (0..truth.len()).filter(|&i| truth[i] < 1e-3 * mean) {
        assert!(indirect[i] < 1e-3 * mean, "point {i} should be dark, it has {} of the mean", indirect[i] / mean);
    }
    for i in sealed {
        assert_eq!((direct[i], indirect[i]), (0.0, 0.0), "point {i}");
    }
}

#[test]
fn a_furnace_is_equally_bright_everywhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some((ours, theirs)) = answer(folder.path(), "furnace/furnace_50.glb", "furnace.json", "furnace_50.csv", 600)
    else {
        return;
    };
    let (direct, indirect) = scores(&ours, &theirs);
    println!("direct {direct:?}\nindirect {indirect:?}");
    for (d, i) in ours.grey("direct").iter().zip(ours.grey("indirect")) {
        let pi = std::f64::consts::PI;
        assert!(
            (d / pi - 1.0).abs() < 0.01 && (i / pi - 1.0).abs() < 0.01,
            "direct {d}, indirect {i}, both should be π"
        );
    }
}

#[test]
fn sponza_under_three_lamps_has_the_right_mean() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some((ours, theirs)) =
        answer(folder.path(), "sponza/sponza.glb", "sponza_points.json", "sponza_points.csv", 4000)
    else {
        return;
    };
    let (direct, indirect) = scores(&ours, &theirs);
    println!("direct {direct:?}\nindirect {indirect:?}");
    assert!(indirect.bias.abs() < 0.02 && indirect.rms < 0.09, "{indirect:?}");
}
