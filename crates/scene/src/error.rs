//! Why a scene, a lights file or a camera was refused.

/// Result of everything that reads scene input.
pub type Result<T> = std::result::Result<T, Error>;

/// What is wrong with scene input: found, expected, where, what next.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read.
    #[error("{name}: {source}")]
    Read {
        /// Name as the scene gives it.
        name: String,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file is not what its ending says, or is damaged.
    #[error("{name}: {what}")]
    Malformed {
        /// Name of the file.
        name: String,
        /// Found, expected, where.
        what: String,
    },
    /// The file needs a glTF extension that is not supported.
    #[error("{name}: needs the glTF extension {extension}, which is not supported; {remedy}")]
    Extension {
        /// Name of the file.
        name: String,
        /// The extension.
        extension: String,
        /// What to do.
        remedy: &'static str,
    },
    /// No triangle is left.
    #[error("{name}: no usable triangle ({detail})")]
    Empty {
        /// Name of the file.
        name: String,
        /// What was dropped, if anything.
        detail: String,
    },
    /// A lights or camera file breaks its contract.
    #[error("{what}")]
    Json {
        /// Found, expected, where.
        what: String,
    },
    /// The container behind the scene is broken.
    #[error(transparent)]
    Container(#[from] radfile::Error),
}
