//! Dense matrices cut into square tiles, so that every tile is one task on one thread.
//!
//! The cut depends on n alone. Within a tile values are column-major; beyond n there are zeros.

use faer::{Accum, MatMut, MatRef, Par, linalg::matmul::matmul};
use rayon::prelude::*;

use crate::scalar::{Scalar, add_scaled, dot};

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

    /// Values of a [`Lower`].
    pub fn lower_size(&self) -> usize {
        self.count * (self.count + 1) / 2 * self.tile_size()
    }

    /// Values of one panel of [`Panels`].
    pub fn panel_size(&self) -> usize {
        self.padded() * self.edge
    }

    /// Values of [`Panels`].
    pub fn panels_size(&self) -> usize {
        self.padded() * self.padded()
    }

    /// A vector over the rows, `value(row)` in each, 0 in the padding.
    pub fn vector(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..self.padded()).map(|i| if i < self.n { value(i) } else { 0.0 }).collect()
    }
}

/// A solution, in whichever precision and layout its method left it.
pub trait Matrix: Sync {
    /// The matrix times a padded vector, summed in f64.
    fn times(&self, x: &[f64]) -> Vec<f64>;
    /// One value.
    fn at(&self, row: usize, column: usize) -> f64;
}

/// The lower half of a symmetric matrix, or a lower triangular one: tiles on and below the diagonal, row by row.
/// Diagonal tiles of a symmetric matrix are complete.
pub struct Lower<T> {
    pub grid: Grid,
    pub values: Vec<T>,
}

impl<T: Scalar> Lower<T> {
    /// A matrix of zeros.
    pub fn zeros(grid: Grid) -> Lower<T> {
        Lower { grid, values: vec![T::of(0.0); grid.lower_size()] }
    }

    /// Sets every value; `value(i, j)` is called for the padding too.
    pub fn fill(&mut self, value: impl Fn(usize, usize) -> f64 + Sync) {
        let edge = self.grid.edge;
        self.par_tiles().for_each(|((ti, tj), tile)| {
            for (at, out) in tile.iter_mut().enumerate() {
                *out = T::of(value(ti * edge + at % edge, tj * edge + at / edge));
            }
        });
    }

    /// Tiles (i, 0) … (i, last): together they are one column-major matrix.
    pub fn row(&self, i: usize, last: usize) -> MatRef<'_, T> {
        let (size, edge) = (self.grid.tile_size(), self.grid.edge);
        let start = i * (i + 1) / 2 * size;
        MatRef::from_column_major_slice(&self.values[start..start + (last + 1) * size], edge, (last + 1) * edge)
    }

    /// Tile (i, j), j ≤ i.
    pub fn tile(&self, i: usize, j: usize) -> MatRef<'_, T> {
        let edge = self.grid.edge;
        MatRef::from_column_major_slice(self.tile_values(i, j), edge, edge)
    }

    fn tile_values(&self, i: usize, j: usize) -> &[T] {
        let size = self.grid.tile_size();
        &self.values[(i * (i + 1) / 2 + j) * size..][..size]
    }

    /// Every tile with its place, one task each.
    pub fn par_tiles(&mut self) -> impl ParallelIterator<Item = ((usize, usize), &mut [T])> {
        let grid = self.grid;
        grid.lower().into_par_iter().zip(self.values.par_chunks_mut(grid.tile_size()))
    }

    /// `out` ← the symmetric matrix times a block of padded columns, on this thread.
    pub fn times_block(&self, x: MatRef<T>, mut out: MatMut<T>) {
        let Grid { edge, count, .. } = self.grid;
        for i in 0..count {
            let mut out = out.as_mut().subrows_mut(i * edge, edge);
            multiply(out.as_mut(), Accum::Replace, self.row(i, i), x.subrows(0, (i + 1) * edge), 1.0);
            for j in i + 1..count {
                multiply(out.as_mut(), Accum::Add, self.tile(j, i).transpose(), x.subrows(j * edge, edge), 1.0);
            }
        }
    }

    /// Adds to, or replaces, every tile by that of the product aᵀ b, which the caller knows to be symmetric.
    pub fn accumulate_product(&mut self, accum: Accum, a: &Panels<T>, b: &Panels<T>, tick: &(dyn Fn(u64) + Sync)) {
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

impl<T: Scalar> Matrix for Lower<T> {
    fn times(&self, x: &[f64]) -> Vec<f64> {
        let Grid { edge, count, .. } = self.grid;
        let mut product = vec![0.0; x.len()];
        product.par_chunks_mut(edge).enumerate().for_each(|(i, out)| {
            for (j, x) in x.chunks_exact(edge).enumerate().take(count) {
                if j <= i {
                    let columns = self.tile_values(i, j).chunks_exact(edge);
                    columns.zip(x).for_each(|(column, &x)| add_scaled(out, x, column));
                } else {
                    let columns = self.tile_values(j, i).chunks_exact(edge);
                    columns.zip(out.iter_mut()).for_each(|(column, out)| *out += dot(column, x));
                }
            }
        });
        product
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        let (edge, (high, low)) = (self.grid.edge, (row.max(column), row.min(column)));
        self.tile_values(high / edge, low / edge)[low % edge * edge + high % edge].into()
    }
}

/// A full matrix as panels of columns, each column-major over all padded rows.
pub struct Panels<T> {
    pub grid: Grid,
    pub values: Vec<T>,
}

impl<T: Scalar> Panels<T> {
    /// A matrix of zeros.
    pub fn zeros(grid: Grid) -> Panels<T> {
        Panels { grid, values: vec![T::of(0.0); grid.panels_size()] }
    }

    /// Every panel, one task each.
    pub fn par_panels(&mut self) -> impl IndexedParallelIterator<Item = &mut [T]> {
        self.values.par_chunks_mut(self.grid.panel_size())
    }

    /// Sets every value; `value(i, j)` is called for the padding too.
    pub fn fill(&mut self, value: impl Fn(usize, usize) -> f64 + Sync) {
        let grid = self.grid;
        self.par_panels().enumerate().for_each(|(panel, out)| {
            // Tile by tile, because `value` often reads both (i, j) and (j, i) of a row-major matrix.
            for i in (0..grid.padded()).step_by(grid.edge) {
                for (j, column) in out.chunks_exact_mut(grid.padded()).enumerate() {
                    for (r, out) in column[i..i + grid.edge].iter_mut().enumerate() {
                        *out = T::of(value(i + r, panel * grid.edge + j));
                    }
                }
            }
        });
    }

    /// Sets this matrix to `diag(scale)` · `source`.
    pub fn fill_scaled(&mut self, source: &Lower<T>, scale: &[f64]) {
        let Grid { edge, .. } = self.grid;
        let rows = self.grid.padded();
        self.par_panels().enumerate().for_each(|(j, panel)| {
            for (c, column) in panel.chunks_exact_mut(rows).enumerate() {
                for (i, block) in column.chunks_exact_mut(edge).enumerate() {
                    let (tile, transposed) =
                        if i >= j { (source.tile(i, j), false) } else { (source.tile(j, i), true) };
                    for (r, value) in block.iter_mut().enumerate() {
                        let element = if transposed { tile[(c, r)] } else { tile[(r, c)] };
                        *value = T::of(scale[i * edge + r] * element.into());
                    }
                }
            }
        });
    }

    /// Columns of panel j.
    pub fn panel(&self, j: usize) -> MatRef<'_, T> {
        let size = self.grid.panel_size();
        MatRef::from_column_major_slice(&self.values[j * size..(j + 1) * size], self.grid.padded(), self.grid.edge)
    }
}

impl<T: Scalar> Matrix for Panels<T> {
    fn times(&self, x: &[f64]) -> Vec<f64> {
        let (edge, rows) = (self.grid.edge, self.grid.padded());
        let mut product = vec![0.0; x.len()];
        product.par_chunks_mut(edge).enumerate().for_each(|(i, out)| {
            let columns = self.values.chunks_exact(rows).zip(x);
            columns.for_each(|(column, &x)| add_scaled(out, x, &column[i * edge..(i + 1) * edge]));
        });
        product
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        self.values[column * self.grid.padded() + row].into()
    }
}

/// `out` ← (`out` or 0) + `alpha` a b on this thread alone, so that the order of the sums is fixed.
pub fn multiply<T: Scalar>(out: MatMut<T>, accum: Accum, a: MatRef<T>, b: MatRef<T>, alpha: f64) {
    matmul(out, accum, a, b, T::of(alpha), Par::Seq);
}

/// Copies the lower triangle to the upper one: products of symmetric factors are symmetric only up to rounding.
fn mirror<T: Scalar>(mut tile: MatMut<T>) {
    for c in 1..tile.ncols() {
        for r in 0..c {
            tile[(r, c)] = tile[(c, r)];
        }
    }
}
