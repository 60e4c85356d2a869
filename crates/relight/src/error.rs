//! Why a bake cannot be relit.

/// Result of what needs parts of a bake to fit together.
pub type Result<T> = std::result::Result<T, Error>;

/// Found, expected, where, what next.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Two parts of the bake count the patches differently.
    #[error("{part} is for {found} patches, the bake has {expected}; bake the scene again")]
    PatchCount {
        /// Which part.
        part: &'static str,
        /// Its number of patches.
        found: usize,
        /// Number of patches.
        expected: usize,
    },
    /// Packed rows of another bake.
    #[error(
        "the packed rows are of {} receivers and {} senders, the bake has {} and {}; run transfer again",
        found[0], found[1], expected[0], expected[1]
    )]
    Rows {
        /// Receivers and senders of the rows.
        found: [usize; 2],
        /// Those of the bake.
        expected: [usize; 2],
    },
    /// A section that is missing or broken.
    #[error(transparent)]
    Container(#[from] radfile::Error),
    /// Hierarchical blocks that are broken.
    #[error(transparent)]
    Hierarchical(#[from] hmatrix::Error),
    /// A texture that cannot be decoded.
    #[error(transparent)]
    Scene(#[from] scene::Error),
}
