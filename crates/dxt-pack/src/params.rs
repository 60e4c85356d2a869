//! What can be chosen.

use radfile::{BlockFormat, ValueMap};

use crate::{Error, Result};

/// Kind of map between codes and values; [`ValueMap`] has the formulas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapKind {
    /// Logarithm with [`Params::shift`], the paper's.
    Log,
    /// Square root.
    Sqrt,
}

/// How to pack.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// Block format: BC1 holds three channels in 4 bits a texel, BC4 one.
    pub format: BlockFormat,
    /// Map from codes to values.
    pub map: MapKind,
    /// Share of the entries of each channel that are kept apart as outliers, 0..=1. An entry is kept
    /// apart for all channels if it is for one, so coloured operators have a few more.
    pub outliers: f64,
    /// Span of the logarithm: values below exp(−shift) of the largest one that is no outlier become 0.
    pub shift: f32,
    /// Whether the dense operator and the form factors stay in the container.
    pub keep_dense: bool,
    /// Number of probe lights that the error is measured with; 0 does not measure.
    pub probes: u32,
    /// Seed of the probe lights.
    pub seed: u64,
}

impl Params {
    /// The paper's format: logarithm, BC1, 1 % outliers.
    pub const PAPER: Params = Params {
        format: BlockFormat::Bc1,
        map: MapKind::Log,
        outliers: 0.01,
        shift: 6.0,
        keep_dense: false,
        probes: 20,
        seed: 1,
    };
    /// The paper's map in finer blocks.
    pub const BC4_LOG: Params = Params { format: BlockFormat::Bc4, ..Params::PAPER };
    /// Square root in finer blocks: the default.
    pub const BC4_SQRT: Params = Params { map: MapKind::Sqrt, ..Params::BC4_LOG };
    /// Combinations with a name.
    pub const PRESETS: [(&str, Params); 3] =
        [("paper", Params::PAPER), ("bc4-log", Params::BC4_LOG), ("bc4-sqrt", Params::BC4_SQRT)];

    /// The map with its parameter.
    pub fn value_map(&self) -> ValueMap {
        match self.map {
            MapKind::Log => ValueMap::Log { shift: self.shift },
            MapKind::Sqrt => ValueMap::Sqrt,
        }
    }

    pub(crate) fn check(&self) -> Result<()> {
        let refuse = |option, found: String, expected| Err(Error::Option { option, found, expected });
        if !(0.0..=1.0).contains(&self.outliers) {
            return refuse("outliers", self.outliers.to_string(), "a share 0..=1");
        }
        // Past 80 the smallest value would underflow f32.
        if self.map == MapKind::Log && !(self.shift > 0.0 && self.shift <= 80.0) {
            return refuse("shift", self.shift.to_string(), "a number above 0 and up to 80 (6 is usual)");
        }
        Ok(())
    }
}

impl Default for Params {
    fn default() -> Params {
        Params::BC4_SQRT
    }
}
