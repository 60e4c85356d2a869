//! `allbounce hmatrix`: the operator as hierarchical blocks.

use clap::ValueEnum;
use hmatrix::{Params, Report};
use radfile::{Container, Kernel, Progress, Sink, Step};

use crate::{
    packing::Wanted,
    stage::{Stage, patch_count},
};

/// What is packed.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Packed {
    /// All bounces: one product a frame
    AllBounces,
    /// One bounce: the fewest bytes, no `series` needed, but several products a frame; reflectances stay free
    OneBounce,
}

/// Options of this stage that a bake has, too.
#[derive(Clone, clap::Args)]
pub struct Options {
    /// What is packed
    #[arg(long, value_enum, default_value = "all-bounces")]
    kernel: Packed,
}

/// Pack the operator into hierarchical blocks: low rank or quantised tiles, whichever is cheaper.
///
/// Reads patches and operator, or form factors for one bounce. Adds the packed operator with its measured error; drops
/// the dense matrices unless told to keep them.
#[derive(clap::Args)]
pub struct Packing {
    #[command(flatten)]
    pub options: Options,
    #[command(flatten)]
    pub wanted: Wanted,
}

impl Options {
    /// Whether frames solve for all bounces, so that nobody has to before.
    pub fn is_one_bounce(&self) -> bool {
        self.kernel == Packed::OneBounce
    }
}

impl Packing {
    fn params(&self) -> Params {
        let kernel = if self.options.is_one_bounce() { Kernel::OneBounce } else { Kernel::AllBounces };
        let error = self.wanted.error.unwrap_or(Params::default().error);
        Params { kernel, keep_dense: self.wanted.keep_dense, ..Params::error(error) }
    }
}

impl Stage for Packing {
    const NAME: &'static str = "hmatrix";
    type Report = Report;

    fn text(&self) -> String {
        let kernel = if self.options.is_one_bounce() { " --kernel one-bounce" } else { "" };
        format!("{}{kernel}", self.wanted.text(self.params().error))
    }

    fn memory(&self, input: &Container) -> anyhow::Result<(u64, &'static str)> {
        let n = patch_count(input)?;
        let (channels, matrix) = if self.options.is_one_bounce() { (1, 4 * n * n) } else { (3, 0) };
        let need = hmatrix::memory_needed(n as usize, channels) + matrix;
        Ok((need, "use fewer patches (voxel-simplify --patches N)"))
    }

    fn apply(&self, input: &Container, step: Step, p: &dyn Progress, sink: &mut Sink) -> anyhow::Result<Report> {
        Ok(hmatrix::run(input, &self.params(), step, p, sink)?)
    }

    fn warnings(&self, report: &Report) -> Vec<String> {
        if report.l2_mean <= 1.5 * report.error_wanted {
            return vec![];
        }
        vec![format!(
            "packing changes indirect light by {:.2} %, wanted were {:.2} %; the scene has light that few patches carry: use \
             more of them (voxel-simplify --patches N) or a smaller --operator-error",
            100.0 * report.l2_mean,
            100.0 * report.error_wanted
        )]
    }
}
