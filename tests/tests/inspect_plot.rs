//! Pictures of the operator, and that their numbers add up.

use std::path::{Path, PathBuf};

use allbounce_tests::{asset, program::allbounce, text};
use serde_json::Value;

const NAMES: [&str; 6] = ["matrix", "values", "blocks", "error", "sizes", "speeds"];

/// Runs a stage with options on a container, gives the container that it made.
fn stage(name: &str, input: &Path, options: &[&str]) -> PathBuf {
    let output = input.with_file_name(format!("{name}{}.rad", options.len()));
    allbounce([name, &text(input), "-o", &text(&output), "-q"].iter().chain(options)).done();
    output
}

/// Patches of the Cornell box.
fn patches(folder: &Path) -> PathBuf {
    let simple = folder.join("patches.rad");
    let cornell = asset("cornell/cornell.obj");
    allbounce(["voxel-simplify", &cornell, "-o", &text(&simple), "--patches", "150", "-q"]).done();
    simple
}

/// The dense operator of the Cornell box.
fn solved(folder: &Path) -> PathBuf {
    stage("series", &stage("formfactor", &patches(folder), &["--rays", "512"]), &[])
}

/// Plots a container into a folder of its name, and gives the report.
fn plotted(container: &Path) -> Value {
    let (folder, report) = (container.with_extension("plots"), container.with_extension("json"));
    allbounce(["inspect", &text(container), "--plot", &text(&folder), "--report", &text(&report), "-q"]).done();
    let report: Value = serde_json::from_str(&std::fs::read_to_string(report).expect("a report")).expect("JSON");
    let page = std::fs::read_to_string(folder.join("index.md")).expect("a page");
    for name in NAMES {
        let plot = plot(&report, name);
        assert!(page.contains(plot["sentence"].as_str().expect("a sentence")), "{name}");
        let drawn = plot["drawn"] == true;
        let file = |kind: &str| folder.join(format!("{name}.{kind}"));
        assert_eq!([file("svg").is_file(), file("png").is_file()], [drawn; 2], "{name}");
        if drawn {
            assert_legal(&std::fs::read_to_string(file("svg")).expect("UTF-8"));
            let picture = image::open(file("png")).expect("a picture").into_rgb8();
            assert!(picture.pixels().any(|p| p != picture.get_pixel(0, 0)), "{name} is empty");
        }
    }
    report
}

fn plot<'a>(report: &'a Value, name: &str) -> &'a Value {
    let plots = report["plots"].as_array().expect("plots");
    plots.iter().find(|plot| plot["name"] == name).unwrap_or_else(|| panic!("no {name} in {report}"))
}

fn numbers<'a>(report: &'a Value, name: &str) -> &'a Value {
    &plot(report, name)["numbers"]
}

fn sum(values: &Value, of: impl Fn(&Value) -> &Value) -> u64 {
    values.as_array().expect("a list").iter().map(|v| of(v).as_u64().expect("a count")).sum()
}

/// Every element ends in the one that it began in, and no text has a bare ampersand.
fn assert_legal(svg: &str) {
    let mut open: Vec<&str> = Vec::new();
    for part in svg.split('<').skip(1) {
        let (tag, rest) = part.split_once('>').expect("an element that ends");
        assert!(!rest.contains('>'), "{rest}");
        let name = tag.trim_start_matches('/').split([' ', '\n', '/']).next().unwrap_or("");
        match (tag.starts_with('/'), tag.ends_with('/') || tag.starts_with(['?', '!'])) {
            (true, _) => assert_eq!(open.pop(), Some(name)),
            (false, false) => open.push(name),
            (false, true) => {}
        }
    }
    assert!(open.is_empty() && svg.contains("<svg "), "{open:?} stay open");
    let entities = ["amp;", "lt;", "gt;", "quot;", "apos;", "#"];
    assert!(svg.split('&').skip(1).all(|rest| entities.iter().any(|entity| rest.starts_with(entity))));
}

#[test]
fn an_order_moves_entries_and_is_undone_for_the_picture_before() {
    let folder = tempfile::tempdir().expect("a folder");
    let solved = solved(folder.path());
    let [first, permuted] = [&solved, &stage("permute", &solved, &[])].map(|container| plotted(container));
    assert_eq!(numbers(&first, "values"), numbers(&permuted, "values"), "the same entries");
    let values = numbers(&first, "values");
    let [entries, zero, tiny] = ["entries", "zero", "tiny"].map(|name| values[name].as_u64().expect("a count"));
    assert_eq!(sum(&values["linear"], |v| v), entries);
    assert_eq!(sum(&values["logarithmic"], |v| v) + zero + tiny, entries);

    let order = |report: &Value, at: usize| {
        let order = numbers(report, "matrix")["orders"][at].clone();
        ["mean", "neighbours_differ_by"].map(|name| order[name].as_f64().expect("a number"))
    };
    let [made, before, after] = [order(&first, 0), order(&permuted, 0), order(&permuted, 1)];
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b;
    assert!(close(before[0], made[0]) && close(before[1], made[1]), "{before:?} is not {made:?}");
    assert!(close(after[0], made[0]) && (after[1] - made[1]).abs() > 1e-4 * made[1], "{after:?} against {made:?}");
    for name in ["blocks", "error", "speeds"] {
        assert!(plot(&first, name)["sentence"].as_str().expect("a sentence").contains("run hmatrix"), "{name}");
    }
}

#[test]
fn blocks_cover_the_matrix_and_bytes_add_up_to_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let permuted = stage("permute", &solved(folder.path()), &[]);
    let kept = stage("hmatrix", &permuted, &["--keep-dense"]);
    let report = plotted(&kept);
    assert!(NAMES.iter().all(|name| plot(&report, name)["drawn"] == true), "{report}");

    let blocks = numbers(&report, "blocks");
    let n = blocks["patches"].as_u64().expect("a count");
    let (kinds, mut bytes) = (["zero", "mean", "low_rank", "tile"], blocks["structure_bytes"].as_u64().expect("bytes"));
    for plane in blocks["planes"].as_array().expect("planes") {
        let total = |what: &str| kinds.iter().map(|kind| plane[kind][what].as_u64().expect("a count")).sum::<u64>();
        assert_eq!(total("entries"), n * n);
        bytes += total("bytes");
    }
    let sections = report["sections"].as_array().expect("sections");
    let packed = sections.iter().find(|section| section["name"] == "hmatrix.blocks").expect("the blocks");
    assert_eq!(packed["bytes"], bytes);

    let sizes = numbers(&report, "sizes");
    let length = std::fs::metadata(&kept).expect("the file").len();
    assert_eq!([sizes["bytes"].as_u64(), Some(sum(&sizes["parts"], |part| &part["bytes"]))], [Some(length); 2]);
    assert_eq!(sizes["dense_form_factors"], 4 * n * n);

    // Packed to 0.5 % of the light, of which even light has less; entries differ by more.
    let [rms, apart] = [("error", "rms"), ("speeds", "disagreement")]
        .map(|(name, number)| numbers(&report, name)[number].as_f64().expect("a number"));
    assert!((1e-4..0.2).contains(&rms), "entries differ by {rms}");
    assert!((1e-7..0.01).contains(&apart), "light differs by {apart}");
}

#[test]
fn what_is_missing_is_said_and_by_which_option_it_is_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let solved = solved(folder.path());
    let light = plotted(&stage("hmatrix", &solved, &[]));
    for name in ["matrix", "values", "error"] {
        assert!(plot(&light, name)["sentence"].as_str().expect("a sentence").contains("--keep-dense"), "{name}");
    }
    assert_eq!(numbers(&light, "speeds")["made_up"], true);
    let textures = plotted(&stage("dxt-pack", &solved, &["--keep-dense"]));
    assert_eq!(plot(&textures, "blocks")["drawn"], false);
    assert_eq!(plot(&textures, "error")["drawn"], true);
    // One bounce is compared with W, solved in the frame, and gives the light of all bounces.
    let one = plotted(&stage("hmatrix", &solved, &["--keep-dense", "--kernel", "one-bounce"]));
    assert_eq!(numbers(&one, "error")["matrix"], "W");
    let apart = numbers(&one, "speeds")["disagreement"].as_f64().expect("a number");
    assert!(apart < 0.02, "light differs by {apart}");
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let (simple, plots) = (patches(folder.path()), folder.path().join("plots"));
    let plot = |folder: &Path| allbounce(["inspect", &text(&simple), "--plot", &text(folder), "-q"]);
    plot(&plots).refused(&["patches.rad", "neither an operator nor form factors"]);
    assert!(!plots.exists(), "nothing was made");
    let factors = stage("formfactor", &simple, &["--rays", "256"]);
    std::fs::write(&plots, "a file").expect("a file");
    allbounce(["inspect", &text(&factors), "--plot", &text(&plots), "-q"]).refused(&["plots", "expected a folder"]);
    // Nor is the container overwritten.
    let inside = folder.path().join("index.md");
    std::fs::copy(&factors, &inside).expect("a copy");
    let ask = ["inspect", &text(&inside), "--plot", &text(folder.path()), "-q"];
    allbounce(ask).refused(&["index.md", "would overwrite the container"]);
}
