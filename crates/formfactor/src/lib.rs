//! Patches to form factors by a Sobol cosine gather.
//!
//! F_ij, the part of the flux leaving patch i that reaches patch j, is measured by rays: they start
//! uniformly on the patch's real pieces, leave with density cos θ / π, and are counted where they
//! land. Two estimates of every pair are joined to one exchange area, and the matrix is scaled so
//! that each row sums to the share of its rays that met a patch. What comes out is reciprocal and
//! has no row above 1, so the bounce series of the next stage converges for every reflectance below 1.
//!
//! - `gather.rs`: the rays of one patch.
//! - `reciprocity.rs`: two measurements of a pair become one.
//! - `closure.rs`: the scaling of rows.
//! - `assemble.rs`: the three in order, and the figures of the report.
//!
//! Start at [`form_factors`]. Equations: docs/design.md §2, identity 1; method: docs/design.md §6.2.

mod assemble;
mod closure;
mod error;
mod gather;
mod reciprocity;
mod report;
mod stage;

pub use assemble::{form_factors, memory_needed};
pub use error::{Error, Result};
pub use report::{Report, RowError};
pub use stage::run;

/// How form factors are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Params {
    /// Rays per patch; powers of two are stratified best.
    pub rays: u32,
    /// Scrambles the rays; the same seed gives the same bytes.
    pub seed: u32,
}

impl Default for Params {
    fn default() -> Params {
        Params { rays: 4096, seed: 1 }
    }
}
