//! `allbounce series`: form factors in, the operator of all bounces out.

use radfile::{Container, Progress, Sink, Step};

use crate::stage::{Stage, patch_count};

/// Sum all bounces of light into one symmetric operator.
///
/// Reads patches and form factors. Adds K = A^-1/2 X A^-1/2, one matrix for grey scenes, else one a colour.
#[derive(clap::Args)]
pub struct Options {
    /// Sum only the first k bounces [default: all of them, which costs no more]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=65536))]
    bounces: Option<u32>,
}

impl Options {
    fn params(&self) -> series::Params {
        self.bounces.map_or_else(series::Params::default, series::Params::first_bounces)
    }
}

impl Stage for Options {
    const NAME: &'static str = "series";
    type Report = series::Report;

    fn text(&self) -> String {
        self.bounces.map_or_else(String::new, |k| format!("--bounces {k}"))
    }

    fn memory(&self, input: &Container) -> anyhow::Result<(u64, &'static str)> {
        let need = self.params().memory_needed(patch_count(input)? as usize, 3);
        Ok((need, "use fewer patches (voxel-simplify --patches N)"))
    }

    fn apply(&self, input: &Container, step: Step, p: &dyn Progress, sink: &mut Sink) -> anyhow::Result<Self::Report> {
        Ok(series::run(input, &self.params(), step, p, sink)?)
    }
}
