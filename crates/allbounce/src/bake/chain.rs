//! Stages one after another in memory, and what they report.

use anyhow::Context;
use radfile::{Builder, Container};
use serde::Serialize;
use serde_json::Value;

use crate::{
    session::Session,
    stage::{self, Stage, StageReport, kept},
};

/// What the stages of one bake reported.
#[derive(Clone, Default)]
pub struct Log {
    /// Name and numbers of each.
    stages: Vec<(&'static str, Value)>,
    warnings: Vec<String>,
}

impl Log {
    pub fn add<R: Serialize>(&mut self, report: &StageReport<R>) -> anyhow::Result<()> {
        self.stages.push((report.stage, serde_json::to_value(report)?));
        Ok(())
    }

    /// Runs a stage on what the one before it handed on.
    pub fn link<S: Stage>(&mut self, stage: &S, input: &Container, session: &Session) -> anyhow::Result<Container> {
        kept(|sink| {
            let report = stage::apply(stage, input, session, sink)?;
            self.warnings.extend(stage.warnings(&report.numbers));
            self.add(&report)
        })
    }

    /// A number of a stage's report, such as `rays_mean` of `formfactor`.
    pub fn number(&self, stage: &str, key: &str) -> anyhow::Result<f64> {
        self.report(stage)?[key].as_f64().with_context(|| format!("the report of {stage} has no number {key}"))
    }

    /// The largest of a number in a list of a stage's report, such as `residual` of every `channel` of `series`.
    pub fn largest(&self, stage: &str, list: &str, key: &str) -> anyhow::Result<f64> {
        let numbers =
            self.report(stage)?[list].as_array().into_iter().flatten().filter_map(|entry| entry[key].as_f64());
        numbers.reduce(f64::max).with_context(|| format!("the report of {stage} has no {list} with a number {key}"))
    }

    fn report(&self, stage: &str) -> anyhow::Result<&Value> {
        let found = self.stages.iter().find(|(name, _)| *name == stage);
        found.map(|(_, numbers)| numbers).with_context(|| format!("the bake has no report of {stage}"))
    }

    /// Prints what a session without tables kept to itself.
    pub fn print(&self, session: &Session) -> anyhow::Result<()> {
        self.stages.iter().try_for_each(|(name, numbers)| session.print(name, numbers))?;
        self.warnings.iter().for_each(|line| session.warn(line));
        Ok(())
    }

    pub fn into_reports(self) -> Vec<Value> {
        self.stages.into_iter().map(|(_, numbers)| numbers).collect()
    }
}

/// A sink that keeps the container in memory.
pub fn keep(slot: &mut Option<Container>) -> impl FnMut(&Builder<'_>) -> radfile::Result<()> {
    move |builder| {
        *slot = Some(builder.finish()?);
        Ok(())
    }
}

/// What a stage handed on.
pub fn taken(slot: Option<Container>) -> anyhow::Result<Container> {
    slot.context("a stage ended without handing on its container")
}
