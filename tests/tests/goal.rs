//! Bakes that are asked for a result: `bake --error`, `--memory`, `--time-per-frame`.

use std::path::{Path, PathBuf};

use allbounce_tests::{
    asset,
    program::allbounce,
    reference::{Table, score, shared},
    root, text,
};
use radfile::{Accuracy, Container, Provenance, Record};
use serde_json::Value;

/// Bakes the Cornell box for a goal; the file and the report.
fn bake(folder: &Path, name: &str, goal: &[&str]) -> (PathBuf, Value) {
    bake_of(&asset("cornell/cornell.obj"), folder, name, goal)
}

fn bake_of(scene: &str, folder: &Path, name: &str, goal: &[&str]) -> (PathBuf, Value) {
    let (file, report) = (folder.join(format!("{name}.rad")), folder.join(format!("{name}.json")));
    let (output, numbers) = (text(&file), text(&report));
    allbounce(["bake", scene, "-o", &output, "--report", &numbers, "-q"].iter().chain(goal)).done();
    let report = std::fs::read_to_string(report).expect("a report");
    (file, serde_json::from_str(&report).expect("JSON"))
}

#[test]
fn an_error_is_kept_under_other_lights_and_said_in_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let (coarse, coarse_report) = bake(folder.path(), "coarse", &["--error", "20%"]);
    let (_, fine_report) = bake(folder.path(), "fine", &["--error", "8%"]);
    let accuracy = Accuracy::read(&Container::open(&coarse).expect("a container")).expect("an accuracy");
    assert_eq!(accuracy.error_wanted, Some(0.2));
    assert!(accuracy.rms > 0.02 && accuracy.rms <= 0.2, "{accuracy:?}");
    let mean = accuracy.lights.iter().map(|l| l.rms).sum::<f64>() / accuracy.lights.len() as f64;
    assert!(accuracy.lights.len() >= 4 && (mean - accuracy.rms).abs() < 1e-9, "{accuracy:?}");
    let parts = accuracy.parts;
    assert!(parts.packing <= 0.035 && parts.form_factors <= 0.05 && parts.solver < 1e-6, "{parts:?}");
    let rms = fine_report["accuracy"]["rms"].as_f64().expect("a number");
    assert!(rms <= 0.08 && rms < accuracy.rms, "{rms} against {}", accuracy.rms);
    let of = |report: &Value, key: &str| report[key].as_f64().expect("a number");
    for key in ["patches", "bytes_of_frames"] {
        assert!(of(&coarse_report, key) < of(&fine_report, key), "{key}");
    }
}

#[test]
fn what_a_goal_chooses_can_be_typed_and_does_not_depend_on_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let (chosen, _) = bake(folder.path(), "chosen", &["--error", "20%"]);
    let (again, _) = bake(folder.path(), "again", &["--error", "20%", "--threads", "1"]);
    assert!(std::fs::read(&chosen).expect("bytes") == std::fs::read(again).expect("bytes"), "threads change the file");

    let chosen = Container::open(&chosen).expect("a container");
    let mut input = asset("cornell/cornell.obj");
    for step in Provenance::read(&chosen).expect("steps").steps {
        let output = text(&folder.path().join(format!("{}.rad", step.stage)));
        let mut args = vec![step.stage.clone(), input, "-o".into(), output.clone(), "-q".into()];
        args.extend(step.options.split_whitespace().map(String::from));
        allbounce(args).done();
        input = output;
    }
    let typed = Container::open(Path::new(&input)).expect("a container");
    for section in chosen.sections().iter().filter(|s| s.name != "provenance" && s.name != "accuracy.meta") {
        let same = chosen.data(section) == typed.data(typed.section(&section.name).expect("the section"));
        assert!(same, "{} differs from what its options make", section.name);
    }
}

#[test]
fn a_simple_room_pays_for_no_elements_and_says_what_interpolation_errs() {
    let folder = tempfile::tempdir().expect("a folder");
    let room = text(&root().join("tests/data/grey/room.obj"));
    let (coarse, coarse_report) = bake_of(&room, folder.path(), "coarse", &["--error", "20%"]);
    let (_, fine_report) = bake_of(&room, folder.path(), "fine", &["--error", "5%"]);
    let coarse = Container::open(&coarse).expect("a container");
    assert!(coarse.has("transfer.weight") && !coarse.has("elements.start"));
    assert_eq!(coarse_report["patches"], fine_report["patches"]);
    let of = |report: &Value, keys: [&str; 2]| report[keys[0]][keys[1]].as_f64().expect("a number");
    let [interpolated, gathered] = [&coarse_report, &fine_report].map(|report| of(report, ["accuracy", "rms"]));
    assert!(gathered <= 0.05 && interpolated > 1.5 * gathered && interpolated <= 0.2, "{interpolated}, {gathered}");
    let [small, large] = [&coarse_report, &fine_report].map(|report| report["bytes_of_frames"].as_f64());
    assert!(3.0 * small.expect("a number") < large.expect("a number"), "{small:?}, {large:?}");
}

#[test]
fn memory_and_time_are_kept_or_refused_with_a_figure() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_, report) = bake(folder.path(), "small", &["--memory", "300KiB"]);
    let bytes = report["bytes_of_frames"].as_u64().expect("a number");
    assert!(bytes > 100 << 10 && bytes <= 300 << 10, "{bytes} bytes");
    let cornell = asset("cornell/cornell.obj");
    let output = text(&folder.path().join("none.rad"));
    let goal = |options: &[&str]| allbounce(["bake", &cornell, "-o", &output].iter().chain(options));
    goal(&["--memory", "1KiB"]).refused(&["the coarsest bake takes", "more than 1.0 KiB", "allow more"]);
    goal(&["--error", "20%", "--time-per-frame", "1us"])
        .refused(&["ms a frame, more than 1.00 µs (--time-per-frame)", "larger --error"]);
    for clash in [["--patches", "300"], ["--rays", "512"], ["--operator", "textures"], ["--gather-rays", "64"]] {
        let run = goal(&[&["--error", "5%"][..], &clash].concat());
        assert!(run.code == Some(2) && run.stderr.contains("cannot be used with"), "{clash:?}: {}", run.stderr);
    }
    assert_eq!(goal(&["--error", "90%"]).code, Some(2));
    assert!(!Path::new(&output).exists(), "a refused bake leaves no file");
}

#[test]
fn a_scene_without_bounces_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("wall.obj");
    std::fs::write(&scene, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").expect("a file");
    let output = text(&folder.path().join("wall.rad"));
    allbounce(["bake", &text(&scene), "-o", &output, "--error", "5%"]).refused(&["wall.obj", "no indirect light"]);
}

/// Certificate and error at another renderer's points under its own lights.
fn against(folder: &Path, scene: &str, sets: &[&str]) -> Option<(Accuracy, Vec<f64>)> {
    let bake = text(&folder.join("bake.rad"));
    allbounce(["bake", &text(&shared(scene)?), "-o", &bake, "--error", "5%", "-q"]).done();
    let mut errors = Vec::new();
    for set in sets {
        let reference = Table::read(&shared(&format!("reference/results/{set}.csv"))?);
        let lights = text(&shared(&format!("reference/lights/{set}.json"))?);
        let (points, out) = (folder.join("points.csv"), folder.join("out.csv"));
        reference.export(&["id", "px", "py", "pz", "nx", "ny", "nz"], &points);
        allbounce(["relight", &bake, "--lights", &lights, "--points", &text(&points), "-o", &text(&out), "-q"]).done();
        let ours = Table::read(&out);
        errors.push(score(&ours.grey("indirect"), &reference.grey("indirect"), &reference.grey("se_indirect")).rms);
    }
    Some((Accuracy::read(&Container::open(Path::new(&bake)).expect("a container")).expect("an accuracy"), errors))
}

#[test]
fn certificates_agree_with_another_renderer() {
    let folder = tempfile::tempdir().expect("a folder");
    for (scene, sets) in [
        // Not its bulb, by which two points in a gap of a centimetre, which do not count, weigh more than all others.
        ("scenes/cornell_box/cornell_box.glb", &["cornell_area"]),
        ("scenes/rooms/rooms.glb", &["rooms_room0"]),
    ] {
        let Some((accuracy, errors)) = against(folder.path(), scene, sets) else { return };
        println!("{scene}: certified {:.4}, found {errors:?}", accuracy.rms);
        assert!(accuracy.rms <= 0.05, "{}", accuracy.rms);
        for error in errors {
            assert!(
                error <= 1.3 * accuracy.rms && accuracy.rms <= 1.5 * error,
                "{scene}: certified {}, found {error}",
                accuracy.rms
            );
        }
    }
}
