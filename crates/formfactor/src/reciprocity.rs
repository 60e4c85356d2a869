//! Two measurements of a pair of patches become one exchange area.
//!
//! E_ij = A_i F_ij = A_j F_ji was counted from both ends. A count c of N rays has variance
//! N F = N E / A, so weighting both ends by their inverse variance gives
//! E_ij = (c_ij + c_ji) / (N_i / A_i + N_j / A_j): all rays pooled, docs/theory.md (9.2).

use crate::gather::Tally;

/// Pairs are visited in squares of this many rows, so that both ends stay in the cache.
const BLOCK: usize = 64;

/// Replaces the counts in `matrix` by exchange areas E, symmetric to the bit; returns the RMS
/// difference of the two measurements relative to the RMS of their mean.
pub fn join(matrix: &mut [f32], area: &[f32], tallies: &[Tally]) -> f64 {
    let n = area.len();
    let density: Vec<f64> = area.iter().zip(tallies).map(|(&a, t)| f64::from(t.rays) / f64::from(a)).collect();
    let (mut difference, mut mean) = (0.0, 0.0);
    for_each_pair(n, |i, j| {
        let (there, back) = (f64::from(matrix[i * n + j]), f64::from(matrix[j * n + i]));
        if there + back == 0.0 {
            return;
        }
        let joined = ((there + back) / (density[i] + density[j])) as f32;
        (matrix[i * n + j], matrix[j * n + i]) = (joined, joined);
        if i != j && density[i] > 0.0 && density[j] > 0.0 {
            let (there, back) = (there / density[i], back / density[j]);
            difference += (there - back).powi(2);
            mean += (0.5 * (there + back)).powi(2);
        }
    });
    if mean > 0.0 { (difference / mean).sqrt() } else { 0.0 }
}

/// Finished form factors against what physics allows a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// The largest |A_i F_ij − A_j F_ji| relative to the pair's mean.
    pub reciprocity: f64,
    /// The largest A_i F_ij / min(A_i, A_j), which is at most 1, and its i and j.
    pub fullest: f64,
    pub fullest_pair: [usize; 2],
    /// The least F_ij, which is at least 0.
    pub least: f64,
}

/// Holds every pair of finished form factors against its limits.
pub fn limits(values: &[f32], area: &[f32]) -> Limits {
    let n = area.len();
    let mut limits = Limits::default();
    for_each_pair(n, |i, j| {
        let there = f64::from(area[i]) * f64::from(values[i * n + j]);
        let back = f64::from(area[j]) * f64::from(values[j * n + i]);
        limits.least = limits.least.min(there.min(back));
        if there + back > 0.0 {
            limits.reciprocity = limits.reciprocity.max(2.0 * (there - back).abs() / (there + back));
            let full = there.max(back) / f64::from(area[i].min(area[j]));
            if full > limits.fullest {
                (limits.fullest, limits.fullest_pair) = (full, [i, j]);
            }
        }
    });
    limits
}

/// Calls `visit(i, j)` for every j ≤ i below `n`, square by square.
fn for_each_pair(n: usize, mut visit: impl FnMut(usize, usize)) {
    for rows in (0..n).step_by(BLOCK) {
        for columns in (0..=rows).step_by(BLOCK) {
            for i in rows..n.min(rows + BLOCK) {
                for j in columns..(columns + BLOCK).min(i + 1) {
                    visit(i, j);
                }
            }
        }
    }
}
