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

/// How many entries are kept apart as outliers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outliers {
    /// Where half is stored: as [`Params::error`] has it. The whole: 1 %, the knee that the paper's format has.
    Auto,
    /// A share of the entries, 0..=1. An entry of the whole matrix is kept apart for all channels if it is for one,
    /// so coloured operators have a few more.
    Share(f64),
}

/// How to pack.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// BC1 holds the whole matrix, three channels in 4 bits a texel; BC4 half of luma, with colour apart.
    pub format: BlockFormat,
    /// Map from codes to values.
    pub map: MapKind,
    /// Entries that are too large for the map.
    pub outliers: Outliers,
    /// Where half is stored: relative error of light, L2, that outliers and colour are to stay within with as few
    /// bytes as they can. Where they cannot, they take what loses least.
    pub error: f64,
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
    /// The paper's format: the whole matrix, logarithm, BC1, 1 % outliers.
    pub const PAPER: Params = Params {
        format: BlockFormat::Bc1,
        map: MapKind::Log,
        outliers: Outliers::Auto,
        error: 0.01,
        shift: 6.0,
        keep_dense: false,
        probes: 20,
        seed: 1,
    };
    /// The paper's map; half of luma in finer blocks, and colour of low rank.
    pub const BC4_LOG: Params = Params { format: BlockFormat::Bc4, ..Params::PAPER };
    /// The same with a square root: the default.
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
        if let Outliers::Share(share) = self.outliers
            && !(0.0..=1.0).contains(&share)
        {
            return refuse("outliers", share.to_string(), "a share 0..=1");
        }
        if !(self.error > 0.0 && self.error <= 1.0) {
            return refuse("error", self.error.to_string(), "a relative error above 0 and up to 1");
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
