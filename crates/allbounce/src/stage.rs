//! What the container-to-container stages have in common: open, ask for memory, work, write, report.

use std::path::{Path, PathBuf};

use anyhow::Context;
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

    /// What people should not miss in the report, a sentence each.
    fn warnings(&self, _report: &Self::Report) -> Vec<String> {
        vec![]
    }
}

// A doc comment here would stand in every stage's help, before its own.
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
pub fn step(stage: &str, options: String, inputs: Vec<(String, String)>) -> Step {
    Step { stage: stage.into(), version: env!("CARGO_PKG_VERSION").into(), options, inputs }
}

/// Runs a stage from file to file.
pub fn run<O: clap::Args + Stage>(args: &Args<O>, session: &Session) -> anyhow::Result<()> {
    files::check_outputs(&session.outputs(&args.output), &[("its own input", &args.input)])?;
    let input = files::open(&args.input)?;
    let report = apply(&args.options, &input, session, &mut |builder| builder.write_file(&args.output));
    session.finish(&report.map_err(|error| about(&args.input, error))?)
}

/// Puts the input's name before an error, unless it is about another file.
fn about(input: &Path, error: anyhow::Error) -> anyhow::Error {
    match error.chain().any(|cause| matches!(cause.downcast_ref(), Some(radfile::Error::Io { .. }))) {
        true => error,
        false => error.context(input.display().to_string()),
    }
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
    let step = step(S::NAME, stage.text(), vec![("input".into(), radfile::digest(input.as_bytes()))]);
    let numbers = stage.apply(input, step, &progress, sink)?;
    drop(progress);
    let report = StageReport { stage: S::NAME, seconds: session.seconds() - start, numbers };
    session.print(S::NAME, &report)?;
    stage.warnings(&report.numbers).iter().for_each(|line| session.warn(line));
    Ok(report)
}

/// Number of patches of a container, without reading them.
pub fn patch_count(input: &Container) -> anyhow::Result<u64> {
    Ok(input.array::<f32>("patches.area", 1)?.1[0])
}

/// What a stage hands to its sink.
pub fn kept(stage: impl FnOnce(&mut Sink) -> anyhow::Result<()>) -> anyhow::Result<Container> {
    let mut container = None;
    stage(&mut |builder| {
        container = Some(builder.finish()?);
        Ok(())
    })?;
    container.context("a stage ended without handing on its container")
}
