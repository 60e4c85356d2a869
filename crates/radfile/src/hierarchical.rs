//! The operator as a hierarchical matrix: a stream of quantised blocks and what they are worth.
//!
//! This record knows what the stream is for and checks what can be checked without reading it; the stream itself is
//! read by the crate `hmatrix` and specified in `formats/rad.md` §6.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::{Builder, Container, Error, FLAG_PATCH_ORDER, FLAG_REQUIRED, Record, Result, record::check_patch_count};

/// What a frame does with the matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kernel {
    /// K, the sum of bounces: a frame multiplies once (docs/theory.md (4.3)).
    #[default]
    AllBounces,
    /// W = A^{1/2} F A^{-1/2}, one bounce without any reflectance: a frame solves (I − W ρ) for all of them.
    OneBounce,
}

/// What the packed operator is and what it was measured to be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// Number of patches.
    pub n: u32,
    /// Channels of the matrix, 1 or 3.
    pub channels: u32,
    /// What a frame does with it.
    pub kernel: Kernel,
    /// Highest bounce that a frame has; `None` is all.
    pub bounces: Option<u32>,
    /// Error of indirect irradiance that was asked for; shares, 0.01 is 1 %.
    pub error_wanted: f64,
    /// Probe lights that the errors below were measured with; packing did not see them.
    pub probes: u32,
    /// L2 norm of the error of indirect irradiance relative to that of the irradiance, mean over probes.
    pub l2_mean: f64,
    /// 99th percentile of the error relative to what is seen at the place, mean over probes.
    pub vis99: f64,
}

/// The packed operator.
#[derive(Clone, Debug, PartialEq)]
pub struct HierarchicalOperator<'a> {
    /// What it is and what it is worth.
    pub certificate: Certificate,
    /// The stream, see `formats/rad.md` §6.
    pub blocks: Cow<'a, [u8]>,
}

impl<'a> Record<'a> for HierarchicalOperator<'a> {
    const PREFIX: &'static str = "hmatrix.";

    fn read(c: &'a Container) -> Result<HierarchicalOperator<'a>> {
        const NAME: &str = "hierarchical operator";
        let certificate: Certificate = c.meta("hmatrix.meta")?;
        let k = &certificate;
        let measured = [k.l2_mean, k.vis99].iter().all(|e| e.is_finite() && *e >= 0.0);
        // Frames solve to a part of the error that was asked for.
        if k.n == 0 || !matches!(k.channels, 1 | 3) || !measured || !(1e-6..=1.0).contains(&k.error_wanted) {
            return Err(Error::invariant(NAME, format!("illegal certificate {k:?}")));
        }
        check_patch_count(c, NAME, k.n as usize)?;
        let blocks = c.array_of::<u8>("hmatrix.blocks", &[None])?;
        Ok(HierarchicalOperator { certificate, blocks: blocks.into() })
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        b.meta("hmatrix.meta", FLAG_REQUIRED, &self.certificate);
        b.array("hmatrix.blocks", FLAG_REQUIRED | FLAG_PATCH_ORDER, &[self.blocks.len()], &self.blocks[..]);
    }
}
