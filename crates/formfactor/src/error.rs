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
    /// No rays were asked for.
    #[error("0 rays a patch measure nothing, expected at least 1")]
    NoRays,
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
