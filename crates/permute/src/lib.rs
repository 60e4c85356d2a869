//! One order for the rows and columns of the operator.
//!
//! Patches that see alike should be neighbours: then neighbouring values of the operator are alike,
//! blocks of a texture compress better, and pairs of patches that exchange nothing gather in tiles of
//! zeros. Rows and columns are reordered together, so the operator stays symmetric and one table says
//! it all ([`radfile::Permutation`], `new_to_old`).
//!
//! Source of the idea and of [`Order::Greedy`]: A. Shcherbakov, V. Frolov, Matrix transformations for
//! efficient implementation of the radiosity algorithm on GPUs, Light & Engineering 27(2), 2019.
//!
//! Start at [`order`]; [`run`] is the stage between two containers.

mod curve;
mod direction;
mod error;
mod greedy;
mod neighbours;
mod order;
mod report;
mod stage;

pub use error::Error;
pub use neighbours::{random_order, zero_tiles};
pub use order::{Order, Params, order};
pub use report::{NeighbourDifference, Report, ZeroTiles};
pub use stage::{memory_needed, run};
