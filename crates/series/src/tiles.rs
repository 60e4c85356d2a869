//! Dense matrices cut into square tiles, so that every tile is one task on one thread.
//!
//! The cut depends on n alone. Within a tile values are column-major; beyond n there are zeros.

use faer::{Accum, MatMut, MatRef, Par, linalg::matmul::matmul};
use rayon::prelude::*;

/// Largest edge of a tile. Large enough for faer's kernels to run at full speed, small enough for
/// a matrix of 3000 patches to keep sixteen threads busy.
const LARGEST_EDGE: usize = 192;

/// How an n × n matrix is cut.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Rows of the matrix.
    pub n: usize,
    /// Rows of a tile.
    pub edge: usize,
    /// Tiles along an edge of the matrix.
    pub count: usize,
}

impl Grid {
    /// The cut of `n` rows: as many tiles as needed, all equal, edges a multiple of 8.
    pub fn new(n: usize) -> Grid {
        let edge = n.div_ceil(n.div_ceil(LARGEST_EDGE)).next_multiple_of(8);
        Grid { n, edge, count: n.div_ceil(edge) }
    }

    /// Rows of all tiles together.
    pub fn padded(&self) -> usize {
        self.edge * self.count
    }

    /// Row and column of every tile on and below the diagonal, row by row.
    pub fn lower(&self) -> Vec<(usize, usize)> {
        (0..self.count).flat_map(|i| (0..=i).map(move |j| (i, j))).collect()
    }

    /// Values of one tile.
    pub fn tile_size(&self) -> usize {
        self.edge * self.edge
    }

    /// A vector over the rows, `value(row)` in each, 0 in the padding.
    pub fn vector(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..self.padded()).map(|i| if i < self.n { value(i) } else { 0.0 }).collect()
    }
}

/// The lower half of a symmetric matrix, or a lower triangular one: tiles on and below the diagonal, row by row.
/// Diagonal tiles of a symmetric matrix are complete.
pub struct Lower {
    pub grid: Grid,
    pub values: Vec<f64>,
}

impl Lower {
    /// A matrix of zeros.
    pub fn zeros(grid: Grid) -> Lower {
        Lower { grid, values: vec![0.0; grid.count * (grid.count + 1) / 2 * grid.tile_size()] }
    }

    /// Tiles (i, 0) … (i, last): together they are one column-major matrix.
    pub fn row(&self, i: usize, last: usize) -> MatRef<'_, f64> {
        let (size, edge) = (self.grid.tile_size(), self.grid.edge);
        let start = i * (i + 1) / 2 * size;
        MatRef::from_column_major_slice(&self.values[start..start + (last + 1) * size], edge, (last + 1) * edge)
    }

    /// Tile (i, j), j ≤ i.
    pub fn tile(&self, i: usize, j: usize) -> MatRef<'_, f64> {
        let (size, edge) = (self.grid.tile_size(), self.grid.edge);
        let start = (i * (i + 1) / 2 + j) * size;
        MatRef::from_column_major_slice(&self.values[start..start + size], edge, edge)
    }

    /// Every tile with its place, one task each.
    pub fn par_tiles(&mut self) -> impl ParallelIterator<Item = ((usize, usize), &mut [f64])> {
        let grid = self.grid;
        grid.lower().into_par_iter().zip(self.values.par_chunks_mut(grid.tile_size()))
    }

    /// The symmetric matrix times a padded vector.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let Grid { edge, count, .. } = self.grid;
        let mut product = vec![0.0; x.len()];
        product.par_chunks_mut(edge).enumerate().for_each(|(i, out)| {
            let mut out = column_mut(out);
            multiply(out.as_mut(), Accum::Replace, self.row(i, i), column(&x[..(i + 1) * edge]), 1.0);
            for j in i + 1..count {
                let x = column(&x[j * edge..(j + 1) * edge]);
                multiply(out.as_mut(), Accum::Add, self.tile(j, i).transpose(), x, 1.0);
            }
        });
        product
    }

    /// Adds to, or replaces, every tile by that of the product aᵀ b, which the caller knows to be symmetric.
    pub fn accumulate_product(&mut self, accum: Accum, a: &Panels, b: &Panels, tick: &(dyn Fn(u64) + Sync)) {
        let (edge, count) = (self.grid.edge, self.grid.count);
        self.par_tiles().for_each(|((i, j), tile)| {
            let mut out = MatMut::from_column_major_slice_mut(tile, edge, edge);
            multiply(out.as_mut(), accum, a.panel(i).transpose(), b.panel(j), 1.0);
            if i == j {
                mirror(out);
            }
            tick(count as u64);
        });
    }
}

/// A full matrix as panels of columns, each column-major over all padded rows.
pub struct Panels {
    pub grid: Grid,
    pub values: Vec<f64>,
}

impl Panels {
    /// A matrix of zeros.
    pub fn zeros(grid: Grid) -> Panels {
        Panels { grid, values: vec![0.0; grid.padded() * grid.padded()] }
    }

    /// Sets this matrix to `diag(scale)` · `source`.
    pub fn fill_scaled(&mut self, source: &Lower, scale: &[f64]) {
        let (edge, rows) = (self.grid.edge, self.grid.padded());
        self.values.par_chunks_mut(rows * edge).enumerate().for_each(|(j, panel)| {
            for (c, column) in panel.chunks_exact_mut(rows).enumerate() {
                for (i, block) in column.chunks_exact_mut(edge).enumerate() {
                    let (tile, transposed) =
                        if i >= j { (source.tile(i, j), false) } else { (source.tile(j, i), true) };
                    for (r, value) in block.iter_mut().enumerate() {
                        let element = if transposed { tile[(c, r)] } else { tile[(r, c)] };
                        *value = scale[i * edge + r] * element;
                    }
                }
            }
        });
    }

    fn panel(&self, j: usize) -> MatRef<'_, f64> {
        let (edge, rows) = (self.grid.edge, self.grid.padded());
        MatRef::from_column_major_slice(&self.values[j * rows * edge..(j + 1) * rows * edge], rows, edge)
    }
}

/// `out` ← (`out` or 0) + `alpha` a b on this thread alone, so that the order of the sums is fixed.
pub fn multiply(out: MatMut<f64>, accum: Accum, a: MatRef<f64>, b: MatRef<f64>, alpha: f64) {
    matmul(out, accum, a, b, alpha, Par::Seq);
}

/// A vector as a matrix of one column.
pub fn column(x: &[f64]) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(x, x.len(), 1)
}

/// The same, to be written.
pub fn column_mut(x: &mut [f64]) -> MatMut<'_, f64> {
    let rows = x.len();
    MatMut::from_column_major_slice_mut(x, rows, 1)
}

/// Copies the lower triangle to the upper one: products of symmetric factors are symmetric only up to rounding.
fn mirror(mut tile: MatMut<f64>) {
    for c in 1..tile.ncols() {
        for r in 0..c {
            tile[(r, c)] = tile[(c, r)];
        }
    }
}
