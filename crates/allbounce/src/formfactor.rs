//! `allbounce formfactor`: patches in, form factors out.

use formfactor::{Budget, Params, Report};
use radfile::{Container, Progress, Sink, Step};

use crate::{
    numbers,
    stage::{Stage, patch_count},
};

/// Measure how much of each patch's light reaches each other patch.
///
/// Reads mesh and patches. Adds form factors F (row = receiver) and the sky that each patch sees.
#[derive(clap::Args)]
pub struct Options {
    /// Rays per patch; with --ff-error the most that a patch gets, 256 or more [default: 4096; 65536]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=1 << 24))]
    rays: Option<u32>,
    /// Send rays where they are worth most until noise changes the indirect light by no more than this, such as 1%
    /// (RMS over patches and lamps, relative to the light)
    #[arg(long, value_name = "E", value_parser = numbers::relative_error)]
    ff_error: Option<f64>,
    /// Same seed, same file, byte for byte
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u32,
}

impl Options {
    /// Rays until their noise changes indirect light by no more than this.
    pub fn of_error(&self, error: f64) -> Options {
        Options { rays: None, ff_error: Some(error), seed: self.seed }
    }

    fn budget(&self) -> Budget {
        match self.ff_error {
            None => Budget::Rays(self.rays.unwrap_or(4096)),
            Some(target) => Budget::Error { target, max_rays: self.rays.unwrap_or(1 << 16).max(formfactor::PILOT) },
        }
    }
}

impl Stage for Options {
    const NAME: &'static str = "formfactor";
    type Report = Report;

    fn text(&self) -> String {
        match self.budget() {
            Budget::Rays(rays) => format!("--rays {rays} --seed {}", self.seed),
            Budget::Error { target, max_rays } => format!("--ff-error {target} --rays {max_rays} --seed {}", self.seed),
        }
    }

    fn memory(&self, input: &Container) -> anyhow::Result<(u64, &'static str)> {
        let need = formfactor::memory_needed(patch_count(input)? as usize, self.budget());
        Ok((need, "use fewer patches (voxel-simplify --patches N)"))
    }

    fn apply(&self, input: &Container, step: Step, p: &dyn Progress, sink: &mut Sink) -> anyhow::Result<Report> {
        Ok(formfactor::run(input, &Params { budget: self.budget(), seed: self.seed }, step, p, sink)?)
    }

    fn warnings(&self, report: &Report) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(target) = report.irradiance_target.filter(|_| !report.target_met) {
            lines.push(format!(
                "noise of the form factors changes indirect light by up to {:.2} %, wanted were {:.2} %; allow more than {} rays \
                 per patch (--rays)",
                100.0 * formfactor::MARGIN * report.irradiance_error,
                100.0 * target,
                report.rays_most
            ));
        }
        if !report.converged {
            lines.push(format!(
                "the scaling of rows did not come to rest in {} steps; row sums are off by up to {:.1e}",
                report.iterations, report.closure_after_max
            ));
        }
        if report.rows_not_met > 0 {
            let worst: Vec<String> =
                report.worst_not_met.iter().map(|r| format!("{} by {:.1e}", r.patch, r.error)).collect();
            lines.push(format!(
                "{} of {} patches do not exchange what their rays measured, the worst are {}; patches that see only \
                 each other share one measured value",
                report.rows_not_met,
                report.patches,
                worst.join(", ")
            ));
        }
        let [i, j] = report.fullest_pair.patches;
        if report.fullest_pair.share > 1.0 + 1e-6 || report.least_factor < 0.0 {
            lines.push(format!(
                "patches {i} and {j} exchange {} times what the smaller can, the least factor is {}: please report this",
                report.fullest_pair.share, report.least_factor
            ));
        }
        lines
    }
}
