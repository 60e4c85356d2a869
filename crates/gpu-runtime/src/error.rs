//! Why the GPU cannot do what was asked: found, expected, what next.

/// Result of everything on the GPU.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a frame was not made. The CPU run time (`--backend cpu`) has none of these limits.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No adapter can do the work.
    #[error(
        "no usable GPU adapter ({found}); install a Vulkan driver (Mesa's lavapipe serves without a GPU), or use --backend cpu"
    )]
    NoAdapter {
        /// What was found, and why it does not serve.
        found: String,
    },
    /// The adapter lacks something that was asked for.
    #[error("{adapter} lacks {feature}; {remedy}")]
    Unsupported {
        /// The adapter.
        adapter: String,
        /// What it lacks.
        feature: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// Something does not fit the adapter's limits.
    #[error("{what} needs {need}, {adapter} allows {limit} ({rule}); {remedy}, or use --backend cpu")]
    TooLarge {
        /// What does not fit.
        what: &'static str,
        /// Size needed, with its unit.
        need: String,
        /// The adapter.
        adapter: String,
        /// Its limit, with its unit.
        limit: String,
        /// Name of the limit in WebGPU.
        rule: &'static str,
        /// What makes it smaller.
        remedy: &'static str,
    },
    /// Inputs do not belong together.
    #[error("{what}")]
    Shape {
        /// Found and expected.
        what: String,
    },
    /// A lamp or camera that cannot be used.
    #[error("{what}")]
    Input {
        /// Found and expected.
        what: String,
    },
    /// The device reported an error or was lost.
    #[error("{adapter} reported an error: {what}; please report it with this text, and use --backend cpu meanwhile")]
    Device {
        /// The adapter.
        adapter: String,
        /// What the device said.
        what: String,
    },
    /// The scene's textures cannot be used.
    #[error(transparent)]
    Scene(#[from] scene::Error),
}
