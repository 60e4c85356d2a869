//! `allbounce bake`: all stages in one process, from a scene file to one self-contained file.

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::ValueEnum;
use radfile::{Builder, Container, Sink};
use serde::Serialize;
use serde_json::Value;

use crate::{
    dxt_pack, files, formfactor, hmatrix,
    packing::Wanted,
    permute, pilot, series,
    session::Session,
    stage::{self, Stage},
    transfer, voxel_simplify,
};

/// Bake a scene: patches, form factors, all bounces, order, packing, transfer.
///
/// The file holds everything that relight and render need. Exit: 0 done, 1 input refused, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    /// Scene: .obj (with .mtl), .gltf or .glb; metres
    scene: PathBuf,
    /// Container to write
    #[arg(short, long, value_name = "BAKE.rad")]
    output: PathBuf,
    /// Small patches where light changes, large ones where it does not, as a coarse bake tells that is made first
    #[arg(long, conflicts_with = "voxel")]
    adaptive: bool,
    #[command(flatten)]
    voxel_simplify: voxel_simplify::Options,
    #[command(flatten)]
    formfactor: formfactor::Options,
    #[command(flatten)]
    series: series::Options,
    #[command(flatten)]
    permute: permute::Options,
    /// How the operator is packed
    #[arg(long, value_enum, default_value = "hmatrix")]
    operator: Operator,
    #[command(flatten)]
    hmatrix: hmatrix::Options,
    #[command(flatten)]
    dxt_pack: dxt_pack::Options,
    #[command(flatten)]
    packing: Wanted,
    #[command(flatten)]
    transfer: transfer::Options,
}

/// The tiers of packed operators.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Operator {
    /// Hierarchical blocks: the fewest bytes and the fastest product
    Hmatrix,
    /// Block-compressed textures, decoded by any graphics card
    Textures,
}

#[derive(Serialize)]
struct Report {
    seconds: f64,
    bytes: u64,
    stages: Vec<Value>,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    files::check_outputs(&session.outputs(&args.output), &[("the scene", &args.scene)])?;
    if args.dxt_pack.format.is_some() && args.operator != Operator::Textures {
        bail!("--format is about textures, but the operator becomes hierarchical blocks; add --operator textures");
    }
    if args.hmatrix.is_one_bounce() && args.operator == Operator::Textures {
        bail!("--kernel one-bounce is about hierarchical blocks; leave out --operator textures");
    }
    if args.hmatrix.is_one_bounce() && args.series.is_cut() {
        bail!(
            "--bounces sums in the bake, but with --kernel one-bounce a frame solves for all bounces; take one of them"
        );
    }
    let mut stages = Vec::new();
    let mut current = None;
    let pilot = args.adaptive.then(|| pilot::make(&args.scene, &args.voxel_simplify, session)).transpose()?;
    let options = &args.voxel_simplify;
    let report = voxel_simplify::apply(&args.scene, options, pilot.as_ref(), session, &mut keep(&mut current))?;
    stages.push(serde_json::to_value(report)?);
    link(&args.formfactor, &mut current, &mut stages, session)?;
    let wanted = args.packing.clone();
    let hierarchical = args.operator == Operator::Hmatrix;
    if !(hierarchical && args.hmatrix.is_one_bounce()) {
        link(&args.series, &mut current, &mut stages, session)?;
    }
    link(&args.permute, &mut current, &mut stages, session)?;
    if hierarchical {
        let packing = hmatrix::Packing { options: args.hmatrix.clone(), wanted };
        link(&packing, &mut current, &mut stages, session)?;
    } else {
        let packing = dxt_pack::Packing { options: args.dxt_pack.clone(), wanted };
        link(&packing, &mut current, &mut stages, session)?;
    }

    let packed = taken(&mut current)?;
    let report = stage::apply(&args.transfer, &packed, session, &mut |b| b.write_file(&args.output))?;
    stages.push(serde_json::to_value(report)?);
    let bytes = std::fs::metadata(&args.output).with_context(|| args.output.display().to_string())?.len();
    session.say(&format!(
        "baked {} in {:.1} s, {}",
        args.output.display(),
        session.seconds(),
        crate::memory::size(bytes)
    ));
    session.finish(&Report { seconds: session.seconds(), bytes, stages })
}

/// A sink that keeps the container in memory for the next stage.
fn keep(slot: &mut Option<Container>) -> impl FnMut(&Builder<'_>) -> radfile::Result<()> {
    move |builder| {
        *slot = Some(builder.finish()?);
        Ok(())
    }
}

fn taken(slot: &mut Option<Container>) -> anyhow::Result<Container> {
    slot.take().context("a stage ended without handing on its container")
}

/// Runs one stage from memory to memory.
fn link<S: Stage>(
    stage: &S,
    current: &mut Option<Container>,
    stages: &mut Vec<Value>,
    session: &Session,
) -> anyhow::Result<()> {
    let input = taken(current)?;
    let mut next = keep(current);
    let sink: &mut Sink = &mut next;
    stages.push(serde_json::to_value(stage::apply(stage, &input, session, sink)?)?);
    Ok(())
}
