//! The all-bounce operator K = A^{-1/2} X A^{-1/2}, dense.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::{Builder, Container, Error, FLAG_PATCH_ORDER, FLAG_REQUIRED, Record, Result, record::check_patch_count};

/// Symmetric operator of `n` patches for one channel (grey scene) or three.
///
/// The frame is H_ind = A^{-1/2} K A^{1/2} (ρ H⁰ + M), per channel (docs/theory.md (4.3)).
#[derive(Clone, Debug, PartialEq)]
pub struct Operator<'a> {
    /// Number of patches.
    pub n: usize,
    /// 1 or 3.
    pub channels: usize,
    /// Highest bounce that is in the sum; `None` is all of them.
    pub bounces: Option<u32>,
    /// `channels` × `n` × `n`, row-major, row = receiver, column = sender, dimensionless.
    pub values: Cow<'a, [f32]>,
}

#[derive(Serialize, Deserialize)]
struct Meta {
    bounces: Option<u32>,
}

impl Operator<'_> {
    /// The matrix of one colour channel (0 red, 1 green, 2 blue); grey scenes have one for all.
    pub fn channel(&self, colour: usize) -> &[f32] {
        let size = self.n * self.n;
        &self.values[colour.min(self.channels - 1) * size..][..size]
    }
}

impl<'a> Record<'a> for Operator<'a> {
    const PREFIX: &'static str = "series.";

    fn read(c: &'a Container) -> Result<Operator<'a>> {
        let meta: Meta = c.meta("series.meta")?;
        let (values, shape) = c.array::<f32>("series.values", 3)?;
        if shape[1] != shape[2] || !matches!(shape[0], 1 | 3) {
            return Err(Error::invariant("operator", format!("shape {shape:?}, expected [1 or 3, n, n]")));
        }
        // With 1 or 3 in front, n² elements are in the file, so n is no larger than a length in memory.
        let (channels, n) = (shape[0] as usize, shape[1] as usize);
        check_patch_count(c, "operator", n)?;
        if let Some(at) = values.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
            let (channel, i, j) = (at / (n * n), at / n % n, at % n);
            let what = format!("K[{i}, {j}] of channel {channel} is {}, expected K ≥ 0", values[at]);
            return Err(Error::invariant("operator", what));
        }
        Ok(Operator { n, channels, bounces: meta.bounces, values: values.into() })
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        b.meta("series.meta", FLAG_REQUIRED, &Meta { bounces: self.bounces });
        let shape = [self.channels, self.n, self.n];
        b.array("series.values", FLAG_REQUIRED | FLAG_PATCH_ORDER, &shape, &self.values[..]);
    }
}
