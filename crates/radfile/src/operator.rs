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

    /// What everyone who packs an operator asks of it: that it has patches, as many as the list, and that K ≥ 0.
    ///
    /// # Errors
    ///
    /// [`Error::Invariant`].
    ///
    /// # Panics
    ///
    /// If `values` is not channels × n × n or channels is neither 1 nor 3: a bug in the caller.
    pub fn check(&self, patches: usize) -> Result<()> {
        let n = self.n;
        assert!(matches!(self.channels, 1 | 3), "an operator has 1 or 3 channels, not {}", self.channels);
        assert_eq!(self.values.len(), self.channels * n * n, "values of the operator");
        if n == 0 {
            return Err(Error::invariant(
                "operator",
                "it has no patches, so nothing can be packed (is the scene empty?)",
            ));
        }
        if patches != n {
            let what = format!("it has {n} patches, the patch list {patches}; take both from the same bake");
            return Err(Error::invariant("operator", what));
        }
        check_values(&self.values, n)
    }
}

/// Checks the entries of all channels of `n` patches.
fn check_values(values: &[f32], n: usize) -> Result<()> {
    match values.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
        Some(at) => {
            let (channel, i, j) = (at / (n * n), at / n % n, at % n);
            let what =
                format!("K[{i}, {j}] of channel {channel} is {}, expected K ≥ 0; solve the series again", values[at]);
            Err(Error::invariant("operator", what))
        }
        None => Ok(()),
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
        check_values(values, n)?;
        Ok(Operator { n, channels, bounces: meta.bounces, values: values.into() })
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        b.meta("series.meta", FLAG_REQUIRED, &Meta { bounces: self.bounces });
        let shape = [self.channels, self.n, self.n];
        b.array("series.values", FLAG_REQUIRED | FLAG_PATCH_ORDER, &shape, &self.values[..]);
    }
}
