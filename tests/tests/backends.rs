//! The GPU answers as the CPU does, by way of the command line.

use std::{path::Path, process::Command};

use allbounce_tests::{
    asset,
    program::{Run, allbounce, answered, program},
    reference::{Table, score},
    skipped, text,
};
use serde_json::Value;

/// Bakes once, then asks both processors for every receiver of the bake.
///
/// Blocks, outliers and transfer rows are the same, so indirect light differs only by the direct light of the patches
/// that goes into the product: shadow maps stand for shadow rays, fixed points on the lamp for its closed form.
/// Measured under the bulb and the lamp: means differ by 0.12 % and 0.14 %, single receivers by 0.33 % and 0.40 % RMS.
///
/// Direct light differs at the receivers themselves. Means differ by 0.02 % and 0.22 %, single receivers by 1.0 % and
/// 3.3 % RMS. The worst lie one or two millimetres below the upper edges of the blocks: no ray of the CPU reaches the
/// lamp from there, while the shadow maps let light over the edge. So the lamp is allowed more.
#[test]
fn the_gpu_answers_as_the_cpu_does() {
    if std::env::var("ALLBOUNCE_GPU").as_deref() == Ok("skip") {
        return skipped("ALLBOUNCE_GPU=skip leaves the device tests out");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let bake = text(&folder.path().join("bake.rad"));
    let scene = asset("cornell/cornell.obj");
    allbounce(["bake", &scene, "-o", &bake, "--patches", "600", "--rays", "512", "-q"]).done();
    for (lights, direct_rms) in [("point", 0.03), ("lamp", 0.05)] {
        let lights_file = asset(&format!("cornell/{lights}.json"));
        let [cpu, gpu] = ["cpu", "gpu"].map(|backend| receivers(folder.path(), &bake, &lights_file, backend));
        let of = |name: &str| {
            let truth = cpu.grey(name);
            score(&gpu.grey(name), &truth, &vec![0.0; truth.len()])
        };
        let (direct, indirect) = (of("direct"), of("indirect"));
        println!("{lights}: direct {direct:?}, indirect {indirect:?}");
        assert!(indirect.bias.abs() < 0.005 && indirect.rms < 0.01, "{lights}: indirect {indirect:?}");
        assert!(direct.bias.abs() < 0.01 && direct.rms < direct_rms, "{lights}: direct {direct:?}");
    }
    // The camera sees the lamp edge-on, less than a pixel high at 32 x 32, and brighter than all else.
    for (lights, edge) in [("point", "32"), ("lamp", "128")] {
        let lights_file = asset(&format!("cornell/{lights}.json"));
        let [cpu, gpu] = ["cpu", "gpu"].map(|backend| picture(folder.path(), &bake, &lights_file, backend, edge));
        println!("{lights}: mean radiance {cpu:?} on the CPU, {gpu:?} on the GPU");
        for (cpu, gpu) in cpu.iter().zip(gpu) {
            assert!((gpu / cpu - 1.0).abs() < 0.03, "{lights}: {gpu} on the GPU, {cpu} on the CPU");
        }
    }
}

/// Irradiance at the receivers of the bake.
fn receivers(folder: &Path, bake: &str, lights: &str, backend: &str) -> Table {
    let out = folder.join(format!("{backend}.csv"));
    on_a_device(folder, &["relight", bake, "--lights", lights, "-o", &text(&out), "--backend", backend, "-q"]).done();
    Table::read(&out)
}

/// Mean radiance of a picture.
fn picture(folder: &Path, bake: &str, lights: &str, backend: &str, edge: &str) -> [f64; 3] {
    let (out, report) = (text(&folder.join("out.exr")), folder.join("report.json"));
    let camera = asset("cornell/camera.json");
    let mut args = vec!["render", bake, "--lights", lights, "--camera", &camera, "-o", &out, "--width", edge];
    let report_file = text(&report);
    args.extend(["--height", edge, "--backend", backend, "--report", &report_file, "-q"]);
    on_a_device(folder, &args).done();
    let report: Value = serde_json::from_slice(&std::fs::read(report).expect("a report")).expect("JSON");
    assert_eq!(report["backend"] == "cpu", backend == "cpu", "{report}");
    std::array::from_fn(|c| report["mean_radiance"][c].as_f64().expect("a number"))
}

/// Runs the program where a graphics driver finds the folder that it wants.
fn on_a_device(folder: &Path, args: &[&str]) -> Run {
    let mut command = Command::new(program());
    command.args(args);
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        command.env("XDG_RUNTIME_DIR", folder);
    }
    answered(&mut command)
}
