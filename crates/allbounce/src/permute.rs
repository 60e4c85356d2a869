//! `allbounce permute`: everything that patches index, in a better order.

use radfile::{Container, Progress, Sink, Step};

use crate::stage::{Stage, patch_count};

/// Reorder patches, rows and columns so that neighbours in the matrix are alike.
///
/// Reads and rewrites patches, form factors and operator. Adds the order, new to old.
#[derive(clap::Args)]
pub struct Options {
    /// Order of the patches
    #[arg(long, value_enum, default_value = "normal-hilbert")]
    order: OrderName,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum OrderName {
    /// By facing, then along a Hilbert curve
    NormalHilbert,
    /// Along a Hilbert curve
    Hilbert,
    /// Along a Morton curve
    Morton,
    /// The paper's: each row next to the most similar one that is left
    Greedy,
    /// As voxel-simplify made them
    None,
}

impl Options {
    fn order(&self) -> permute::Order {
        match self.order {
            OrderName::NormalHilbert => permute::Order::NormalHilbert,
            OrderName::Hilbert => permute::Order::Hilbert,
            OrderName::Morton => permute::Order::Morton,
            OrderName::Greedy => permute::Order::Greedy,
            OrderName::None => permute::Order::None,
        }
    }
}

impl Stage for Options {
    const NAME: &'static str = "permute";
    type Report = permute::Report;

    fn text(&self) -> String {
        let name =
            clap::ValueEnum::to_possible_value(&self.order).map_or_else(String::new, |v| v.get_name().to_owned());
        format!("--order {name}")
    }

    fn memory(&self, input: &Container) -> anyhow::Result<(u64, &'static str)> {
        let need = permute::memory_needed(patch_count(input)? as usize, 3);
        Ok((need, "use fewer patches (voxel-simplify --patches N)"))
    }

    fn apply(&self, input: &Container, step: Step, p: &dyn Progress, sink: &mut Sink) -> anyhow::Result<Self::Report> {
        let params = permute::Params { order: self.order() };
        Ok(permute::run(input, &params, step, p, sink)?)
    }
}
