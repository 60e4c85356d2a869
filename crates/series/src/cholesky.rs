//! L Lᵀ = I − R W R, tile by tile, and the solves with L.
//!
//! Right-looking: factor a diagonal tile, solve the tiles below it, take their products from all
//! tiles to the right. faer does the work inside a tile.
//! Source: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., §4.2.6 (block Cholesky).

use faer::{
    Accum, MatMut, MatRef, Par, Spec,
    dyn_stack::{MemBuffer, MemStack},
    linalg::{
        cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch},
        triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place},
    },
};
use rayon::prelude::*;

use crate::tiles::{Lower, Panels, column, column_mut, multiply};

/// The matrix is not positive definite.
#[derive(Debug)]
pub struct NotPositive;

/// Replaces a symmetric matrix by its Cholesky factor L (the upper half of diagonal tiles is left as it was).
pub fn factor(matrix: &mut Lower, tick: &(dyn Fn(u64) + Sync)) -> Result<(), NotPositive> {
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
        let below: Vec<f64> = (k + 1..grid.count)
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
fn factor_tile(matrix: &mut Lower, k: usize) -> Result<Vec<f64>, NotPositive> {
    let (edge, size) = (matrix.grid.edge, matrix.grid.tile_size());
    let start = (k * (k + 1) / 2 + k) * size;
    let tile = &mut matrix.values[start..start + size];
    let mut memory = MemBuffer::new(cholesky_in_place_scratch::<f64>(edge, Par::Seq, Spec::default()));
    cholesky_in_place(
        MatMut::from_column_major_slice_mut(tile, edge, edge),
        Default::default(),
        Par::Seq,
        MemStack::new(&mut memory),
        Spec::default(),
    )
    .map_err(|_| NotPositive)?;
    Ok(tile.to_vec())
}

/// Y ← L⁻¹ Y, one panel of columns a task.
pub fn solve_panels(l: &Lower, y: &mut Panels, tick: &(dyn Fn(u64) + Sync)) {
    let grid = l.grid;
    let (edge, rows) = (grid.edge, grid.padded());
    y.values.par_chunks_mut(rows * edge).for_each(|panel| {
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

/// x ← (L Lᵀ)⁻¹ x for a padded vector.
pub fn solve_vector(l: &Lower, x: &mut [f64]) {
    let (edge, count) = (l.grid.edge, l.grid.count);
    for i in 0..count {
        let (done, rest) = x.split_at_mut(i * edge);
        let mut block = column_mut(&mut rest[..edge]);
        if i > 0 {
            multiply(block.as_mut(), Accum::Add, l.row(i, i - 1), column(done), -1.0);
        }
        solve_lower_triangular_in_place(l.tile(i, i), block, Par::Seq);
    }
    for i in (0..count).rev() {
        let (above, rest) = x.split_at_mut(i * edge);
        let block = &mut rest[..edge];
        solve_upper_triangular_in_place(l.tile(i, i).transpose(), column_mut(block), Par::Seq);
        if i > 0 {
            multiply(column_mut(above), Accum::Add, l.row(i, i - 1).transpose(), column(block), -1.0);
        }
    }
}
