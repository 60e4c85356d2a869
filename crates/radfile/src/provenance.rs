//! How a file came to be: one line a stage, no dates, so the same inputs give the same bytes.

use serde::{Deserialize, Serialize};

use crate::{Builder, Container, Error, Result};

/// One stage that worked on the file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Step {
    /// Stage, as the command line names it.
    pub stage: String,
    /// Version of the program.
    pub version: String,
    /// Options that shape the result, as they would be typed.
    pub options: String,
    /// Name and BLAKE3 digest of each input, in the order they were read.
    pub inputs: Vec<(String, String)>,
}

/// Steps from the scene to this file, oldest first.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// The steps.
    pub steps: Vec<Step>,
}

impl Provenance {
    pub(crate) const SECTION: &'static str = "provenance";

    /// Provenance of a container; empty if it has none.
    pub fn read(container: &Container) -> Result<Provenance> {
        match container.meta(Self::SECTION) {
            Err(Error::Missing { .. }) => Ok(Provenance::default()),
            other => other,
        }
    }

    /// Writes the section.
    pub fn write(&self, builder: &mut Builder) {
        builder.meta(Self::SECTION, 0, self);
    }
}

/// BLAKE3 digest in hexadecimal.
pub fn digest(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}
