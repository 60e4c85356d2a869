//! `allbounce formfactor`: patches in, form factors out.

use radfile::{Container, Progress, Sink, Step};

use crate::stage::{Stage, patch_count};

/// Measure how much of each patch's light reaches each other patch.
///
/// Reads mesh and patches. Adds form factors F (row = receiver) and the sky that each patch sees.
#[derive(clap::Args)]
pub struct Options {
    /// Rays per patch; the error falls faster than 1/√N up to some thousands
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(16..=1 << 24))]
    rays: u32,
    /// Same seed, same file, byte for byte
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u32,
}

impl Stage for Options {
    const NAME: &'static str = "formfactor";
    type Report = formfactor::Report;

    fn text(&self) -> String {
        format!("--rays {} --seed {}", self.rays, self.seed)
    }

    fn memory(&self, input: &Container) -> anyhow::Result<(u64, &'static str)> {
        let need = formfactor::memory_needed(patch_count(input)? as usize);
        Ok((need, "use fewer patches (voxel-simplify --patches N)"))
    }

    fn apply(&self, input: &Container, step: Step, p: &dyn Progress, sink: &mut Sink) -> anyhow::Result<Self::Report> {
        let params = formfactor::Params { rays: self.rays, seed: self.seed };
        Ok(formfactor::run(input, &params, step, p, sink)?)
    }
}
