//! `allbounce chart`: every method is there, more work is less error, and what cannot be done is refused.

use std::path::Path;

use allbounce_tests::{
    mesh_text::{MeshText, Paint},
    program::{Run, allbounce},
    reference::Table,
    shapes::inside_of_box,
    text,
};
use serde_json::{Value, json};

/// A room of two colours with a bulb, as files.
fn room(folder: &Path) {
    let [red, white] = [Paint::matt("red", [0.7, 0.2, 0.2]), Paint::matt("white", [0.7, 0.7, 0.7])];
    let mut mesh = MeshText::default();
    for (wall, plate) in inside_of_box([0.0; 3], [3.0, 2.0, 2.5]).into_iter().enumerate() {
        plate.add(&mut mesh, if wall == 0 { red } else { white });
    }
    let lamp = json!({ "type": "point", "position": [1.1, 1.2, 0.9], "intensity": [10.0, 9.0, 8.0] });
    let dark = json!({ "type": "point", "position": [10.0, 1.2, 0.9], "intensity": [10.0, 9.0, 8.0] });
    let files = [("room.obj", mesh.obj("room.mtl")), ("room.mtl", mesh.mtl())];
    let lights =
        [("lamp.json", lamp), ("outside.json", dark)].map(|(name, l)| (name, json!({ "lights": [l] }).to_string()));
    for (name, content) in files.into_iter().chain(lights) {
        std::fs::write(folder.join(name), content).expect("a file");
    }
}

fn chart(folder: &Path, lights: &str, options: &[&str]) -> Run {
    let [scene, lights, out] = ["room.obj", lights, "out"].map(|name| text(&folder.join(name)));
    allbounce(["chart", &scene, "--lights", &lights, "-o", &out, "--quick", "-q"].iter().chain(options))
}

/// Entries of a method.
fn of<'a>(report: &'a Value, method: &str) -> Vec<&'a Value> {
    let entries = report["entries"].as_array().expect("entries").iter();
    entries.filter(|e| e["method"].as_str().is_some_and(|m| m.contains(method))).collect()
}

fn number(entry: &Value, name: &str) -> f64 {
    entry[name].as_f64().unwrap_or_else(|| panic!("{name} of {entry}"))
}

#[test]
fn allbounce_is_nearer_to_the_truth_than_the_published_method_and_paths_come_nearer_with_their_number() {
    let folder = tempfile::tempdir().expect("a folder");
    room(folder.path());
    let (out, file) = (folder.path().join("out"), text(&folder.path().join("report.json")));
    chart(folder.path(), "lamp.json", &["--note", "a note", "--report", &file]).done();
    let report: Value = serde_json::from_str(&std::fs::read_to_string(&file).expect("a report")).expect("JSON");
    let [gather, interpolate, published, paths] =
        ["last gather", "interpolated", "published", "path tracing"].map(|method| of(&report, method));
    let rms = |entries: &[&Value]| number(entries[0], "rms");
    assert!(rms(&gather) < 0.1 && number(gather[0], "bias").abs() < 0.02, "{gather:?}");
    assert!(rms(&gather) < rms(&interpolate) && rms(&interpolate) < 0.5 * rms(&published), "{report}");
    // Sixteen times as many paths are a quarter of the error, or less where they are stratified.
    let fell = number(paths[1], "rms") / rms(&paths);
    assert!(fell < 0.35 && number(paths[1], "change_ms") > number(paths[0], "change_ms"), "{paths:?}");
    // Form factors are kept by all but paths, and no row is missing in the table.
    assert!(number(gather[0], "bytes") > number(interpolate[0], "bytes") && number(paths[0], "bytes") == 0.0);
    let table = Table::read(&out.join("chart.csv"));
    let entries = report["entries"].as_array().expect("entries");
    assert_eq!(table.column("rms").len(), entries.len());
    for (entry, rms) in entries.iter().zip(table.column("rms")) {
        assert!((rms / number(entry, "rms") - 1.0).abs() < 1e-4, "{entry}, in the table {rms}");
    }
    let read = |name: &str| std::fs::read_to_string(out.join(name)).expect(name);
    for method in entries.iter().map(|e| e["method"].as_str().expect("a name")) {
        assert!(read("chart.svg").contains(method) && read("chart.md").contains(method), "{method} is not shown");
    }
    assert!(read("chart.md").contains("a note") && read("chart.csv").contains("a note"));
    // What cannot be told from the truth's noise is a bound, and never drawn below.
    let least = 0.5 * number(&report, "truth_noise");
    assert!(entries.iter().all(|e| number(e, "rms") >= least), "{report}");
    for (entry, bound) in entries.iter().zip(table.column("rms_is_bound")) {
        assert_eq!(entry["rms_is_bound"].as_bool(), Some(bound == 1.0), "{entry}");
        assert_eq!(bound == 1.0, number(entry, "rms") == least, "{entry}");
    }
    // Truth that is read again is the same truth.
    let truth = folder.path().join("truth.csv");
    std::fs::rename(out.join("truth.csv"), &truth).expect("the truth is written");
    let again = folder.path().join("again.json");
    chart(folder.path(), "lamp.json", &["--truth", &text(&truth), "--methods", "gather", "--report", &text(&again)])
        .done();
    let again: Value = serde_json::from_str(&std::fs::read_to_string(&again).expect("a report")).expect("JSON");
    assert_eq!(again["entries"].as_array().map(Vec::len), Some(1));
    assert!((number(&again["entries"][0], "rms") / rms(&gather) - 1.0).abs() < 1e-4, "{again}");
}

#[test]
fn a_camera_sees_the_light_of_every_method_side_by_side() {
    let folder = tempfile::tempdir().expect("a folder");
    room(folder.path());
    let (camera, file) = (folder.path().join("camera.json"), text(&folder.path().join("report.json")));
    let inside = json!({ "origin": [0.2, 1.0, 0.2], "target": [2.5, 0.9, 2.2], "up": [0, 1, 0], "fov_x_deg": 70.0 });
    std::fs::write(&camera, inside.to_string()).expect("a file");
    let options =
        ["--camera", &text(&camera), "--size", "40x30", "--receivers", "20", "--methods", "gather,path-tracing"];
    chart(folder.path(), "lamp.json", &[&options[..], &["--report", &file]].concat()).done();
    let report: Value = serde_json::from_str(&std::fs::read_to_string(&file).expect("a report")).expect("JSON");
    let picture = image::open(folder.path().join("out/side-by-side.png")).expect("a picture").into_rgb8();
    // Five columns with gaps of eight pixels, one row with four lines below: the truth, then a tile a method.
    let shown = report["side_by_side"].as_array().expect("entries");
    let below = plot::caption_height(4);
    assert_eq!(picture.dimensions(), (5 * 40 + 4 * 8, 30 + below));
    // Where there is no tile all is white; few paths leave single pixels so.
    let lit = |tile: u32| (0..1200).filter(|p| picture[(48 * tile + p % 40, p / 40)].0 != [255; 3]).count() > 600;
    let tiles = (0..5).filter(|tile| lit(*tile)).count();
    let methods: std::collections::BTreeSet<&str> = shown.iter().filter_map(|e| e["method"].as_str()).collect();
    assert_eq!((tiles, methods.len()), (3, 2), "{report}");
    // The gather looks like the truth, few paths do not.
    let mean = |tile: u32| {
        let differences = (0..1200).flat_map(|p| {
            let [truth, other] = [0, tile].map(|t| picture[(48 * t + p % 40, p / 40)].0);
            std::array::from_fn::<f64, 3, _>(|c| (f64::from(truth[c]) - f64::from(other[c])).abs())
        });
        differences.sum::<f64>() / 3600.0
    };
    assert!(mean(1) < 0.5 * mean(2), "{} and {} of 255", mean(1), mean(2));
    assert!(number(&shown[0], "rms") < 0.1, "{report}");
    let page = std::fs::read_to_string(folder.path().join("out/chart.md")).expect("a page");
    assert!(page.contains("side-by-side.png"), "{page}");
}

#[test]
fn what_cannot_be_charted_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    room(folder.path());
    let unknown = chart(folder.path(), "lamp.json", &["--methods", "gather,magic"]);
    assert_eq!(unknown.code, Some(2), "{unknown:?}");
    for part in ["magic", "path-tracing", "published"] {
        assert!(unknown.stderr.contains(part), "{part} is not in: {}", unknown.stderr);
    }
    let alone = chart(folder.path(), "lamp.json", &["--size", "40x30"]);
    assert!(alone.code == Some(2) && alone.stderr.contains("--camera"), "{alone:?}");
    let endless = chart(folder.path(), "lamp.json", &["--camera", "scene", "--size", "40x0"]);
    assert!(endless.code == Some(2) && endless.stderr.contains("320x240"), "{endless:?}");
    // A bulb outside of a closed room lights nothing in it.
    chart(folder.path(), "outside.json", &["--methods", "gather"]).refused(&["outside.json", "no indirect light"]);
    let lights = text(&folder.path().join("lamp.json"));
    chart(folder.path(), "lamp.json", &["--truth", &format!("{lights},{lights}")]).refused(&["--truth has 2 files"]);
    chart(folder.path(), "lamp.json", &["--truth", &lights]).refused(&["lamp.json", "column px"]);
}
