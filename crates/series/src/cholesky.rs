//! All bounces by L Lᵀ = I − R W R, tile by tile: Y = L⁻¹ R W and K = W + Yᵀ Y, docs/theory.md (5.4).
//!
//! Right-looking: factor a diagonal tile, solve the tiles below it, take their products from all
//! tiles to the right. faer does the work inside a tile.
//! Source: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., §4.2.6 (block Cholesky).

use faer::{
    Accum, MatMut, MatRef, Par, Spec,
    dyn_stack::{MemBuffer, MemStack},
    linalg::{
        cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch},
        triangular_solve::solve_lower_triangular_in_place,
    },
};
use rayon::prelude::*;

use crate::{
    methods::{Failure, Solved, bytes},
    one_bounce::OneBounce,
    scalar::Scalar,
    tiles::{Grid, Lower, Panels, multiply},
};

/// Products of two tiles that it takes.
pub fn work(grid: Grid) -> u64 {
    let t = grid.count as u64;
    t * (t * t - 1) / 6 + t * t * (t + 1)
}

/// Solves, or finds that I − R W R is not positive definite.
pub fn solve<S: Scalar, T: Scalar>(
    one: &OneBounce<S>,
    root_rho: &[f64],
    tick: &(dyn Fn(u64) + Sync),
) -> Result<Solved, Failure> {
    let grid = one.grid;
    let mut square = Lower::<T>::zeros(grid);
    square.fill(|i, j| f64::from(u8::from(i == j)) - root_rho[i] * one.w(i, j) * root_rho[j]);
    factor(&mut square, tick)?;
    let mut panels = Panels::<T>::zeros(grid);
    panels.fill(|i, j| root_rho[i] * one.w(i, j));
    solve_panels(&square, &mut panels, tick);
    square.fill(|i, j| one.w(i, j));
    square.accumulate_product(Accum::Add, &panels, &panels, tick);
    let peak_bytes = bytes(&square.values) + bytes(&panels.values);
    Ok(Solved { k: Box::new(square), iterations: None, peak_bytes })
}

/// Replaces a symmetric matrix by its Cholesky factor L (the upper half of diagonal tiles is left as it was).
fn factor<T: Scalar>(matrix: &mut Lower<T>, tick: &(dyn Fn(u64) + Sync)) -> Result<(), Failure> {
    let grid = matrix.grid;
    let (edge, size) = (grid.edge, grid.tile_size());
    for k in 0..grid.count {
        let diagonal = factor_tile(matrix, k)?;
        let diagonal = MatRef::from_column_major_slice(&diagonal, edge, edge);

        matrix.par_tiles().filter(|((i, j), _)| *j == k && *i > k).for_each(|(_, tile)| {
            // X Lᵀ = A is L Xᵀ = Aᵀ.
            let tile = MatMut::from_column_major_slice_mut(tile, edge, edge);
            solve_lower_triangular_in_place(diagonal, tile.transpose_mut(), Par::Seq);
        });

        // The solved tiles are copied so that the others may be written while these are read.
        let below: Vec<T> = (k + 1..grid.count)
            .flat_map(|i| {
                let start = (i * (i + 1) / 2 + k) * size;
                &matrix.values[start..start + size]
            })
            .copied()
            .collect();
        let solved = |i: usize| MatRef::from_column_major_slice(&below[(i - k - 1) * size..][..size], edge, edge);
        matrix.par_tiles().filter(|((_, j), _)| *j > k).for_each(|((i, j), tile)| {
            let tile = MatMut::from_column_major_slice_mut(tile, edge, edge);
            multiply(tile, Accum::Add, solved(i), solved(j).transpose(), -1.0);
            tick(1);
        });
    }
    Ok(())
}

/// Factors diagonal tile k in place and returns a copy of it.
fn factor_tile<T: Scalar>(matrix: &mut Lower<T>, k: usize) -> Result<Vec<T>, Failure> {
    let (edge, size) = (matrix.grid.edge, matrix.grid.tile_size());
    let start = (k * (k + 1) / 2 + k) * size;
    let tile = &mut matrix.values[start..start + size];
    let mut memory = MemBuffer::new(cholesky_in_place_scratch::<T>(edge, Par::Seq, Spec::default()));
    cholesky_in_place(
        MatMut::from_column_major_slice_mut(tile, edge, edge),
        Default::default(),
        Par::Seq,
        MemStack::new(&mut memory),
        Spec::default(),
    )
    .map_err(|_| Failure::NotPositive)?;
    Ok(tile.to_vec())
}

/// Y ← L⁻¹ Y, one panel of columns a task.
fn solve_panels<T: Scalar>(l: &Lower<T>, y: &mut Panels<T>, tick: &(dyn Fn(u64) + Sync)) {
    let grid = l.grid;
    let (edge, rows) = (grid.edge, grid.padded());
    y.par_panels().for_each(|panel| {
        let mut panel = MatMut::from_column_major_slice_mut(panel, rows, edge);
        for i in 0..grid.count {
            let (done, rest) = panel.as_mut().split_at_row_mut(i * edge);
            let mut block = rest.split_at_row_mut(edge).0;
            if i > 0 {
                multiply(block.as_mut(), Accum::Add, l.row(i, i - 1), done.as_ref(), -1.0);
            }
            solve_lower_triangular_in_place(l.tile(i, i), block, Par::Seq);
            tick(i as u64 + 1);
        }
    });
}
