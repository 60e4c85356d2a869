//! Files that users really feed in, and files that nobody should: every stage refuses them in one
//! sentence or loads them with a report, without panic, hang or half-written output.

use std::{
    collections::BTreeSet,
    ffi::OsString,
    path::{Path, PathBuf},
};

use allbounce_tests::{
    asset,
    program::{Run, allbounce},
    reference::shared,
    text,
};

const READERS: [&str; 6] = ["formfactor", "series", "permute", "hmatrix", "dxt-pack", "transfer"];

/// Neither a panic nor a signal: an exit code that the program chose, and a clean folder after a refusal.
#[track_caller]
fn chosen(run: &Run, output: &Path) {
    assert!(matches!(run.code, Some(0 | 1 | 3)), "{run:?}");
    assert!(!run.stderr.contains("panicked"), "{run:?}");
    assert_eq!(output.exists(), run.code == Some(0), "{run:?}");
}

/// Names of the files in a folder, temporary ones included.
fn names(folder: &Path) -> BTreeSet<OsString> {
    std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").file_name()).collect()
}

fn small_chain(folder: &Path) -> Vec<PathBuf> {
    let mut files = vec![folder.join("patches.rad")];
    allbounce(["voxel-simplify", &asset("cornell/cornell.obj"), "-o", &text(&files[0]), "--patches", "100", "-q"])
        .done();
    for stage in READERS {
        let output = folder.join(format!("{stage}.rad"));
        let keep = if stage == "hmatrix" { &["--keep-dense"][..] } else { &[] };
        let input = text(files.last().expect("a file"));
        allbounce([stage, &input, "-o", &text(&output), "-q"].iter().chain(keep)).done();
        files.push(output);
    }
    files
}

#[test]
fn damaged_and_foreign_containers_are_refused_by_every_stage() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = small_chain(folder.path());
    let bad = folder.path().join("bad.rad");
    let out = folder.path().join("out.rad");
    for (stage, input) in READERS.iter().zip(&files) {
        let bytes = std::fs::read(input).expect("bytes");
        let mut flipped = bytes.clone();
        flipped[bytes.len() / 2] ^= 0x10;
        let cut = bytes[..bytes.len() * 2 / 3].to_vec();
        let foreign = b"void plastic red 0 0 5 .7 .05 .05 0 0\n".to_vec();
        for (content, sentence) in [
            (flipped, "checksum"),
            (cut, "the file holds"),
            (foreign, "this is no Allbounce container"),
            (vec![], "this is no Allbounce container"),
            (bytes[..40].to_vec(), "the file holds"),
        ] {
            std::fs::write(&bad, content).expect("a file");
            let before = names(folder.path());
            let run = allbounce([*stage, &text(&bad), "-o", &text(&out), "-q"]);
            chosen(&run, &out);
            run.refused(&["bad.rad", sentence]);
            assert_eq!(names(folder.path()), before, "{stage} leaves something behind");
        }
    }
    // a sound container from too early in the chain
    for stage in ["series", "hmatrix", "dxt-pack"] {
        let run = allbounce([stage, &text(&files[0]), "-o", &text(&out), "-q"]);
        run.refused(&["is missing; it is written by"]);
    }
    std::fs::write(&bad, b"void plastic red\n").expect("a file");
    allbounce(["inspect", &text(&bad)]).refused(&["Radiance"]);
}

#[test]
fn lights_cameras_and_points_are_refused_in_one_sentence() {
    let folder = tempfile::tempdir().expect("a folder");
    let bake = text(small_chain(folder.path()).last().expect("a file"));
    let file = |name: &str, content: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, content).expect("a file");
        text(&path)
    };
    let out = text(&folder.path().join("e.csv"));
    let lights = |content: &str| allbounce(["relight", &bake, "--lights", &file("l.json", content), "-o", &out, "-q"]);
    lights(r#"{ "lights": [ { "type": "laser", "position": [0,0,0] } ] }"#).refused(&["laser"]);
    lights(r#"{ "lights": [ { "type": "point", "position": [0,0,0], "intensty": [1,1,1] } ] }"#).refused(&["intensty"]);
    lights(r#"{ "lamps": [] }"#).refused(&["lamps"]);
    lights("not json").refused(&["l.json"]);
    lights(r#"{ "lights": [ { "type": "point", "position": [0,0,0], "intensity": [1,-1,1] } ] }"#)
        .refused(&["intensity"]);
    let good = file("good.json", r#"{ "lights": [] }"#);
    allbounce(["relight", &bake, "--lights", &good, "--points", &file("p.csv", "x,y\n1,2\n"), "-o", &out, "-q"])
        .refused(&["px"]);
    let picture = text(&folder.path().join("a.png"));
    let camera = file("c.json", r#"{ "origin": [0,0,0], "target": [0,0,0], "up": [0,1,0], "fov_x_deg": 40 }"#);
    allbounce(["render", &bake, "--lights", &good, "--camera", &camera, "-o", &picture, "-q"]).refused(&["c.json"]);
}

#[test]
fn dirty_scenes_load_with_a_report_or_are_refused() {
    let Some(folder) = shared("scenes/dirty") else { return };
    let out_folder = tempfile::tempdir().expect("a folder");
    let out = out_folder.path().join("out.rad");
    let loads = [
        "warts.obj",
        "CornellBox_utm.obj",
        "instances_uv1_lights.glb",
        "house.glb",
        "house_quantized.glb",
        "vr-gallery.glb",
        "rooms_quantized.glb",
        "simple-instancing.glb",
        "Lights.glb",
        "geometry-camera-light.glb",
    ];
    let refused = [
        ("rooms_meshopt.glb", "EXT_meshopt_compression"),
        ("rooms_draco.glb", "KHR_draco_mesh_compression"),
        ("heart_draco.glb", "KHR_draco_mesh_compression"),
        ("truncated.glb", "truncated"),
        ("lying_length.glb", "length"),
        ("lying_accessor.glb", "accessor"),
        ("node_cycle.glb", "node"),
        ("index_out_of_range.glb", "index"),
        ("empty.obj", "no usable triangle"),
        ("no_faces.obj", "no usable triangle"),
    ];
    let mut seen = 0;
    for entry in std::fs::read_dir(&folder).expect("a folder").flatten() {
        let name = entry.file_name().into_string().expect("UTF-8");
        if !name.ends_with(".obj") && !name.ends_with(".glb") {
            continue;
        }
        seen += 1;
        let run = allbounce(["voxel-simplify", &text(&entry.path()), "-o", &text(&out), "--patches", "400"]);
        chosen(&run, &out);
        if let Some((_, part)) = refused.iter().find(|(n, _)| *n == name) {
            run.refused(&[&name, part]);
        } else {
            assert!(loads.contains(&name.as_str()), "{name} is not in this test's table");
            run.done();
            std::fs::remove_file(&out).expect("an output");
        }
        assert!(names(out_folder.path()).is_empty(), "{name} leaves {:?} behind", names(out_folder.path()));
    }
    assert_eq!(seen, loads.len() + refused.len());
}
