//! `allbounce permute`: everything that patches index, in a better order.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use permute::Order;
use radfile::{Container, Progress, Sink, Step};

use crate::stage::{Stage, patch_count};

/// Reorder patches, rows and columns so that neighbours in the matrix are alike.
///
/// Reads and rewrites patches, form factors and operator. Adds the order, new to old.
#[derive(clap::Args)]
pub struct Options {
    /// Order of the patches. Facing first, then along a Hilbert curve; along a Hilbert or a Morton curve;
    /// each row next to the most similar one that is left (the paper's); as voxel-simplify made them
    #[arg(long, default_value = Order::NormalHilbert.name(), value_parser = one_of_the_orders())]
    order: Order,
}

fn one_of_the_orders() -> impl TypedValueParser<Value = Order> {
    PossibleValuesParser::new(Order::ALL.map(Order::name)).try_map(|name| name.parse::<Order>())
}

impl Stage for Options {
    const NAME: &'static str = "permute";
    type Report = permute::Report;

    fn text(&self) -> String {
        format!("--order {}", self.order.name())
    }

    fn memory(&self, input: &Container) -> anyhow::Result<(u64, &'static str)> {
        let need = permute::memory_needed(patch_count(input)? as usize, 3);
        Ok((need, "use fewer patches (voxel-simplify --patches N)"))
    }

    fn apply(&self, input: &Container, step: Step, p: &dyn Progress, sink: &mut Sink) -> anyhow::Result<Self::Report> {
        let params = permute::Params { order: self.order };
        Ok(permute::run(input, &params, step, p, sink)?)
    }
}
