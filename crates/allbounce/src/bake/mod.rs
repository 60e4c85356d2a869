//! `allbounce bake`: all stages in one process, from a scene file to one self-contained file.
//!
//! - `chain.rs`: stages from memory to memory. `pilot.rs`: the coarse bake for adaptive patches.
//! - A bake that is asked for an error, a size or a time (`goal.rs`) chooses its own settings: `climb.rs` makes trials
//!   (`rung.rs`) of more and more patches, a `jury.rs` of path-traced points under lights in the air (`lights.rs`) judges
//!   them, `finish.rs` adds receivers and says what came out. `chosen.rs` runs it all.

mod chain;
mod chosen;
mod climb;
mod finish;
mod goal;
mod jury;
mod lights;
mod pilot;
mod rung;

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::ValueEnum;
use serde::Serialize;
use serde_json::Value;

use crate::{
    dxt_pack, files, formfactor, hmatrix, packing::Wanted, permute, series, session::Session, stage, transfer,
    voxel_simplify,
};
use chain::{Log, keep, taken};

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
    #[command(flatten)]
    goal: goal::Goal,
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
    if args.goal.is_set() {
        return chosen::run(args, session);
    }
    let (mut log, mut slot) = (Log::default(), None);
    let pilot = args.adaptive.then(|| pilot::make(&args.scene, &args.voxel_simplify, session)).transpose()?;
    let options = &args.voxel_simplify;
    log.add(&voxel_simplify::apply(&args.scene, options, pilot.as_ref(), session, &mut keep(&mut slot))?)?;
    let mut current = log.link(&args.formfactor, &taken(slot)?, session)?;
    let wanted = args.packing.clone();
    let hierarchical = args.operator == Operator::Hmatrix;
    if !(hierarchical && args.hmatrix.is_one_bounce()) {
        current = log.link(&args.series, &current, session)?;
    }
    current = log.link(&args.permute, &current, session)?;
    if hierarchical {
        let packing = hmatrix::Packing { options: args.hmatrix.clone(), wanted };
        current = log.link(&packing, &current, session)?;
    } else {
        let packing = dxt_pack::Packing { options: args.dxt_pack.clone(), wanted };
        current = log.link(&packing, &current, session)?;
    }
    log.add(&stage::apply(&args.transfer, &current, session, &mut |b| b.write_file(&args.output))?)?;
    let stages = log.into_reports();
    let bytes = std::fs::metadata(&args.output).with_context(|| args.output.display().to_string())?.len();
    session.say(&format!(
        "baked {} in {:.1} s, {}",
        args.output.display(),
        session.seconds(),
        crate::memory::size(bytes)
    ));
    session.finish(&Report { seconds: session.seconds(), bytes, stages })
}
