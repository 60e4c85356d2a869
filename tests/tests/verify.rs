//! `allbounce verify` tells sound containers from ones whose numbers were altered.

use std::{
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use allbounce_tests::{
    asset,
    mesh_text::{MeshText, Paint},
    program::{Run, allbounce, program},
    shapes::inside_of_box,
    text,
    workbench::Workbench,
};
use radfile::{Builder, Container, FLAG_PATCH_ORDER, FLAG_REQUIRED};

fn bake(folder: &Path, name: &str, extra: &[&str]) -> PathBuf {
    let (output, scene) = (folder.join(name), asset("cornell/cornell.obj"));
    let file = text(&output);
    let args = ["bake", &scene, "-o", &file, "--patches", "200", "--rays", "256", "-q"];
    allbounce(args.iter().chain(extra)).done();
    output
}

fn verify(file: &Path) -> Run {
    allbounce(["verify", &text(file)])
}

/// A copy of the container in which one array of f32 was altered.
fn altered(file: &Path, section: &str, alter: impl FnOnce(&mut [f32])) -> PathBuf {
    let container = Container::open(file).expect("a container");
    let found = container.section(section).expect("the section").clone();
    let shape: Vec<usize> = found.shape.iter().map(|&e| e as usize).collect();
    let mut values = container.array::<f32>(section, shape.len()).expect("numbers").0.to_vec();
    alter(&mut values);
    let mut builder = Builder::from_input(&container, |_| true);
    builder.array(section, found.flags, &shape, values);
    written(&builder, file)
}

fn written(builder: &Builder, beside: &Path) -> PathBuf {
    let path = beside.with_file_name("altered.rad");
    builder.write_file(&path).expect("a file");
    path
}

/// Lines with a verdict, from the name of the identity on.
fn verdicts<'a>(run: &'a Run, verdict: &str) -> Vec<&'a str> {
    let lines = run.stdout.lines().filter_map(|line| line.strip_prefix(verdict));
    lines.map(|line| line.split_once(") ").expect("the number of an equation").1.trim_start()).collect()
}

/// Asserts that exactly the identities that start so fail, and that the program says so.
#[track_caller]
fn fails(file: &Path, expected: &[&str]) {
    let run = verify(file);
    let failed = verdicts(&run, "FAILS");
    assert_eq!(failed.len(), expected.len(), "{run:?}");
    for (line, start) in failed.iter().zip(expected) {
        assert!(line.starts_with(start), "{line}");
    }
    run.refused(&["altered.rad", "identities do not hold"]);
}

#[test]
fn altered_form_factors_operators_textures_and_weights_are_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let sound = bake(folder.path(), "sound.rad", &["--keep-dense", "--transfer", "interpolate"]);
    let copy = altered(&sound, "series.values", |_| {});
    assert_eq!(verdicts(&verify(&copy).done(), "holds").len(), 11, "a copy is as sound as the bake");

    let n = Container::open(&sound).expect("a container").array::<f32>("patches.area", 1).expect("areas").0.len();
    let pair = |values: &[f32]| (0..n * n).find(|at| at / n != at % n && values[*at] > 1e-3).expect("two that meet");

    let one_way = altered(&sound, "series.values", |k| k[pair(k)] *= 1.0001);
    fails(&one_way, &["the operator is symmetric"]);
    let brighter = altered(&sound, "series.values", |k| k.iter_mut().for_each(|k| *k *= 1.001));
    fails(&brighter, &["furnace identity of the dense operator"]);
    let darker = altered(&sound, "series.values", |k| k.fill(0.0));
    fails(&darker, &["all bounces are at least one bounce", "furnace identity of the dense operator"]);

    let one_way = altered(&sound, "formfactor.values", |f| f[pair(f)] *= 0.5);
    let after = ["reciprocity", "furnace identity of the dense operator"];
    fails(&one_way, &after[..]);
    let dim = altered(&sound, "formfactor.values", |f| f.iter_mut().for_each(|f| *f *= 0.995));
    fails(&dim, &["rows of F and the sky reach 1", "furnace identity of the dense operator"]);
    let limit = ["an exchange area fits", "rows of F and the sky do not exceed 1", "rows of F and the sky reach 1"];
    let swallowed = altered(&sound, "formfactor.values", |f| {
        let at = pair(f);
        (f[at], f[at % n * n + at / n]) = (1.0, 1.0);
    });
    let found = verdicts(&verify(&swallowed), "FAILS").join("\n");
    assert!(limit.iter().all(|l| found.contains(l)), "{found}");
    let windows = altered(&sound, "formfactor.sky", |sky| sky.fill(0.5));
    fails(&windows, &["rows of F and the sky do not exceed 1", "rows of F and the sky reach 1"]);

    // Within what a reader accepts, so that it is this program that finds it; beyond that the reader does.
    let heavier = altered(&sound, "transfer.weight", |w| w.iter_mut().for_each(|w| *w *= 1.00009));
    verify(&heavier).done();
    let lighter = altered(&sound, "transfer.weight", |w| w.iter_mut().for_each(|w| *w *= 0.9995));
    fails(&lighter, &["transfer weights of a receiver sum to 1"]);
    let halved = altered(&sound, "transfer.weight", |w| w.iter_mut().for_each(|w| *w *= 0.5));
    verify(&halved).refused(&["altered.rad", "the weights of receiver 0 sum to"]);

    let container = Container::open(&sound).expect("a container");
    let stream = container.array::<u8>("hmatrix.blocks", 1).expect("blocks").0;
    let mut builder = Builder::from_input(&container, |_| true);
    builder.array("hmatrix.blocks", FLAG_REQUIRED | FLAG_PATCH_ORDER, &[stream.len()], brighter_stream(stream, n));
    fails(&written(&builder, &sound), &["furnace identity of the packed operator"]);

    let sound = bake(folder.path(), "textures.rad", &["--operator", "textures"]);
    let container = Container::open(&sound).expect("a container");
    let blocks = container.array::<u8>("pack.half_blocks", 2).expect("blocks").0;
    let mut builder = Builder::from_input(&container, |_| true);
    builder.array(
        "pack.half_blocks",
        FLAG_REQUIRED | FLAG_PATCH_ORDER,
        &[blocks.len() / 8, 8],
        vec![0u8; blocks.len()],
    );
    fails(&written(&builder, &sound), &["furnace identity of the packed operator"]);
}

/// What a receiver sees of the scene and of the sky together is not more than all; elements are parts of their patch.
#[test]
fn altered_elements_and_skies_of_gathered_receivers_are_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let sound = bake(folder.path(), "sound.rad", &["--edge", "1m"]);
    verify(&altered(&sound, "transfer.sky", |_| {})).done();
    let open = altered(&sound, "transfer.sky", |sky| sky.iter_mut().for_each(|s| *s = (*s + 0.05).min(1.0)));
    fails(&open, &["form factors of a receiver and its sky"]);
    let large = altered(&sound, "elements.area", |area| area[0] *= 1.1);
    fails(&large, &["areas of elements sum to that of their patch"]);
}

/// The same stream with luma a tenth brighter: its unit stands behind header, order and weights (`formats/rad.md` §6).
fn brighter_stream(stream: &[u8], n: usize) -> Vec<u8> {
    let bits = n.next_power_of_two().ilog2() as usize;
    let at = 11 + (n * bits).div_ceil(8) + (7 * n).div_ceil(8);
    let mut brighter = stream.to_vec();
    let unit = f32::from_le_bytes(stream[at..at + 4].try_into().expect("four bytes"));
    brighter[at..at + 4].copy_from_slice(&(1.1 * unit).to_le_bytes());
    brighter
}

#[test]
fn what_cannot_be_checked_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let two = bake(folder.path(), "two.rad", &["--keep-dense", "--bounces", "2"]);
    let shown = verify(&two).done().stdout;
    for line in [
        "skipped  (7.2)   furnace identity: the operator holds 2 bounces only",
        "skipped  (8.2)   energy balance of one reflectance: the operator holds 2 bounces only",
    ] {
        assert_eq!(shown.lines().filter(|l| *l == line).count(), 2, "dense and packed: {shown}");
    }
    let colourful = verify(&bake(folder.path(), "all.rad", &["--keep-dense"])).done().stdout;
    let line =
        "skipped  (8.2)   energy balance of one reflectance, dense operator: the scene is not known to be closed";
    assert!(colourful.contains(line), "the box is open in front: {colourful}");

    let packed = verify(&bake(folder.path(), "fronts.rad", &["--one-sided"])).done().stdout;
    assert!(
        packed.contains("packed operator, mean over patches (checked from above only: back sides absorb)"),
        "{packed}"
    );
    let dense = verify(&bake(folder.path(), "fronts.rad", &["--one-sided", "--keep-dense"])).done().stdout;
    assert!(!dense.contains("from above") && !dense.contains("reach 1"), "F says what the backs absorb: {dense}");
}

/// A closed room of one reflectance: light that the operator loses is missed in the energy balance, too.
#[test]
fn the_energy_of_a_closed_room_is_counted() {
    let mut mesh = MeshText::default();
    inside_of_box([0.0; 3], [3.0, 2.0, 2.5])
        .iter()
        .for_each(|w| w.add(&mut mesh, Paint::matt("wall", [0.8, 0.5, 0.5])));
    let room = Workbench::new(&mesh);
    room.bake(&["--patches", "100", "--rays", "256", "--one-sided"]);
    let held = verify(&room.baked()).done();
    assert_eq!(held.stdout.matches("(8.2)").count(), 2, "{held:?}");
    assert_eq!(verdicts(&held, "skipped"), Vec::<&str>::new());
    let brighter = altered(&room.baked(), "series.values", |k| k.iter_mut().for_each(|k| *k *= 1.001));
    fails(&brighter, &["furnace identity of the dense operator", "energy balance of one reflectance, dense operator"]);
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let folder = tempfile::tempdir().expect("a folder");
    let bake = bake(folder.path(), "bake.rad", &[]);
    let mut child = Command::new(program())
        .args(["verify", &text(&bake)])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take()); // as `| true` does
    let output = child.wait_with_output().expect("the program ends");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
