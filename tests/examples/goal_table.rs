//! What `bake --error` chose for each scene, as a table of its reports.
//!
//! `goal_table OUT.md MACHINE COMMIT SCENE-ERROR.json…`

use std::{error::Error, path::Path};

use serde_json::Value;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [output, machine, commit, reports @ ..] = &args[..] else {
        return Err("usage: goal_table OUT.md MACHINE COMMIT REPORT.json…".into());
    };
    let mut text = format!(
        "# What a bake chooses\n\n\
         `allbounce bake SCENE --error E`, measured on {machine}, commit {commit}; made by `make goals`.\n\n\
         Certified: mean over lights of the RMS of indirect irradiance relative to its mean, at points of the surfaces, under lights\n\
         that had no part in any choice, held to path-traced light. Worst: the worst of these lights. Vertices: what\n\
         their light differs by from a last gather of many rays, on top of that or, where they interpolate, a part of it. Frames:\n\
         bytes that a frame reads beside the scene, and the time of the indirect light of all vertices. Bake: everything, trials and truth included.\n\n\
         | scene | asked | patches | rays a patch | packing | receivers | frames | a frame | bake | certified | worst | vertices |\n\
         |---|--:|--:|--:|--:|---|--:|--:|--:|--:|--:|--:|\n"
    );
    for path in reports {
        let report: Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
        let name = Path::new(path).file_stem().and_then(|s| s.to_str()).and_then(|s| s.rsplit_once('-'));
        text += &row(name.ok_or("a report is named SCENE-ERROR.json")?.0, &report)
            .ok_or_else(|| format!("{path}: no report of bake --error"))?;
    }
    Ok(std::fs::write(output, text)?)
}

/// One line; `None` if a number is missing.
fn row(scene: &str, report: &Value) -> Option<String> {
    let stage = |name: &str| report["stages"].as_array()?.iter().find(|s| s["stage"] == name);
    let (accuracy, transfer) = (&report["accuracy"], stage("transfer")?);
    let receivers = match transfer.get("gathered") {
        Some(gathered) => format!("{} gather by {} rays", transfer["receivers"], gathered["rays"]),
        None => format!("{} interpolate", transfer["receivers"]),
    };
    let worst = accuracy["lights"].as_array()?.iter().filter_map(|l| l["rms"].as_f64()).fold(0.0, f64::max);
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    Some(format!(
        "| {scene} | {} | {} {}, {} channel(s) | {:.0} | {} | {receivers} | {:.2} MiB | {:.1} ms | {:.0} s | {} | {} | {} |\n",
        percent(accuracy["error_wanted"].as_f64()?),
        report["patches"],
        report["kind"].as_str()?,
        stage("series")?["channels"],
        stage("formfactor")?["rays_mean"].as_f64()?,
        percent(stage("hmatrix")?["l2_mean"].as_f64()?),
        report["bytes_of_frames"].as_f64()? / f64::from(1 << 20),
        report["ms_a_frame"].as_f64()?,
        report["seconds"].as_f64()?,
        percent(accuracy["rms"].as_f64()?),
        percent(worst),
        percent(accuracy["parts"]["receivers"].as_f64()?),
    ))
}
