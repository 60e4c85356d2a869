//! What the container-to-container stages have in common: open, ask for memory, work, write, report.

use std::path::PathBuf;

use radfile::{Container, Progress, Sink, Step};
use serde::Serialize;

use crate::{files, session::Session};

/// A stage as the command line sees it.
pub trait Stage {
    /// Its name, as a subcommand.
    const NAME: &'static str;
    /// What it reports.
    type Report: Serialize;

    /// The options that shape the result, as they would be typed.
    fn text(&self) -> String;

    /// Bytes that the step will need, and what helps if there are too few.
    fn memory(&self, input: &Container) -> anyhow::Result<(u64, &'static str)>;

    /// Reads `input`, works, and hands the finished container to `sink`.
    fn apply(
        &self,
        input: &Container,
        step: Step,
        progress: &dyn Progress,
        sink: &mut Sink,
    ) -> anyhow::Result<Self::Report>;
}

/// Options of a stage between two containers.
#[derive(clap::Args)]
pub struct Args<O: clap::Args> {
    /// Container to read
    #[arg(value_name = "IN.rad")]
    pub input: PathBuf,
    /// Container to write
    #[arg(short, long, value_name = "OUT.rad")]
    pub output: PathBuf,
    #[command(flatten)]
    pub options: O,
}

/// What a stage prints and writes.
#[derive(Serialize)]
pub struct StageReport<R> {
    pub stage: &'static str,
    pub seconds: f64,
    #[serde(flatten)]
    pub numbers: R,
}

/// Provenance of one stage.
pub fn step(stage: &str, options: String, inputs: &[(&str, &[u8])]) -> Step {
    Step {
        stage: stage.into(),
        version: env!("CARGO_PKG_VERSION").into(),
        options,
        inputs: inputs.iter().map(|(name, bytes)| ((*name).into(), radfile::digest(bytes))).collect(),
    }
}

/// Runs a stage from file to file.
pub fn run<O: clap::Args + Stage>(args: &Args<O>, session: &Session) -> anyhow::Result<()> {
    let input = files::open(&args.input)?;
    let report = apply(&args.options, &input, session, &mut |builder| builder.write_file(&args.output))
        .map_err(|error| error.context(args.input.display().to_string()))?;
    session.finish(&report)
}

/// Runs a stage from a container to a sink, prints its report.
pub fn apply<S: Stage>(
    stage: &S,
    input: &Container,
    session: &Session,
    sink: &mut Sink,
) -> anyhow::Result<StageReport<S::Report>> {
    let start = session.seconds();
    let (need, remedy) = stage.memory(input)?;
    session.ask_memory(S::NAME, need, remedy)?;
    let progress = session.progress();
    let step = step(S::NAME, stage.text(), &[("input", input.as_bytes())]);
    let numbers = stage.apply(input, step, &progress, sink)?;
    drop(progress);
    let report = StageReport { stage: S::NAME, seconds: session.seconds() - start, numbers };
    session.print(S::NAME, &report)?;
    Ok(report)
}

/// Number of patches of a container, without reading them.
pub fn patch_count(input: &Container) -> anyhow::Result<u64> {
    Ok(input.array::<f32>("patches.area", 1)?.1[0])
}
