//! What reordering did, in numbers for people.

use serde::Serialize;

/// The order and its effect.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Name of the order.
    pub order: &'static str,
    /// Patches.
    pub patches: usize,
    /// Patches that have another number now.
    pub moved: usize,
    /// How different neighbours of the operator are; `None` without an operator.
    pub neighbour_difference: Option<NeighbourDifference>,
    /// Tiles of the form factors that are zero; `None` without form factors.
    pub zero_tiles: Option<ZeroTiles>,
    /// Optional sections that follow the order of patches in a way that is not known, and were left out.
    pub dropped: Vec<String>,
}

/// Mean |K_ij − K_i,j+1| and |K_ij − K_i+1,j| over the mean of |K|, all channels together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NeighbourDifference {
    /// In the order that was found.
    pub before: f64,
    /// In the new order.
    pub after: f64,
    /// In a random order, the yardstick of the paper.
    pub random: f64,
}

/// Share of 16 × 16 tiles of the form factors without a single exchange of light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ZeroTiles {
    /// In the order that was found.
    pub before: f64,
    /// In the new order.
    pub after: f64,
}
