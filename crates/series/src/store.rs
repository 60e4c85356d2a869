//! From a solution to the f32 rows of the container.

use rayon::prelude::*;

use crate::tiles::{Grid, Matrix};

/// Writes the mean of both directions to `out`, n × n, row-major: exactly symmetric.
///
/// K is a sum of products of numbers ≥ 0; only rounding can bring it below 0, and readers rely on K ≥ 0.
pub fn store(k: &dyn Matrix, grid: Grid, out: &mut [f32]) {
    out.par_chunks_mut(grid.n).enumerate().for_each(|(i, row)| {
        for (j, out) in row.iter_mut().enumerate() {
            *out = (0.5 * (k.at(i, j) + k.at(j, i))).max(0.0) as f32;
        }
    });
}
