//! Why form factors could not be computed.

/// Result of this stage.
pub type Result<T> = std::result::Result<T, Error>;

/// What is wrong: found, expected, what next.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// There is nothing to measure.
    #[error("there are no patches; make them with `allbounce voxel-simplify`")]
    NoPatches,
    /// There are no halves to compare, or none that say anything.
    #[error("rays a patch: {found}, expected at least {least}")]
    TooFewRays {
        /// Rays that were asked for.
        found: u32,
        /// Fewest that are of use.
        least: u32,
    },
    /// The error asked for is no positive number.
    #[error("error of irradiance: {0}, expected a number above 0, such as 0.01")]
    Target(f64),
    /// The matrix does not fit into memory.
    #[error("form factors of {patches} patches need {bytes} bytes of memory, which are not there; use fewer patches")]
    Memory {
        /// Number of patches.
        patches: usize,
        /// Bytes that were asked for; `u64::MAX` where no machine has them.
        bytes: u64,
    },
    /// The container behind the patches is broken.
    #[error(transparent)]
    Container(#[from] radfile::Error),
}
