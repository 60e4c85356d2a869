//! The numbers as CSV and as a page.

use std::fmt::Write;

use super::{
    Report,
    judge::{Entry, LeftOut},
    score::Score,
    side_by_side::how_chosen,
};
use crate::{memory, numbers::percent};

const COLUMNS: [&str; 10] =
    ["method", "settings", "change_ms", "frame_ms", "bytes", "bake_seconds", "rms", "bias", "vis99", "rms_is_bound"];

/// One line an entry.
pub fn csv(report: &Report) -> anyhow::Result<String> {
    let mut out = csv::Writer::from_writer(Vec::new());
    out.write_record(COLUMNS)?;
    for e in &report.entries {
        let Score { rms, bias, vis99 } = e.score;
        let bound = f64::from(u8::from(e.rms_is_bound));
        let numbers = [e.change_ms, e.frame_ms, e.bytes as f64, e.bake_seconds, rms, bias, vis99, bound];
        out.write_record([e.method, &e.settings].map(String::from).into_iter().chain(numbers.map(six_digits)))?;
    }
    Ok(about(report).lines().map(|line| format!("# {line}\n")).collect::<String>()
        + &String::from_utf8(out.into_inner()?)?)
}

/// A page with the table and the pictures.
pub fn markdown(report: &Report) -> String {
    let mut page = format!("# Speed against accuracy: {}\n\n", report.scene);
    page += &about(report);
    page += "\n![Error against time](chart.png)\n\n![Error against memory](memory.png)\n\n";
    if !report.side_by_side.is_empty() {
        page += &side_by_side(report);
    }
    page += "| method | settings | light change | frame | memory | bake | RMS | bias | vis99 |\n|---|---|--:|--:|--:|--:|--:|--:|--:|\n";
    for e in &report.entries {
        page += &line(e);
    }
    page
}

/// The pictures of a camera.
fn side_by_side(report: &Report) -> String {
    let lights = report.lights.first().map_or("", String::as_str);
    format!(
        "![Side by side](side-by-side.png)\n\nIndirect light under {lights} as it is reflected to a camera, each pixel a receiver, all \
         with the exposure of the path-traced picture at the upper left. Below each: method, setting, time of a \
         light change for all pixels, RMS against the traced picture. {}\n\n",
        how_chosen()
    )
}

fn line(e: &Entry) -> String {
    let mut text = format!("| {} | {} | {} ms | {} ms ", e.method, e.settings, short(e.change_ms), short(e.frame_ms));
    let bake = if e.bake_seconds < 0.001 { "–".into() } else { format!("{} s", short(e.bake_seconds)) };
    let kept = if e.bytes == 0 { "–".into() } else { memory::size(e.bytes) };
    let [bias, vis99] = [e.score.bias, e.score.vis99].map(percent);
    writeln!(text, "| {kept} | {bake} | {} | {bias} | {vis99} |", e.rms()).expect("writing to a string");
    text
}

/// What was measured, a sentence a line.
fn about(report: &Report) -> String {
    let Report { scene, lights, receivers, truth_noise, direct_ms, threads, note, left_out, .. } = report;
    let mut text = format!(
        "Indirect irradiance of {receivers} points of {scene} under {}, {threads} threads; the shots of progressive refinement follow each other on one.\n\
         Light change: indirect light of all points after the lights changed, median of several frames; frame: the same and their \
         direct light ({} ms, alike for all).\n\
         Memory: what is kept from one change to the next beside the scene, without what every change makes anew: shadow maps, virtual \
         lights, the light in propagation volumes. Bake: what is done once a scene and set of points.\n\
         RMS: over the mean of the truth; bias: of the mean; vis99: 99th percentile of the error relative to the light there and a tenth of \
         its mean.\n\
         Several lights: times are means, RMS the quadratic mean, bias the one furthest from 0, vis99 the mean.\n\
         The truth is path-traced; its own noise, {} of its mean (RMS), is taken off the RMS, but is in vis99.\n\
         An RMS below half of that noise is not known, for the noise itself is known but to an eighth: it is given as that bound \
         (<; rms_is_bound 1 in the table of numbers) and drawn there.\n",
        lights.join(", "),
        short(*direct_ms),
        percent(*truth_noise)
    );
    for LeftOut { method, settings, why } in left_out {
        text += &format!("Left out: {method}, {settings}; {why}.\n");
    }
    if !note.is_empty() {
        text += &format!("Measured on: {note}.\n");
    }
    text
}

/// Six significant digits, as short as they are.
fn six_digits(value: f64) -> String {
    let short: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    short.to_string()
}

/// Three significant digits for people.
pub fn short(value: f64) -> String {
    let digits = if value > 0.0 { (2.0 - value.log10().floor()).clamp(0.0, 6.0) as usize } else { 0 };
    format!("{value:.digits$}")
}
