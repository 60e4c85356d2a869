//! How large a lightmap becomes.

use radfile::LARGEST_LIGHTMAP;

use crate::{Error, Result};

/// What decides the number of texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// About so many texels touch the mesh: within a few per cent, and a tenth where most charts are smaller than a texel.
    /// There is one for each chart at least.
    Texels(u32),
    /// Texels along a metre.
    PerMetre(f32),
    /// Texels in a row.
    Width(u32),
}

impl Size {
    /// Refuses what is no number of texels.
    pub(crate) fn check(self) -> Result<()> {
        let (legal, found) = match self {
            Size::Texels(n) => (n > 0, format!("of {n} texels")),
            Size::PerMetre(d) => (d > 0.0 && d.is_finite(), format!("of {d} texels a metre")),
            Size::Width(w) => (w > 0, format!("of width {w}")),
        };
        if legal { Ok(()) } else { Err(Error::Size { found }) }
    }
}

/// Refuses what is too large for a texture.
pub fn check_extent(width: f64, height: f64) -> Result<()> {
    match width.max(height) <= f64::from(LARGEST_LIGHTMAP) {
        true => Ok(()),
        false => Err(Error::TooLarge { width: width as u64, height: height as u64 }),
    }
}

/// The scale at which `count` gives about `wanted`, from a first guess on.
///
/// Counts grow with the square of the scale, and more slowly where charts are smaller than a texel; each step takes the
/// square for granted and so comes nearer from the same side.
pub fn scale_for(wanted: u32, first: f64, count: impl Fn(f64) -> u64) -> f64 {
    const STEPS: usize = 12;
    const NEAR: f64 = 0.005;
    let mut scale = first;
    for _ in 0..STEPS {
        let ratio = f64::from(wanted) / count(scale).max(1) as f64;
        if (ratio - 1.0).abs() < NEAR {
            break;
        }
        scale *= ratio.sqrt();
    }
    scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_is_found_for_areas_with_borders() {
        let count = |s: f64| (3.0 * s * s + 40.0 * s + 100.0) as u64;
        let found = count(scale_for(10_000, 1.0, count));
        assert!((9_900..10_100).contains(&found), "{found}");
    }

    #[test]
    fn sizes_that_are_none_are_refused() {
        for size in [Size::Texels(0), Size::PerMetre(0.0), Size::PerMetre(f32::NAN), Size::Width(0)] {
            assert!(matches!(size.check(), Err(Error::Size { .. })), "{size:?}");
        }
        let said = check_extent(20_000.0, 10.0).unwrap_err().to_string();
        assert!(said.starts_with("the lightmap would have 20000 × 10 texels, a texture holds 16384"), "{said}");
    }
}
