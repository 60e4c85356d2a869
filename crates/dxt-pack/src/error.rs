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
    /// There is nothing to pack.
    #[error("the operator has no patches; nothing can be packed (is the scene empty?)")]
    Empty,
    /// Operator and patches belong to different bakes.
    #[error("the operator has {operator} patches, the patch list {patches}; take both from the same bake")]
    PatchCount {
        /// Patches of the operator.
        operator: usize,
        /// Patches in the list.
        patches: usize,
    },
    /// An entry of the operator is negative or no number.
    #[error("K[{receiver}, {sender}] of channel {channel} is {value}, expected a finite K ≥ 0; solve the series again")]
    Value {
        /// Colour channel.
        channel: usize,
        /// Row.
        receiver: usize,
        /// Column.
        sender: usize,
        /// The entry.
        value: f32,
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
