//! What can be wrong with a `.rad` file: found, expected, where, what next.

use std::path::PathBuf;

/// Result of everything that reads or writes a container.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a container was refused. Rules are those of `formats/rad.md`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system could not open, read, write or rename the file.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The first bytes are not the identifier.
    #[error(
        "this is no Allbounce container: it starts with {found}, expected the identifier 8D 52 41 44 0D 0A 1A 0A{hint}"
    )]
    Identifier {
        /// The first bytes, in hexadecimal.
        found: String,
        /// What the file seems to be, if that can be told.
        hint: String,
    },
    /// The file ends before its own header says so, or goes on after it.
    #[error(
        "the file holds {have} bytes, its header says {need}: it was truncated or joined with something else; make it again"
    )]
    FileLength {
        /// Length that the header states.
        need: u64,
        /// Length of the file.
        have: u64,
    },
    /// A file of another major version.
    #[error("container version {major}.{minor}, this program reads {}.x; use the release that made the file", crate::VERSION.0)]
    Version {
        /// Major version found.
        major: u16,
        /// Minor version found.
        minor: u16,
    },
    /// Header or table break a rule of the format.
    #[error("{what} (formats/rad.md {rule}); make the file again")]
    Layout {
        /// Found and expected.
        what: String,
        /// Section of the specification.
        rule: &'static str,
    },
    /// Bytes do not have the checksum that was written with them.
    #[error("{what}: checksum {found:08x}, expected {expected:08x}: the file is damaged; make it again")]
    Checksum {
        /// Which part of the file.
        what: String,
        /// Checksum of the bytes.
        found: u32,
        /// Checksum stored in the file.
        expected: u32,
    },
    /// A section that must be understood is not known to this version.
    #[error(
        "section {name} must be understood to use this file, but this version does not know it; use a newer allbounce"
    )]
    UnknownRequired {
        /// Name of the section.
        name: String,
    },
    /// A section that is needed is not there.
    #[error("section {name} is missing; it is written by `allbounce {stage}`")]
    Missing {
        /// Name of the section.
        name: String,
        /// Stage that writes it.
        stage: &'static str,
    },
    /// A section has another element type or shape than its record wants.
    #[error("section {name} holds {found}, expected {expected}")]
    Shape {
        /// Name of the section.
        name: String,
        /// Element type and shape in the file.
        found: String,
        /// What the record wants.
        expected: String,
    },
    /// The numbers of a record break one of its rules.
    #[error("{record}: {what}")]
    Invariant {
        /// Name of the record.
        record: &'static str,
        /// Which rule, and the first offender.
        what: String,
    },
    /// A metadata section cannot be decoded.
    #[error("metadata of {name} cannot be decoded: {what}")]
    Meta {
        /// Name of the section.
        name: String,
        /// What the decoder said.
        what: String,
    },
}

impl Error {
    /// A broken invariant of `record`.
    pub fn invariant(record: &'static str, what: impl Into<String>) -> Error {
        Error::Invariant { record, what: what.into() }
    }
}
