//! All bounces by conjugate gradients: (I − R W R) X = R W column by column, then K = W + W R X.
//!
//! A panel of columns is one task; its columns share the products with R W R, and each has its own step lengths.
//! The number of steps grows with the square root of the condition number, the memory stays at that of W and K.
//! Source: M. R. Hestenes, E. Stiefel, Methods of conjugate gradients for solving linear systems,
//! J. Res. Nat. Bur. Standards 49 (1952), 409–436.

use faer::{MatMut, MatRef};
use rayon::prelude::*;

use crate::{
    methods::{Failure, Solved, bytes},
    one_bounce::OneBounce,
    scalar::{Scalar, dot},
    tiles::{Grid, Lower, Panels},
};

/// Blocks of columns that a task holds besides its panel of the result.
const BLOCKS: u64 = 3;

/// Panels that are done: how many steps each takes is not known before.
pub fn work(grid: Grid) -> u64 {
    grid.count as u64
}

/// Values of all blocks that exist at the same time.
pub fn block_values(grid: Grid) -> u64 {
    let tasks = grid.count.min(rayon::current_num_threads()) as u64;
    BLOCKS * tasks * grid.panel_size() as u64
}

/// Solves until the residual of every column has shrunk to `tolerance`, or finds negative curvature.
pub fn solve<S: Scalar, T: Scalar>(
    one: &OneBounce<S>,
    root_rho: &[f64],
    tolerance: f64,
    tick: &(dyn Fn(u64) + Sync),
) -> Result<Solved, Failure> {
    let grid = one.grid;
    let (mut matrix, mut result) = (Lower::<T>::zeros(grid), Panels::<T>::zeros(grid));
    result.fill(|i, j| root_rho[i] * one.w(i, j));
    matrix.fill(|i, j| root_rho[i] * one.w(i, j) * root_rho[j]);
    let panel = |panel: &mut [T]| {
        let steps = Block::new(&matrix, panel, tolerance).solve();
        tick(1);
        steps
    };
    let steps: Vec<Result<u64, Failure>> = result.par_panels().map(panel).collect();
    let iterations = steps.into_iter().try_fold(0, |most, steps| Ok(steps?.max(most)))?;

    matrix.fill(|i, j| one.w(i, j));
    result.par_panels().enumerate().for_each(|(at, panel)| gather(one, root_rho, &matrix, at, panel));
    let peak_bytes = bytes(&matrix.values) + bytes(&result.values) + block_values(grid) * size_of::<T>() as u64;
    Ok(Solved { k: Box::new(result), iterations: Some(iterations), peak_bytes })
}

/// Columns of X to columns of K: `panel` ← W + W R `panel`.
fn gather<S: Scalar, T: Scalar>(one: &OneBounce<S>, root_rho: &[f64], w: &Lower<T>, at: usize, panel: &mut [T]) {
    let Grid { edge, .. } = w.grid;
    let rows = w.grid.padded();
    let scaled: Vec<T> = panel.iter().zip(root_rho.iter().cycle()).map(|(&x, r)| T::of(r * x.into())).collect();
    let scaled = MatRef::from_column_major_slice(&scaled, rows, edge);
    w.times_block(scaled, MatMut::from_column_major_slice_mut(panel, rows, edge));
    for (c, column) in panel.chunks_exact_mut(rows).enumerate() {
        for (i, value) in column.iter_mut().enumerate() {
            *value = T::of((*value).into() + one.w(i, at * edge + c));
        }
    }
}

/// Conjugate gradients on some columns, all vectors `rows` long and one after the other.
struct Block<'a, T> {
    matrix: &'a Lower<T>,
    tolerance: f64,
    /// The right sides at first, then the solutions.
    solution: &'a mut [T],
    residual: Vec<T>,
    direction: Vec<T>,
    /// R W R times the directions.
    product: Vec<T>,
}

impl<'a, T: Scalar> Block<'a, T> {
    fn new(matrix: &'a Lower<T>, right: &'a mut [T], tolerance: f64) -> Block<'a, T> {
        let (residual, direction) = (right.to_vec(), right.to_vec());
        right.fill(T::of(0.0));
        let product = vec![T::of(0.0); direction.len()];
        Block { matrix, tolerance, solution: right, residual, direction, product }
    }

    /// Returns the number of steps.
    fn solve(mut self) -> Result<u64, Failure> {
        let (rows, edge) = (self.matrix.grid.padded(), self.matrix.grid.edge);
        // In exact arithmetic n steps are enough.
        let limit = 4 * self.matrix.grid.n as u64 + 100;
        let mut squared: Vec<f64> = self.residual.chunks_exact(rows).map(|r| dot(r, r)).collect();
        let goal: Vec<f64> = squared.iter().map(|s| s * self.tolerance.powi(2)).collect();
        for step in 0..=limit {
            if squared.iter().zip(&goal).all(|(s, goal)| s <= goal) {
                return Ok(step);
            }
            let direction = MatRef::from_column_major_slice(&self.direction, rows, edge);
            self.matrix.times_block(direction, MatMut::from_column_major_slice_mut(&mut self.product, rows, edge));
            for (column, (squared, goal)) in squared.iter_mut().zip(&goal).enumerate() {
                if *squared > *goal {
                    *squared = self.step(column * rows..(column + 1) * rows, *squared)?;
                }
            }
        }
        Err(Failure::Stalled { steps: limit })
    }

    /// One step of one column; returns the squared length of its new residual.
    fn step(&mut self, column: std::ops::Range<usize>, squared: f64) -> Result<f64, Failure> {
        let (x, r) = (&mut self.solution[column.clone()], &mut self.residual[column.clone()]);
        let (p, wp) = (&mut self.direction[column.clone()], &self.product[column]);
        let curvature = dot(p, p) - dot(p, wp);
        // Not a number, too, is not positive.
        if curvature.is_nan() || curvature <= 0.0 {
            return Err(Failure::NotPositive);
        }
        let length = squared / curvature;
        for i in 0..x.len() {
            let (direction, product): (f64, f64) = (p[i].into(), wp[i].into());
            x[i] = T::of(x[i].into() + length * direction);
            r[i] = T::of(r[i].into() - length * (direction - product));
        }
        let next = dot(r, r);
        p.iter_mut().zip(&*r).for_each(|(p, &r)| *p = T::of(r.into() + next / squared * (*p).into()));
        Ok(next)
    }
}
