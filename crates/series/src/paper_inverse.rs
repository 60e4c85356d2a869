//! All bounces by the inverse of I − F ρ, as A. Shcherbakov and V. Frolov write it (Light & Engineering 27(2), 2019):
//! F as given, row = receiver, neither made reciprocal nor symmetric, ρ at the sender, (F ρ)_ij = F_ij ρ_j, and LU with
//! partial pivoting, (I − F ρ) G = F. Then
//! K = A^{1/2} G A^{-1/2}.
//!
//! Nothing here notices that light grows from bounce to bounce: past a spectral radius of 1 the inverse still
//! exists and has negative values.
//! Source: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., §3.4 (partial pivoting), by panels.

use faer::{
    Accum, MatMut, MatRef, Par, Spec,
    dyn_stack::{MemBuffer, MemStack},
    linalg::{
        lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch},
        triangular_solve::{solve_unit_lower_triangular_in_place, solve_upper_triangular_in_place},
    },
};
use rayon::prelude::*;

use crate::{
    methods::{Solved, bytes},
    one_bounce::OneBounce,
    scalar::Scalar,
    tiles::{Grid, Panels, multiply},
};

/// Panels that are eliminated or solved.
pub fn work(grid: Grid) -> u64 {
    let t = grid.count as u64;
    t * (t - 1) / 2 + t
}

/// Solves; where the matrix is singular the values are not finite.
pub fn solve<S: Scalar, T: Scalar>(one: &OneBounce<S>, rho: &[f64], tick: &(dyn Fn(u64) + Sync)) -> Solved {
    let grid = one.grid;
    let (mut system, mut result) = (Panels::<T>::zeros(grid), Panels::<T>::zeros(grid));
    system.fill(|i, j| f64::from(u8::from(i == j)) - one.factor(i, j) * rho[j]);
    result.fill(|i, j| one.factor(i, j));
    let orders = factor(&mut system, tick);
    result.par_panels().enumerate().for_each(|(at, panel)| {
        for (k, order) in orders.iter().enumerate() {
            eliminate(grid, k, order, &system.values[k * grid.panel_size()..], panel);
        }
        substitute_back(&system, panel);
        for (c, column) in panel.chunks_exact_mut(grid.padded()).enumerate() {
            let sender = one.inverse_root[at * grid.edge + c];
            for (value, receiver) in column.iter_mut().zip(&one.root_area) {
                *value = T::of((*value).into() * receiver * sender);
            }
        }
        tick(1);
    });
    let peak_bytes = bytes(&system.values) + bytes(&result.values);
    Solved { k: Box::new(result), iterations: None, peak_bytes }
}

/// P A = L U, both over A. Returns for every panel the order that its rows, from the diagonal down, were brought into.
fn factor<T: Scalar>(matrix: &mut Panels<T>, tick: &(dyn Fn(u64) + Sync)) -> Vec<Vec<usize>> {
    let grid = matrix.grid;
    let (edge, rows, size) = (grid.edge, grid.padded(), grid.panel_size());
    (0..grid.count)
        .map(|k| {
            let (left, right) = matrix.values.split_at_mut((k + 1) * size);
            let panel = &mut left[k * size..];
            let below = MatMut::from_column_major_slice_mut(panel, rows, edge).subrows_mut(k * edge, rows - k * edge);
            let (mut order, mut inverse) = (vec![0_usize; rows - k * edge], vec![0_usize; rows - k * edge]);
            let scratch = lu_in_place_scratch::<usize, T>(rows - k * edge, edge, Par::Seq, Spec::default());
            let mut memory = MemBuffer::new(scratch);
            let stack = MemStack::new(&mut memory);
            lu_in_place(below, &mut order, &mut inverse, Par::Seq, stack, Spec::default());
            right.par_chunks_mut(size).for_each(|columns| {
                eliminate(grid, k, &order, panel, columns);
                tick(1);
            });
            order
        })
        .collect()
}

/// Exchanges rows of `columns` as panel `k` did, solves its rows with L and takes their share from those below.
fn eliminate<T: Scalar>(grid: Grid, k: usize, order: &[usize], panel: &[T], columns: &mut [T]) {
    let (edge, rows) = (grid.edge, grid.padded());
    let mut before = vec![T::of(0.0); order.len()];
    for column in columns.chunks_exact_mut(rows) {
        let column = &mut column[k * edge..];
        before.copy_from_slice(column);
        column.iter_mut().zip(order).for_each(|(value, &from)| *value = before[from]);
    }
    let l = MatRef::from_column_major_slice(&panel[..grid.panel_size()], rows, edge).split_at_row(k * edge).1;
    let (corner, low) = l.split_at_row(edge);
    let columns = MatMut::from_column_major_slice_mut(columns, rows, edge).split_at_row_mut(k * edge).1;
    let (mut solved, rest) = columns.split_at_row_mut(edge);
    solve_unit_lower_triangular_in_place(corner, solved.as_mut(), Par::Seq);
    multiply(rest, Accum::Add, low, solved.as_ref(), -1.0);
}

/// `columns` ← U⁻¹ `columns`.
fn substitute_back<T: Scalar>(u: &Panels<T>, columns: &mut [T]) {
    let (edge, rows) = (u.grid.edge, u.grid.padded());
    for k in (0..u.grid.count).rev() {
        let (above, corner) = u.panel(k).split_at_row(k * edge);
        let columns = MatMut::from_column_major_slice_mut(columns, rows, edge);
        let (rest, block) = columns.split_at_row_mut(k * edge);
        let mut block = block.split_at_row_mut(edge).0;
        solve_upper_triangular_in_place(corner.split_at_row(edge).0, block.as_mut(), Par::Seq);
        multiply(rest, Accum::Add, above, block.as_ref(), -1.0);
    }
}
