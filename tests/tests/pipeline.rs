//! The command line from scene file to answers, on the bundled Cornell box.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use allbounce_tests::{
    asset,
    program::{allbounce, answered, program},
    reference::Table,
    root, text,
};
use radfile::{Container, Patches, Record};

/// Stages between the first and the last, for each way to pack the operator.
const HIERARCHICAL: [&str; 5] = ["formfactor", "series", "permute", "hmatrix", "transfer"];
const ONE_BOUNCE: [&str; 4] = ["formfactor", "permute", "hmatrix", "transfer"];
const TEXTURES: [&str; 5] = ["formfactor", "series", "permute", "dxt-pack", "transfer"];

/// Bakes the Cornell box stage by stage; returns the files.
fn chain(folder: &Path, stages: &[&str], of_hmatrix: &[&str]) -> Vec<PathBuf> {
    let mut files = vec![folder.join("voxel-simplify.rad")];
    let cornell = asset("cornell/cornell.obj");
    allbounce(["voxel-simplify", &cornell, "-o", &text(&files[0]), "--patches", "300", "-q"]).done();
    for &stage in stages {
        let (input, output) = (text(files.last().expect("a file")), folder.join(format!("{stage}.rad")));
        let mut args = vec![stage.to_owned(), input, "-o".into(), text(&output), "-q".into()];
        if stage == "formfactor" {
            args.extend(["--rays".into(), "512".into()]);
        }
        if stage == "hmatrix" {
            args.extend(of_hmatrix.iter().map(|s| s.to_string()));
        }
        allbounce(args).done();
        files.push(output);
    }
    files
}

fn bake(folder: &Path, extra: &[&str]) -> PathBuf {
    let output = folder.join(format!("bake{}.rad", extra.join("")));
    let cornell = asset("cornell/cornell.obj");
    let mut args =
        vec!["bake", &cornell, "--patches", "300", "--rays", "512", "-q", "-o", output.to_str().expect("UTF-8")];
    args.extend(extra);
    allbounce(args).done();
    output
}

#[test]
fn a_bake_is_the_chain_of_its_stages_and_the_same_for_any_thread_count() {
    let folder = tempfile::tempdir().expect("a folder");
    let ways: [(&[&str], &[&str], &[&str]); 3] = [
        (&HIERARCHICAL, &[], &[]),
        (&ONE_BOUNCE, &["--kernel", "one-bounce"], &["--kernel", "one-bounce"]),
        (&TEXTURES, &[], &["--operator", "textures"]),
    ];
    for (stages, of_hmatrix, of_bake) in ways {
        let last = std::fs::read(chain(folder.path(), stages, of_hmatrix).pop().expect("a file")).expect("bytes");
        let with = |threads| bake(folder.path(), &[of_bake, &["--threads", threads]].concat());
        let [one, two] = ["1", "2"].map(|threads| std::fs::read(with(threads)).expect("bytes"));
        assert!(one == two, "1 and 2 threads differ: {of_bake:?}");
        assert!(one == last, "bake and chain differ: {of_bake:?}");
    }
}

#[test]
fn inspect_tells_what_a_bake_was_measured_to_be() {
    let shown = allbounce(["inspect", &text(&root().join("tests/compat/1.4/certified.rad"))]).done().stdout;
    let line = "accuracy: 4.7 % of indirect light (asked 6.25 %) at 800 points under 2 lights, worst 6.2 %; \
                discretisation 4.0 %, form factors 2.0 %, solver 0.0 %, packing 1.0 %, vertices 1.6 %\n";
    assert!(shown.contains(line), "{shown}");
}

#[test]
fn a_bake_needs_nothing_else_and_answers_points_vertices_and_pictures() {
    let folder = tempfile::tempdir().expect("a folder");
    let bake = text(&bake(folder.path(), &[]));
    let bake = bake.as_str();
    let container = Container::open(Path::new(bake)).expect("a container");
    assert!(!container.has("series.values") && !container.has("formfactor.values"), "dense matrices are dropped");
    allbounce(["verify", bake]).done();
    let shown = allbounce(["inspect", bake]).done().stdout;
    assert!(shown.contains("hmatrix --operator-error 0.005") && shown.contains("patches.area"), "{shown}");

    let (points, out) = (folder.path().join("p.csv"), folder.path().join("e.csv"));
    std::fs::write(&points, "id,px,py,pz,nx,ny,nz\n7,0.28,0,0.1,0,1,0\n8,0.28,0.5488,0.1,0,-1,0\n").expect("a file");
    let lights = asset("cornell/point.json");
    let relight = |extra: &[&str]| {
        let (points, out) = (text(&points), text(&out));
        let args = ["relight", bake, "--lights", &lights, "--points", &points, "-o", &out, "-q"];
        allbounce(args.iter().copied().chain(extra.iter().copied())).done();
        Table::read(Path::new(&out))
    };
    let all = relight(&[]);
    assert_eq!(all.column("id"), [7.0, 8.0]);
    let (direct, indirect) = (all.grey("direct"), all.grey("indirect"));
    assert!(direct.iter().chain(&indirect).all(|&x| x > 0.01 && x < 100.0), "{direct:?} {indirect:?}");
    let only = relight(&["--direct-only"]);
    assert_eq!((only.grey("direct"), only.grey("indirect")), (direct, vec![0.0; 2]));
    let only = relight(&["--indirect-only"]);
    assert_eq!((only.grey("direct"), only.grey("indirect")), (vec![0.0; 2], indirect));

    allbounce(["relight", bake, "--lights", &lights, "-o", &text(&out), "-q"]).done();
    let vertices = Table::read(&out).grey("indirect");
    assert!(vertices.len() > 100 && vertices.iter().all(|x| x.is_finite() && *x >= 0.0));

    let camera = asset("cornell/camera.json");
    for ending in ["png", "exr"] {
        let picture = text(&folder.path().join(format!("out.{ending}")));
        allbounce([
            "render", bake, "--lights", &lights, "--camera", &camera, "-o", &picture, "--width", "32", "--height",
            "24", "-q",
        ])
        .done();
        assert!(std::fs::metadata(&picture).expect("a picture").len() > 300);
    }
}

#[test]
fn exactly_the_first_bounces_are_summed_where_the_bake_keeps_form_factors() {
    let folder = tempfile::tempdir().expect("a folder");
    let (kept, dropped) = (bake(folder.path(), &["--keep-dense"]), bake(folder.path(), &[]));
    let (points, out) = (folder.path().join("p.csv"), folder.path().join("e.csv"));
    std::fs::write(&points, "px,py,pz,nx,ny,nz\n0.28,0,0.1,0,1,0\n").expect("a file");
    let relight = |bake: &Path, bounces: &str| {
        let args = [
            "relight",
            &text(bake),
            "--lights",
            &asset("cornell/point.json"),
            "--points",
            &text(&points),
            "-o",
            &text(&out),
            "-q",
        ];
        let args: Vec<String> =
            args.iter().map(|s| s.to_string()).chain(["--bounces".into(), bounces.into()]).collect();
        allbounce(args)
    };
    let of = |bounces: &str| {
        relight(&kept, bounces).done();
        Table::read(&out).grey("indirect")[0]
    };
    let (one, two, many) = (of("1"), of("2"), of("60"));
    assert!(one < two && two < many, "{one} {two} {many}");
    let all = allbounce([
        "relight",
        &text(&kept),
        "--lights",
        &asset("cornell/point.json"),
        "--points",
        &text(&points),
        "-o",
        &text(&out),
        "-q",
    ]);
    all.done();
    let all = Table::read(&out).grey("indirect")[0];
    assert!((many / all - 1.0).abs() < 0.03, "60 bounces give {many}, all of them through the packed operator {all}");
    relight(&dropped, "2").refused(&["--bounces", "--keep-dense"]);
}

/// The pilot of a scene, and patches made by it: no more than were asked for, the same for any number of threads, and
/// not by a pilot of another scene.
#[test]
fn adaptive_patches_stay_within_their_number_and_belong_to_their_pilot() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| text(&folder.path().join(name));
    let (cornell, pilot) = (asset("cornell/cornell.obj"), file("pilot.rad"));
    allbounce(["voxel-simplify", &cornell, "-o", &file("1.rad"), "--patches", "150", "-q"]).done();
    allbounce(["formfactor", &file("1.rad"), "-o", &file("2.rad"), "--rays", "256", "-q"]).done();
    allbounce(["series", &file("2.rad"), "-o", &pilot, "-q"]).done();
    let made = |scene: &str, threads: &str| {
        let out = file(&format!("adaptive{threads}.rad"));
        let args = ["voxel-simplify", scene, "--adaptive", &pilot, "-o", &out, "--patches", "300", "-q"];
        (answered(Command::new(program()).args(args).env("RAYON_NUM_THREADS", threads)), out)
    };
    let [one, two] = ["1", "2"].map(|threads| {
        let (run, out) = made(&cornell, threads);
        run.done();
        out
    });
    let [a, b] = [&one, &two].map(|path| std::fs::read(path).expect("bytes"));
    assert!(a == b, "1 and 2 threads differ");
    let container = Container::open(Path::new(&one)).expect("a container");
    let patches = Patches::read(&container).expect("patches").len();
    assert!((200..=300).contains(&patches), "{patches} patches of 300");
    made(&asset("apartment/apartment.obj"), "3").0.refused(&["the pilot was made of another mesh"]);
    assert!(!folder.path().join("adaptive3.rad").exists(), "nothing is left behind");

    let baked = bake(folder.path(), &["--adaptive"]);
    let container = Container::open(&baked).expect("a container");
    let patches = Patches::read(&container).expect("patches").len();
    assert!((200..=300).contains(&patches), "{patches} patches of 300");
    let again = std::fs::read(&baked).expect("bytes");
    assert!(std::fs::read(bake(folder.path(), &["--adaptive", "--threads", "1"])).expect("bytes") == again);
}

#[test]
fn stages_can_be_compared_and_a_difference_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let (a, b) = (bake(folder.path(), &[]), bake(folder.path(), &["--seed", "2"]));
    allbounce(["diff", &text(&a), &text(&a)]).done();
    allbounce(["diff", &text(&a), &text(&b)]).refused(&[&text(&a), &text(&b), "differ beyond the tolerance"]);
}

#[test]
fn exit_codes_tell_refusal_usage_and_io_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = text(&folder.path().join("out.rad"));
    assert_eq!(allbounce(["bake"]).code, Some(2));
    assert_eq!(allbounce(["bake", &asset("cornell/cornell.obj"), "-o", &out, "--voxel", "-1"]).code, Some(2));
    assert_eq!(allbounce(["bake", "/nowhere/room.obj", "-o", &out]).code, Some(3));
    assert_eq!(allbounce(["formfactor", "/nowhere/x.rad", "-o", &out]).code, Some(3));
    assert_eq!(
        allbounce(["voxel-simplify", &asset("cornell/cornell.obj"), "-o", "/nowhere/out.rad", "-q"]).code,
        Some(3)
    );
    allbounce(["bake", &asset("cornell/cornell.mtl"), "-o", &out]).refused(&["cornell.mtl", ".obj"]);
    allbounce(["bake", &asset("cornell/cornell.obj"), "-o", &out, "--memory-limit", "1MiB", "-q"])
        .refused(&["MiB", "--patches"]);
    assert!(std::fs::read_dir(folder.path()).expect("a folder").next().is_none(), "nothing is left behind");
}

#[test]
fn options_of_a_bake_that_clash_are_refused_before_anything_is_computed() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = text(&folder.path().join("out.rad"));
    let clashes: [(&[&str], [&str; 2]); 3] = [
        (&["--kernel", "one-bounce", "--bounces", "3"], ["--kernel", "--bounces"]),
        (&["--kernel", "one-bounce", "--operator", "textures"], ["--kernel", "--operator"]),
        (&["--format", "paper"], ["--format", "--operator textures"]),
    ];
    for (options, named) in clashes {
        // Too little memory for any stage: a bake that started would say that instead.
        let args = ["bake", &asset("cornell/cornell.obj"), "-o", &out, "--memory-limit", "1KiB", "-q"];
        allbounce(args.iter().chain(options)).refused(&named);
    }
    assert!(std::fs::read_dir(folder.path()).expect("a folder").next().is_none(), "nothing is left behind");
}

#[test]
fn make_bake_reruns_only_what_depends_on_a_change() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = text(folder.path());
    program(); // so that make finds it built
    let make = |extra: &str| {
        let scene = format!("SCENE={}", asset("cornell/cornell.obj"));
        let mut command = Command::new("make");
        command.args([
            "bake",
            &scene,
            &format!("BAKE_DIR={dir}"),
            "VOXEL_SIMPLIFY=--patches 200",
            "FORMFACTOR=--rays 64",
            extra,
        ]);
        let output = command.current_dir(root()).env_remove("MAKEFLAGS").output().expect("make starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        ["voxel-simplify", "formfactor", "series", "permute", "hmatrix", "dxt-pack", "transfer"]
            .iter()
            .filter(|s| said.contains(&format!("allbounce {s} ")))
            .map(|s| s.to_string())
            .collect::<Vec<_>>()
    };
    assert_eq!(make("PERMUTE=").len(), 6);
    assert_eq!(make("PERMUTE="), Vec::<String>::new());
    let series = std::fs::File::options().append(true).open(folder.path().join("3-series.rad")).expect("the file");
    series.set_modified(std::time::SystemTime::now()).expect("touched");
    assert_eq!(make("PERMUTE="), ["permute", "hmatrix", "transfer"]);
    assert_eq!(make("PERMUTE=--order morton"), ["permute", "hmatrix", "transfer"]);
    assert_eq!(make("PERMUTE=--order morton"), Vec::<String>::new());
    assert_eq!(make("OPERATOR=dxt-pack"), ["permute", "dxt-pack", "transfer"]);
    assert_eq!(make("OPERATOR=hmatrix"), ["hmatrix", "transfer"], "another operator is another bake");
}
