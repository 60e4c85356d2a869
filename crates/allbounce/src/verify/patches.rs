//! Patches by themselves, and what all checks take from them.

use anyhow::bail;
use radfile::Patches;

use super::check::{Check, check};

/// Area of a patch = sum of its pieces, over which theory.md (2.1) is taken.
pub fn pieces(p: &Patches) -> Check {
    let deviation = |i: usize| {
        let sum: f64 = p.pieces_of(i).iter().map(|piece| area(&piece.corners)).sum();
        (sum / f64::from(p.area[i]) - 1.0).abs()
    };
    check("2.1", "a patch is as large as its pieces", largest((0..p.len()).map(deviation)), 1e-3)
}

fn area(corners: &[[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| glam::Vec3::from(p).as_dvec3());
    0.5 * (b - a).cross(c - a).length()
}

/// Refuses numbers of other patches.
pub fn same_size(what: &str, found: usize, patches: &Patches) -> anyhow::Result<()> {
    if found != patches.len() {
        bail!("{what} are for {found} patches, the file has {}", patches.len());
    }
    Ok(())
}

/// Mean over the area of the patches.
pub fn mean(p: &Patches, value: impl Fn(usize) -> f64) -> f64 {
    let area = |i: usize| f64::from(p.area[i]);
    (0..p.len()).map(|i| area(i) * value(i)).sum::<f64>() / (0..p.len()).map(area).sum::<f64>()
}

/// Pairs of patches, each once.
pub fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(|i| (0..i).map(move |j| (i, j)))
}

/// The largest value, at least 0; one that is no number wins, where `f64::max` would drop it.
pub fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, value| if most.is_nan() || value <= most { most } else { value })
}

/// Difference of two numbers that should agree, relative to the larger.
pub fn mismatch(there: f64, back: f64) -> f64 {
    (there - back).abs() / there.max(back).max(1e-30)
}
