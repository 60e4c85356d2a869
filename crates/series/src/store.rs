//! From f64 tiles to the f32 rows of the container.

use rayon::prelude::*;

use crate::tiles::Lower;

/// What rounding left below zero.
#[derive(Clone, Copy, Default)]
pub struct Clamped {
    /// Values that were stored as 0.
    pub count: u64,
    /// The lowest of them.
    pub lowest: f64,
}

/// Writes a symmetric matrix to `out`, n × n, row-major. Both halves come from the same tile, so symmetry is exact.
///
/// K is a sum of products of numbers ≥ 0; only rounding can bring it below 0, and readers rely on K ≥ 0.
pub fn store(k: &Lower, out: &mut [f32]) -> Clamped {
    let grid = k.grid;
    let row_of = |(row, out): (usize, &mut [f32])| {
        let (ti, r) = (row / grid.edge, row % grid.edge);
        let mut clamped = Clamped::default();
        for (tj, out) in out.chunks_mut(grid.edge).enumerate() {
            let transposed = tj > ti;
            let tile = if transposed { k.tile(tj, ti) } else { k.tile(ti, tj) };
            for (c, out) in out.iter_mut().enumerate() {
                let value = if transposed { tile[(c, r)] } else { tile[(r, c)] };
                if value < 0.0 {
                    clamped = Clamped { count: clamped.count + 1, lowest: clamped.lowest.min(value) };
                }
                *out = value.max(0.0) as f32;
            }
        }
        clamped
    };
    let join = |a: Clamped, b: Clamped| Clamped { count: a.count + b.count, lowest: a.lowest.min(b.lowest) };
    out.par_chunks_mut(grid.n).enumerate().map(row_of).reduce(Clamped::default, join)
}
