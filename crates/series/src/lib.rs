//! Form factors to the all-bounce operator.
//!
//! One bounce is a gather, H ← F ρ H. All of them together are a matrix that does not depend on the
//! lights; this crate computes it once, as K = A^{-1/2} X A^{-1/2}, where X are Hottel's total
//! exchange areas: what reaches i from j after any number of reflections. Start at [`all_bounces`].
//!
//! - Scaling by areas makes one bounce symmetric: W = A^{1/2} F A^{-1/2} (`one_bounce`).
//! - All bounces are solved, not summed: I − R W R is symmetric positive definite for every physical F
//!   (`cholesky`, `conjugate`), docs/theory.md (5.2), (5.4).
//! - The first k bounces are summed (`truncated`).
//! - The inverse as it was first proposed is there for comparison (`paper_inverse`), and [`solve_raw`] takes
//!   form factors that no scene has, to show where methods fail.
//! - What the result is worth is measured, not assumed: `spectrum`, `quality`.
//!
//! Every method computes in f32 or f64. The only clock of this crate is [`ChannelReport::seconds`].
//!
//! **Why our own blocking over faer.** A file must have the same bytes whatever the number of threads.
//! A parallel matrix product may cut its sums differently for 2 threads than for 16, and sums in floating
//! point depend on where they are cut. So the matrices are cut into tiles by their size alone; every
//! tile is one task, whose sums faer takes on a single thread in an order of its own choosing, and
//! tasks never share a sum. More threads change who computes a tile, never how.

mod cholesky;
mod conjugate;
mod error;
mod methods;
mod one_bounce;
mod paper_inverse;
mod params;
mod quality;
mod report;
mod scalar;
mod solve;
mod spectrum;
mod stage;
mod store;
mod tiles;
mod truncated;

pub use error::Error;
pub use params::{Method, Params, Precision, memory_needed};
pub use report::{ChannelReport, PatchSum, Report};
pub use solve::{all_bounces, solve_raw};
pub use stage::run;
