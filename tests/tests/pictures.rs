//! Pictures of patches, and pictures held against each other.

use std::path::{Path, PathBuf};

use allbounce_tests::{asset, program::allbounce, text};
use exr::prelude::write_rgb_file;
use radfile::{Container, FormFactors, Record};
use serde_json::Value;

/// Colour of the patch whose row is shown.
const MARK: [u8; 3] = [0, 217, 242];

/// Patches and form factors of the Cornell box.
fn form_factors(folder: &Path) -> PathBuf {
    let (simple, factors) = (folder.join("patches.rad"), folder.join("factors.rad"));
    let cornell = asset("cornell/cornell.obj");
    allbounce(["voxel-simplify", &cornell, "-o", &text(&simple), "--patches", "200", "-q"]).done();
    allbounce(["formfactor", &text(&simple), "-o", &text(&factors), "--rays", "512", "-q"]).done();
    factors
}

fn number(report: &Value, name: &str) -> f64 {
    report[name].as_f64().unwrap_or_else(|| panic!("{name} of {report}"))
}

fn read(report: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(report).expect("a report")).expect("JSON")
}

#[test]
fn a_row_is_that_of_the_patch_at_the_pixel_and_holds_no_more_than_all() {
    let folder = tempfile::tempdir().expect("a folder");
    let (factors, report, picture) =
        (form_factors(folder.path()), folder.path().join("row.json"), folder.path().join("row.png"));
    let (camera, container) = (asset("cornell/camera.json"), Container::open(&factors).expect("a container"));
    let show = |choice: [&str; 2]| {
        let from = ["show", "row", &text(&factors), "--camera", &camera, "--width", "60", "--height", "60", "-q"];
        let to = ["-o", &text(&picture), "--report", &text(&report)];
        allbounce(from.iter().chain(&to).chain(&choice))
    };
    // The floor in front.
    show(["--pixel", "20,55"]).done();
    let found = read(&report);
    assert_eq!(found["normal"], serde_json::json!([0.0, 1.0, 0.0]));
    let row: f64 = number(&found, "row_sum");
    assert!(row > 0.5 && (row + number(&found, "sky") - 1.0).abs() < 1e-5, "row {row} with the sky is 1");
    let patch = found["patch"].as_u64().expect("a patch") as usize;
    let own = FormFactors::read(&container).expect("form factors");
    assert_eq!(found["patches_it_sees"], own.row(patch).iter().filter(|f| **f > 0.0).count());
    let pixels = image::open(&picture).expect("a picture").into_rgb8();
    assert_eq!(pixels.get_pixel(20, 55).0, MARK);
    assert_ne!(pixels.get_pixel(30, 10).0, MARK, "the ceiling is another patch");

    show(["--patch", "99999"]).refused(&["--patch 99999", &format!("there are {} patches", own.len())]);
    show(["--pixel", "60,0"]).refused(&["--pixel 60,0", "60 × 60 pixels"]);
    show(["--pixel", "0,0"]).refused(&["--pixel 0,0", "no patch is seen there"]);
}

#[test]
fn bounces_add_light_up_to_that_of_all() {
    let folder = tempfile::tempdir().expect("a folder");
    let (factors, report) = (form_factors(folder.path()), folder.path().join("light.json"));
    let solved = folder.path().join("solved.rad");
    allbounce(["series", &text(&factors), "-o", &text(&solved), "-q"]).done();
    let (camera, lamp, picture) =
        (asset("cornell/camera.json"), asset("cornell/lamp.json"), folder.path().join("light.exr"));
    let indirect = |options: &[&str]| {
        let from = ["show", "light", &text(&solved), "--camera", &camera, "--lights", &lamp, "--width", "8", "-q"];
        let to = ["-o", &text(&picture), "--report", &text(&report)];
        allbounce(from.iter().chain(&to).chain(options)).done();
        read(&report)["mean_indirect"][1].as_f64().expect("a number")
    };
    assert_eq!(indirect(&["--bounces", "0"]), 0.0);
    let [one, many, all] = [indirect(&["--bounces", "1"]), indirect(&["--bounces", "60"]), indirect(&[])];
    assert!(0.3 * all < one && one < 0.7 * all, "{one} of {all}");
    assert!((many / all - 1.0).abs() < 1e-4, "{many} of {all}");
    let ask = ["show", "light", &text(&factors), "--camera", &camera, "--lights", &lamp, "-o", &text(&picture), "-q"];
    allbounce(ask).refused(&["factors.rad", "no operator", "--bounces K"]);
}

#[test]
fn a_picture_is_itself_and_one_tenth_brighter_is_ten_percent_off() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name);
    let value = |x: usize, y: usize| (10 + x + 3 * y) as f32;
    let paint = |name: &str, size: [usize; 2], factor: f32| {
        let pixel = |x, y| (factor * value(x, y), 0.5 * factor * value(x, y), 0.25 * factor * value(x, y));
        write_rgb_file(file(name), size[0], size[1], pixel).expect("a picture");
    };
    paint("a.exr", [40, 8], 1.0);
    paint("brighter.exr", [40, 8], 1.1);
    paint("small.exr", [20, 8], 1.0);
    let compare = |other: &str, options: &[&str]| {
        let report = text(&file("report.json"));
        let [a, b, map] = [text(&file("a.exr")), text(&file(other)), text(&file("map.png"))];
        allbounce(["compare", &a, &b, "-o", &map, "--report", &report, "-q"].iter().chain(options))
    };
    compare("a.exr", &[]).done();
    let same = read(&file("report.json"));
    assert_eq!([number(&same, "rms"), number(&same, "bias"), number(&same, "largest")], [0.0; 3]);
    compare("brighter.exr", &["--range", "10%", "--beside", &text(&file("beside.png"))]).done();
    let brighter = read(&file("report.json"));
    for name in ["rms", "bias", "percentile_99"] {
        assert!((number(&brighter, name) - 0.1).abs() < 1e-5, "{name}: {brighter}");
    }
    // At the end of the colours.
    let [r, g, b] = image::open(file("map.png")).expect("a map").into_rgb8().get_pixel(5, 5).0;
    assert!(r > 80 && g < 20 && b < 50, "dark red, not {r} {g} {b}");
    assert_eq!(image::open(file("beside.png")).expect("a picture").width(), 40 + 8 + 40);
    compare("small.exr", &[]).refused(&["40 × 8", "20 × 8", "small.exr"]);
    compare("beside.png", &[]).refused(&["beside.png", "expected an .exr file"]);
    std::fs::write(file("broken.exr"), b"v/1\x01 nothing").expect("a file");
    compare("broken.exr", &[]).refused(&["broken.exr", "no readable EXR picture"]);
}
