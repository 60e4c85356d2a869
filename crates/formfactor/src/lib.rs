//! Patches to form factors by a Sobol cosine gather.
//!
//! F_ij, the part of the flux leaving patch i that reaches patch j, is measured by rays: they start
//! uniformly on the patch's real pieces, leave with density cos θ / π, and are counted where they
//! land. Two estimates of every pair are joined to one exchange area, and the matrix is scaled so
//! that each row sums to the share of its rays that met a patch. What comes out is reciprocal and
//! has no row above 1, so the bounce series of the next stage converges for every reflectance below 1.
//!
//! - `gather.rs`: the rays of one patch; `halves.rs`: those of all, counted in two halves.
//! - `reciprocity.rs`: two measurements of a pair become one.
//! - `closure.rs`: the scaling of rows; `closed.rs`: from counts to F, held to its limits.
//! - `probes.rs`: what an error of F does to light; `allocation.rs`: which patches need more rays.
//! - `assemble.rs`: all in order, and the figures of the report.
//!
//! Start at [`form_factors`]. Equations: docs/theory.md (2.1), (2.2), (2.3) and §9; method: docs/design.md §6.2.

mod allocation;
mod assemble;
mod closed;
mod closure;
mod error;
mod gather;
mod halves;
mod probes;
mod reciprocity;
mod report;
mod stage;

pub use allocation::PILOT;
pub use assemble::{MARGIN, form_factors, memory_needed};
pub use error::{Error, Result};
pub use report::{PairLimit, Report, RowError};
pub use stage::run;

/// How form factors are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    /// How many rays are spent.
    pub budget: Budget,
    /// Scrambles the rays; the same seed gives the same bytes.
    pub seed: u32,
}

/// How many rays are spent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// So many at every patch, at least 2; powers of two are stratified best.
    Rays(u32),
    /// As many as it takes, where they are worth most.
    Error {
        /// Error of final light that is wanted, under any lamps: 0.01 is 1 %. The probes' own,
        /// `Report::irradiance_error`, is brought to two thirds of it.
        target: f64,
        /// Rays that no patch passes, at least [`PILOT`].
        max_rays: u32,
    },
}

impl Params {
    /// The same number of rays at every patch.
    pub fn rays(rays: u32, seed: u32) -> Params {
        Params { budget: Budget::Rays(rays), seed }
    }
}

impl Default for Params {
    fn default() -> Params {
        Params::rays(4096, 1)
    }
}
