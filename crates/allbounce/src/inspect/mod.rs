//! `allbounce inspect`: what a container holds and how it came to be; `plots/`: its operator in pictures.

mod plots;

use std::path::PathBuf;

use anyhow::Context;
use radfile::{
    Accuracy, Container, Gathered, HierarchicalOperator, Lightmap, Mesh, PackedOperator, Patches, Provenance, Record,
    Section, Transfer, Volume, Weights,
};
use serde::Serialize;

use crate::{files, memory, session::Session};
use plots::Plot;

/// Tell what a container holds and how it came to be.
///
/// Prints to standard output. With --plot the operator is drawn: matrix, values, blocks, error, sizes and speeds, as SVG
/// and PNG, and index.md about them. Exit: 0 done, 1 input refused, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    /// Container
    file: PathBuf,
    /// Draw the operator into this folder, as far as the container holds it; the folder is made if it is not there
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report {
    version: String,
    bytes: u64,
    sections: Vec<Row>,
    contents: Vec<String>,
    provenance: Provenance,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    plots: Vec<Plot>,
}

#[derive(Serialize)]
struct Row {
    name: String,
    holds: String,
    bytes: u64,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let container = files::open(&args.file)?;
    let (major, minor) = container.version();
    let row = |s: &Section| Row { name: s.name.clone(), holds: s.describe(), bytes: s.length };
    let mut report = Report {
        version: format!("{major}.{minor}"),
        bytes: container.as_bytes().len() as u64,
        sections: container.sections().iter().map(row).collect(),
        contents: contents(&container).with_context(|| args.file.display().to_string())?,
        provenance: Provenance::read(&container)?,
        plots: Vec::new(),
    };
    files::print(&text(&report))?;
    if let Some(folder) = &args.plot {
        report.plots = plots::draw(&container, &args.file, folder, session)?;
    }
    session.finish(&report)
}

fn text(report: &Report) -> String {
    let count = report.sections.len();
    let size = memory::size(report.bytes);
    let mut text = format!("container {}, {count} sections, {size}, all checks passed\n", report.version);
    for row in &report.sections {
        text += &format!("  {:<26} {:<22} {:>12}\n", row.name, row.holds, memory::size(row.bytes));
    }
    for line in &report.contents {
        text += &format!("{line}\n");
    }
    for (number, step) in report.provenance.steps.iter().enumerate() {
        let inputs: Vec<String> = step.inputs.iter().map(|(name, digest)| format!("{name} {digest:.12}…")).collect();
        let (number, inputs) = (number + 1, inputs.join(", "));
        text += &format!("made by {number}: allbounce {} {} {}  ({inputs})\n", step.version, step.stage, step.options);
    }
    text
}

/// One line a record.
fn contents(c: &Container) -> anyhow::Result<Vec<String>> {
    let mut lines = Vec::new();
    if c.has("mesh.meta") {
        let mesh = Mesh::read(c)?;
        let sides = if mesh.one_sided { "one-sided" } else { "two-sided" };
        lines.push(format!("mesh: {} triangles, {sides}, local origin {:?} m", mesh.triangles.len(), mesh.origin));
    }
    if c.has("patches.area") {
        lines.push(patches(&Patches::read(c)?));
    }
    if PackedOperator::is_in(c) {
        let packed = PackedOperator::read(c)?;
        let p = &packed.packing;
        let bytes = packed.size_in_bytes();
        let per_element = bytes as f64 / f64::from(p.n).powi(2);
        lines.push(format!(
            "packed operator: {} × {0}, {} channel(s), {:?} {:?}, {} outliers, {} ({per_element:.3} bytes per n²)",
            p.n,
            p.channels,
            p.format,
            p.map,
            packed.outlier_column.len(),
            memory::size(bytes as u64)
        ));
    }
    if c.has("hmatrix.meta") {
        let packed = HierarchicalOperator::read(c)?;
        let (k, bytes) = (&packed.certificate, packed.blocks.len());
        lines.push(format!(
            "hierarchical operator: {} × {0}, {} channel(s), {:?}, {} ({:.4} bytes per n²), measured error {:.2} % (wanted {:.2} %), \
             99 % of what is seen within {:.1} %",
            k.n,
            k.channels,
            k.kernel,
            memory::size(bytes as u64),
            bytes as f64 / f64::from(k.n).powi(2),
            100.0 * k.l2_mean,
            100.0 * k.error_wanted,
            100.0 * k.vis99
        ));
    }
    if c.has("transfer.position") {
        let t = Transfer::read(c)?;
        let how = match &t.weights {
            Weights::Interpolated(rows) => format!("{} weights", rows.sender.len()),
            Weights::Gathered(gathered) => gathered_rows(gathered),
        };
        lines.push(format!("transfer: {} receivers, {} fine triangles, {how}", t.receivers(), t.fine.triangle.len()));
    }
    if c.has("lightmap.meta") {
        let map = Lightmap::read(c)?;
        let how = optional_rows(c, Lightmap::PREFIX, map.receivers())?;
        lines.push(format!("lightmap: {} × {} texels, {} receivers, {how}", map.width, map.height, map.receivers()));
    }
    if c.has("volume.meta") {
        let volume = Volume::read(c)?;
        let (how, [x, y, z]) = (optional_rows(c, Volume::PREFIX, volume.receivers())?, volume.count);
        lines.push(format!("irradiance volume: {x} × {y} × {z} cells, {} probes, {how}", volume.probes()));
    }
    if c.has("accuracy.meta") {
        lines.push(accuracy(&Accuracy::read(c)?));
    }
    Ok(lines)
}

fn patches(p: &Patches) -> String {
    let area: f64 = p.area.iter().map(|&a| f64::from(a)).sum();
    let brightest = p.reflectance.as_flattened().iter().fold(0.0f32, |m, &r| m.max(r));
    let flux: f64 = p.emission.iter().zip(&p.area).map(|(e, &a)| f64::from(e.iter().sum::<f32>() / 3.0 * a)).sum();
    format!(
        "patches: {}, {area:.4} m², {} pieces, cells of {:.4} m, largest reflectance {brightest:.3}, emitted flux {flux:.4} W (mean of channels)",
        p.len(),
        p.pieces.len(),
        p.locator.cell_size
    )
}

fn accuracy(a: &Accuracy) -> String {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let asked = a.error_wanted.map_or_else(|| "none asked".into(), |e| format!("asked {} %", (1e6 * e).round() / 1e4));
    let worst = a.lights.iter().fold(0.0f64, |worst, light| worst.max(light.rms));
    let p = &a.parts;
    format!(
        "accuracy: {} of indirect light ({asked}) at {} points under {} lights, worst {}; \
         discretisation {}, form factors {}, solver {}, packing {}, vertices {}",
        percent(a.rms),
        a.points,
        a.lights.len(),
        percent(worst),
        percent(p.discretisation),
        percent(p.form_factors),
        percent(p.solver),
        percent(p.packing),
        percent(p.receivers)
    )
}

fn optional_rows(c: &Container, prefix: &str, receivers: usize) -> radfile::Result<String> {
    Ok(match Gathered::is_in(c, prefix) {
        true => gathered_rows(&Gathered::read(c, prefix, receivers)?),
        false => "its form factors were dropped".into(),
    })
}

fn gathered_rows(g: &Gathered) -> String {
    let k = &g.certificate;
    format!(
        "gathered from {} patches and elements by {} rays each, {} ({:.1} a receiver), light within {:.2} % (asked {:.2} %), \
         99 % of what is seen within {:.1} %",
        k.senders,
        k.rays,
        memory::size(g.stream.len() as u64),
        g.stream.len() as f64 / g.sky.len().max(1) as f64,
        100.0 * k.l2_mean,
        100.0 * k.error_wanted,
        100.0 * k.vis99
    )
}
