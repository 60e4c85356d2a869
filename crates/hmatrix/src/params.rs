//! What can be chosen.

use radfile::Kernel;

use crate::{Error, Result};

/// How to pack.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// What the matrix is; it says how light comes from it. K of all bounces has the channels of the scene, W of one
    /// bounce has one.
    pub kernel: Kernel,
    /// Error of indirect irradiance that is wanted, colour included: the L2 norm over the area relative to that of
    /// the irradiance, mean over probe lights. 0.01 is 1 %; 0.0005 ..= 0.5.
    pub error: f64,
    /// Most patches of a leaf of the cluster tree, 4 ..= 64.
    pub leaf: usize,
    /// Number of probe lights that steer, and of others that certify, 1 or more.
    pub probes: u32,
    /// Seed of lights and sketches.
    pub seed: u64,
    /// Whether form factors and dense operator stay in the container.
    pub keep_dense: bool,
}

impl Params {
    /// The default with another error.
    pub fn error(error: f64) -> Params {
        Params { error, ..Params::default() }
    }

    pub(crate) fn check(&self) -> Result<()> {
        let refuse = |option, found: String, expected| Err(Error::Option { option, found, expected });
        if !(0.0005..=0.5).contains(&self.error) {
            return refuse("error", self.error.to_string(), "a share from 0.0005 to 0.5 (0.01 is 1 %)");
        }
        if !(4..=64).contains(&self.leaf) {
            return refuse("leaf", self.leaf.to_string(), "4 to 64 patches (24 is usual)");
        }
        if self.probes == 0 {
            return refuse("probes", "0".into(), "1 or more probe lights (20 is usual)");
        }
        Ok(())
    }
}

impl Default for Params {
    fn default() -> Params {
        Params { kernel: Kernel::AllBounces, error: 0.005, leaf: 24, probes: 20, seed: 1, keep_dense: false }
    }
}
