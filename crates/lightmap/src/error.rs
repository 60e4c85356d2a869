//! Why there is no lightmap.

use radfile::LARGEST_LIGHTMAP;

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// What was found, what was expected, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene file brings no lightmap coordinates.
    #[error("the scene has no second set of texture coordinates (TEXCOORD_1 of glTF); make one with --unwrap")]
    NoCoordinates,
    /// The scene file's second set of texture coordinates is something else, or damaged.
    #[error("the scene's second set of texture coordinates is no lightmap: {what}; make one with --unwrap")]
    Unusable {
        /// What was found and expected.
        what: String,
    },
    /// The size is no number of texels.
    #[error("a lightmap {found} was asked for, expected a number above 0; leave it out for the usual size")]
    Size {
        /// What was asked for.
        found: String,
    },
    /// No ring of texels around charts is left to filters.
    #[error("charts {found} texels apart were asked for, expected 1 to {most}, so that bilinear filters mix no charts")]
    Padding {
        /// What was asked for.
        found: u32,
        /// Largest padding.
        most: u32,
    },
    /// More texels than a texture can have.
    #[error(
        "the lightmap would have {width} × {height} texels, a texture holds {LARGEST_LIGHTMAP} × {LARGEST_LIGHTMAP}; ask for fewer"
    )]
    TooLarge {
        /// Texels in a row.
        width: u64,
        /// Rows.
        height: u64,
    },
    /// The charts do not fit at any density.
    #[error("{charts} charts do not fit into {width} × {width} texels with {padding} around each; ask for more texels")]
    TooSmall {
        /// Pieces that the mesh falls into.
        charts: u32,
        /// Width of the lightmap.
        width: u32,
        /// Texels around each chart.
        padding: u32,
    },
    /// What the unwrapper says of its input.
    #[error("the mesh cannot be unwrapped: {0}; repair it in the program that made it")]
    Unwrap(#[source] uvunwrap::Error),
}
