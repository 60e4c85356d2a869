//! Why nothing was reordered.

use crate::Order;

/// Errors of this stage.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The container could not be read or written.
    #[error(transparent)]
    Container(#[from] radfile::Error),
    /// No order of this name.
    #[error("there is no order `{found}`, expected one of {}", names())]
    UnknownOrder {
        /// What was asked for.
        found: String,
    },
    /// The order is made from the operator's rows, and there is no operator.
    #[error(
        "the order `greedy` compares rows of the operator, which is not there; run `allbounce series` first, or choose `normal-hilbert`"
    )]
    NeedsOperator,
    /// The operator is about other patches.
    #[error(
        "an operator of {operator} patches, but there are {patches} patches: it was made for another \
         simplification; run the stages from `allbounce formfactor` on again"
    )]
    Count {
        /// Patches of the operator.
        operator: usize,
        /// Patches in `patches.*`.
        patches: usize,
    },
    /// Something that is made from the final order is already there.
    #[error(
        "section {section} was made for the present order of patches; permute comes before `allbounce {stage}`: give it the container from before that stage"
    )]
    TooLate {
        /// The section.
        section: String,
        /// Stage that made it.
        stage: &'static str,
    },
    /// A section that must not be lost follows the order of patches in a way that is not known.
    #[error(
        "section {section} is marked as required and as following the order of patches, but this version does not know how to reorder it; use a newer allbounce"
    )]
    CannotReorder {
        /// The section.
        section: String,
    },
}

fn names() -> String {
    Order::ALL.map(Order::name).join(", ")
}
