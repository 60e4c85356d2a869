//! Why an operator was not packed.

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Why an operator was not packed or exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An option has a value that makes no sense.
    #[error("option {option} is {found}, expected {expected}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// Its value.
        found: String,
        /// What it may be.
        expected: &'static str,
    },
    /// Columns of outliers are 16 bits wide where half is stored.
    #[error("the operator has {patches} patches, half of it is stored of up to 65536; use fewer patches")]
    TooManyPatches {
        /// Patches of the operator.
        patches: usize,
    },
    /// The list of outliers cannot be indexed.
    #[error("{count} outliers, the format indexes up to 4294967295; lower the share of outliers or use fewer patches")]
    TooManyOutliers {
        /// Outliers that would be stored.
        count: u64,
    },
    /// The texture is too large for a DDS file.
    #[error(
        "the texture array has {layers} layers and {bytes} bytes, a DDS file holds 2048 layers and 4294967295 bytes; \
         read the blocks from the .rad file instead"
    )]
    DdsSize {
        /// Layers of the array.
        layers: usize,
        /// Bytes of all layers.
        bytes: usize,
    },
    /// The container lacks something or breaks a rule.
    #[error(transparent)]
    Container(#[from] radfile::Error),
}
