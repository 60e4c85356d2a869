//! `allbounce`: every bounce of light, in one matrix multiply. One subcommand a file.
//!
//! Exit codes: 0 done, 1 input refused, 2 usage, 3 input or output failed.

mod bake;
mod chart;
mod compare;
mod csv_points;
mod diff;
mod dxt_pack;
mod export;
mod files;
mod formfactor;
mod gpu;
mod hmatrix;
mod inspect;
mod memory;
mod numbers;
mod packing;
mod permute;
mod pictures;
mod progress;
mod reference;
mod relight;
mod render;
mod report;
mod runtime;
mod series;
mod session;
mod show;
mod stage;
mod transfer;
mod verify;
mod voxel_simplify;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::session::{Session, SessionArgs};

const EXAMPLES: &str = "\
Examples:
  allbounce bake room.glb -o room.rad --patches 3000
  allbounce relight room.rad --lights evening.json --points points.csv -o irradiance.csv
  allbounce render room.rad --lights evening.json --camera door.json -o evening.png --backend gpu
  allbounce export room.rad --lights evening.json -o evening      # lightmap, vertex colours, table
  allbounce reference room.glb --lights evening.json --points points.csv -o truth.csv --rel-error 1%

evening.json: { \"use_scene_emission\": true, \"lights\": [
  { \"type\": \"point\", \"position\": [2, 1.5, 3], \"intensity\": [10, 9, 7] } ] }
door.json:    { \"origin\": [0, 1.6, 0], \"target\": [2, 1.2, 3], \"up\": [0, 1, 0], \"fov_x_deg\": 70 }
All lights, cameras and columns: docs/guide.md. Exit: 0 done, 1 input refused, 2 usage, 3 I/O.";

/// Multi-bounce global illumination: bake a room once, then move the lights freely.
#[derive(Parser)]
#[command(version, max_term_width = 100, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    session: SessionArgs,
}

#[derive(Subcommand)]
enum Command {
    Bake(bake::Args),
    VoxelSimplify(voxel_simplify::Args),
    Formfactor(stage::Args<formfactor::Options>),
    Series(stage::Args<series::Options>),
    Permute(stage::Args<permute::Options>),
    DxtPack(dxt_pack::Args),
    Hmatrix(stage::Args<hmatrix::Packing>),
    // As part of a bake it has only its other name: there --mode is that of voxel-simplify.
    #[command(mut_arg("transfer", |arg| arg.visible_alias("mode")))]
    Transfer(stage::Args<transfer::Options>),
    Relight(relight::Args),
    Render(render::Args),
    Export(export::Args),
    Reference(reference::Args),
    Chart(chart::Args),
    Show(show::Args),
    Compare(compare::Args),
    Inspect(inspect::Args),
    Verify(verify::Args),
    Diff(diff::Args),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let outcome = Session::new(&cli.session).and_then(|session| run(&cli.command, &session));
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", chain(&error));
            ExitCode::from(if error.chain().any(|cause| cause.is::<std::io::Error>()) { 3 } else { 1 })
        }
    }
}

fn run(command: &Command, session: &Session) -> anyhow::Result<()> {
    match command {
        Command::Bake(args) => bake::run(args, session),
        Command::VoxelSimplify(args) => voxel_simplify::run(args, session),
        Command::Formfactor(args) => stage::run(args, session),
        Command::Series(args) => stage::run(args, session),
        Command::Permute(args) => stage::run(args, session),
        Command::DxtPack(args) => dxt_pack::run(args, session),
        Command::Hmatrix(args) => stage::run(args, session),
        Command::Transfer(args) => stage::run(args, session),
        Command::Relight(args) => relight::run(args, session),
        Command::Render(args) => render::run(args, session),
        Command::Export(args) => export::run(args, session),
        Command::Reference(args) => reference::run(args, session),
        Command::Chart(args) => chart::run(args, session),
        Command::Show(args) => show::run(args, session),
        Command::Compare(args) => compare::run(args, session),
        Command::Inspect(args) => inspect::run(args, session),
        Command::Verify(args) => verify::run(args, session),
        Command::Diff(args) => diff::run(args, session),
    }
}

/// The causes of an error in one line; what another of them quotes is not repeated.
fn chain(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if cause.starts_with(&text) {
            text = cause;
        } else if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}
