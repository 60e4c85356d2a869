//! The path tracer against points that another renderer path-traced, and its subcommand.

#[path = "../../crates/scene/tests/disk/mod.rs"]
mod disk;

use std::path::Path;

use allbounce_tests::{
    asset,
    program::allbounce,
    reference::{Table, shared},
    text,
};
use disk::Disk;
use radfile::Quiet;
use reference::{PathTracer, Sampling, Stop};
use scene::{ImportOptions, LightRig, Rays, Scene, Surfaces};

/// Both renderers raise points off their surfaces, by different gaps: exact values differ by about this part.
const RAISED: f64 = 1e-3;
/// Standard errors of both that a point may be off.
const SIGMAS: f64 = 3.0;

/// One set of points and the scene it was made in.
struct Set {
    name: &'static str,
    scene: &'static str,
    lights: &'static str,
    /// The other renderer read texture rows from the bottom. glTF counts them from the top, so do we; to
    /// compare, the coordinates of our copy of the scene are turned over.
    upside_down: bool,
}

const CORNELL: &str = "cornell_box/cornell_box.glb";
const SETS: [Set; 5] = [
    Set { name: "cornell_area", scene: CORNELL, lights: "cornell_area", upside_down: false },
    Set { name: "cornell_point", scene: CORNELL, lights: "cornell_point", upside_down: false },
    Set { name: "furnace_50", scene: "furnace/furnace_50.glb", lights: "furnace", upside_down: false },
    Set { name: "rooms_room0", scene: "rooms/rooms.glb", lights: "rooms_room0", upside_down: false },
    Set { name: "sponza_points", scene: "sponza/sponza.glb", lights: "sponza_points", upside_down: true },
];

/// How one quantity agrees over a set.
#[derive(Debug)]
#[allow(dead_code, reason = "printed")]
struct Agreement {
    quantity: &'static str,
    points: usize,
    /// Share of points whose grey value lies within [`SIGMAS`] combined standard errors.
    within: f64,
    /// The same share of all channels of all points.
    channels_within: f64,
    /// Mean and RMS, over points and channels, of the difference in combined standard errors, where there are any.
    mean_z: f64,
    rms_z: f64,
    /// Mean of ours over mean of theirs, minus 1.
    bias: f64,
    /// Standard error of that.
    bias_error: f64,
}

fn load(path: &Path, upside_down: bool) -> Scene {
    let (folder, name) = (path.parent().expect("a folder"), path.file_name().expect("a name"));
    let disk = Disk(folder.to_owned());
    let (mut scene, _) = scene::import(&text(name.as_ref()), &disk, ImportOptions::default()).expect("a sound scene");
    if upside_down {
        scene.mesh.uv.iter_mut().for_each(|uv| uv[1] = 1.0 - uv[1]);
    }
    scene
}

/// Evaluates every `stride`-th point of a set with `samples` paths; `None` where the set is absent.
fn compare(set: &Set, stride: usize, samples: u32) -> Option<[Agreement; 3]> {
    let rig = std::fs::read_to_string(shared(&format!("reference/lights/{}.json", set.lights))?).expect("lights");
    let scene = load(&shared(&format!("scenes/{}", set.scene))?, set.upside_down);
    let theirs = Table::read(&shared(&format!("reference/results/{}.csv", set.name))?);
    let chosen = |name: &str| -> Vec<f64> { theirs.column(name).into_iter().step_by(stride).collect() };
    let triples = |names: [&str; 3]| -> Vec<[f64; 3]> {
        let [a, b, c] = names.map(chosen);
        (0..a.len()).map(|i| [a[i], b[i], c[i]]).collect()
    };
    let rgb = |name: &str| triples(["r", "g", "b"].map(|c| format!("{name}_{c}")).each_ref().map(String::as_str));
    let (rays, rig) = (Rays::new(&scene.mesh), LightRig::from_json(&rig).expect("a lights file"));
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials).expect("sound textures");
    let tracer = PathTracer::new(&scene, &surfaces, &rays, &rig);
    let normal: Vec<[f32; 3]> = triples(["nx", "ny", "nz"]).iter().map(|n| n.map(|x| x as f32)).collect();
    let sampling = Sampling { stop: Stop::Samples(samples), seed: 11 };
    let (ours, _) = tracer.points(&triples(["px", "py", "pz"]), &normal, &sampling, &Quiet);
    let of = |quantity, value: fn(&reference::PointEstimate) -> reference::Measured| {
        let ours: Vec<reference::Measured> = ours.iter().map(value).collect();
        agreement(quantity, &ours, &rgb(quantity), &rgb(&format!("se_{quantity}")))
    };
    Some([of("direct", |p| p.direct), of("single", |p| p.single), of("indirect", |p| p.indirect)])
}

fn agreement(
    quantity: &'static str,
    ours: &[reference::Measured],
    theirs: &[[f64; 3]],
    errors: &[[f64; 3]],
) -> Agreement {
    let (mut within, mut channels_within, mut z) = (0, 0, Vec::new());
    let (mut sums, mut variance) = ([0.0; 2], 0.0);
    let grey = |rgb: &[f64; 3]| rgb.iter().sum::<f64>() / 3.0;
    let holds = |off: f64, error: f64, value: f64| off.abs() <= SIGMAS * error + RAISED * value;
    for ((ours, theirs), errors) in ours.iter().zip(theirs).zip(errors) {
        for c in 0..3 {
            let (off, error) = (ours.value[c] - theirs[c], ours.error[c].hypot(errors[c]));
            channels_within += usize::from(holds(off, error, theirs[c]));
            if error > RAISED * theirs[c] {
                z.push(off / error);
            }
        }
        // Channels of a point err together, so their errors add up.
        let (value, error) = (grey(theirs), grey(&ours.error).hypot(grey(errors)));
        within += usize::from(holds(grey(&ours.value) - value, error, value));
        sums = [sums[0] + grey(&ours.value), sums[1] + value];
        variance += error * error;
    }
    let n = z.len().max(1) as f64;
    Agreement {
        quantity,
        points: ours.len(),
        within: within as f64 / ours.len() as f64,
        channels_within: channels_within as f64 / (3 * ours.len()) as f64,
        mean_z: z.iter().sum::<f64>() / n,
        rms_z: (z.iter().map(|z| z * z).sum::<f64>() / n).sqrt(),
        bias: sums[0] / sums[1] - 1.0,
        bias_error: variance.sqrt() / sums[1],
    }
}

fn check(set: &Set, stride: usize, samples: u32) {
    let Some(all) = compare(set, stride, samples) else { return };
    for found in &all {
        println!("{} {found:.4?}", set.name);
    }
    for found in all {
        // One in a hundred, and of fewer points one.
        let missed = found.points as f64 * (1.0 - found.within);
        assert!(missed < 1.5 || found.within >= 0.99, "{}: {found:.4?}", set.name);
        assert!(found.bias.abs() <= SIGMAS * found.bias_error + RAISED, "{}: {found:.4?}", set.name);
    }
}

#[test]
fn cornell_box_with_its_lamp() {
    check(&SETS[0], 4, 4096);
}

#[test]
fn cornell_box_with_a_bulb() {
    check(&SETS[1], 4, 4096);
}

#[test]
fn furnace() {
    check(&SETS[2], 1, 1024);
}

/// Light that comes through three doors is rare and bright: it takes many paths until its errors are normal.
#[test]
fn rooms_in_a_row() {
    check(&SETS[3], 4, 16384);
}

#[test]
fn sponza_with_its_textures_turned_over() {
    check(&SETS[4], 4, 2048);
}

/// By hand: `cargo test --release -p allbounce-tests --test path_tracer -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes"]
fn all_points_of_all_sets() {
    for set in &SETS {
        check(set, 1, 1 << 16);
    }
}

/// Runs `allbounce reference` on the bundled Cornell box with its lamp and reads what it wrote.
fn traced(folder: &Path, points: &str, name: &str, further: &[&str]) -> (Table, String) {
    let (input, out, report) = (folder.join("points.csv"), folder.join(name), folder.join("report.json"));
    std::fs::write(&input, points).expect("a file");
    let (scene, lights) = (asset("cornell/cornell.obj"), asset("cornell/lamp.json"));
    let files = ["--points", &text(&input), "-o", &text(&out), "--report", &text(&report)].map(str::to_owned);
    let head = ["reference", &scene, "--lights", &lights, "--quiet"].map(str::to_owned);
    allbounce(head.into_iter().chain(files).chain(further.iter().map(|s| (*s).to_owned()))).done();
    (Table::read(&out), std::fs::read_to_string(&report).expect("the report"))
}

#[test]
fn the_program_says_how_sure_it_is_and_keeps_its_word() {
    let folder = tempfile::tempdir().expect("a folder");
    let points = "id,px,py,pz,nx,ny,nz\n4,0.45,0,0.1,0,1,0\n9,0.5,0,0.15,0,1,0\n";
    let (table, report) = traced(folder.path(), points, "a.csv", &["--rel-error", "2%", "--threads", "1"]);
    assert_eq!(table.column("id"), [4.0, 9.0], "columns of the points are handed through");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["points_short_of_error"], 0);
    assert_eq!(report["paths"].as_f64(), Some(table.column("samples").iter().sum()));
    for quantity in ["direct", "indirect"] {
        let (value, error) = (table.grey(quantity), table.grey(&format!("se_{quantity}")));
        // The promise is about luminance; grey weighs blue more, which the red box has least of.
        assert!(value.iter().zip(&error).all(|(v, e)| *v > 0.0 && *e <= 0.03 * v), "{quantity} {value:?} ± {error:?}");
    }
    let single = table.grey("single");
    assert!(table.grey("indirect").iter().zip(&single).all(|(all, one)| all > one && *one > 0.0));
    traced(folder.path(), points, "b.csv", &["--rel-error", "2%", "--threads", "2"]);
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).expect("a file");
    assert_eq!(bytes("a.csv"), bytes("b.csv"), "threads change nothing");
    traced(folder.path(), points, "b.csv", &["--rel-error", "2%", "--seed", "2"]);
    assert_ne!(bytes("a.csv"), bytes("b.csv"), "seeds do");
}

#[test]
fn the_program_takes_points_or_a_camera_and_known_pictures_only() {
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, lights, camera) =
        (asset("cornell/cornell.obj"), asset("cornell/lamp.json"), asset("cornell/camera.json"));
    let out = |name: &str| text(&folder.path().join(name));
    let run = |output: &str, further: &[&str]| {
        allbounce(["reference", &scene, "--lights", &lights, "-o", output].iter().chain(further))
    };
    assert_eq!(run(&out("a.csv"), &[]).code, Some(2), "nothing to evaluate");
    assert_eq!(run(&out("a.csv"), &["--points", "p.csv", "--camera", &camera]).code, Some(2), "both");
    for idle in [["--width", "8"], ["--exposure", "2"], ["--max-samples", "99"]] {
        let args = [&["--points", "p.csv"][..], &idle].concat();
        assert_eq!(run(&out("a.csv"), &args).code, Some(2), "{idle:?} would do nothing");
    }
    run(&out("a.jpg"), &["--camera", &camera]).refused(&["a.jpg", "unknown picture format", ".png or .exr"]);
    for name in ["a.png", "a.exr"] {
        run(&out(name), &["--camera", &camera, "--width", "24", "--height", "16", "--samples", "8"]).done();
        assert!(std::fs::metadata(folder.path().join(name)).expect("a picture").len() > 200);
    }
}
