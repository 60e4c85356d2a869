//! Extreme eigenvalues: how fast late bounces fade and how well the system is conditioned.
//!
//! All are Rayleigh quotients of symmetric matrices, so they err on one side only: the spectral radius
//! and the condition number are never overestimated.
//! Source: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., §8.2 (power and inverse iteration).

use crate::{
    cholesky::solve_vector,
    tiles::{Grid, Lower},
};

/// Seed of every random vector of this crate; part of the result's definition.
const SEED: u64 = 0x0A11_B0CE;

/// Reproducible numbers in −1 … 1, one a row, 0 in the padding. `stream` tells vectors apart.
pub fn random_vector(grid: Grid, stream: u64) -> Vec<f64> {
    grid.vector(|i| {
        // SplitMix64: S. Vigna's finaliser over a counter.
        let mut z = (SEED.wrapping_add(stream) << 32 | i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    })
}

/// Spectral radius of R W R by power iteration, given up as soon as it is 1 or more.
///
/// W has no negative value, so its radius is its largest eigenvalue; 1 is added to all of them
/// so that the mirror image −λ of facing plates cannot stand in the way.
pub fn radius_before_solving(w: &Lower, root_rho: &[f64]) -> f64 {
    let mut x = w.grid.vector(|_| 1.0);
    let mut radius = 0.0;
    for _ in 0..200 {
        normalise(&mut x);
        let scaled: Vec<f64> = x.iter().zip(root_rho).map(|(x, r)| x * r).collect();
        let y: Vec<f64> = w.times(&scaled).iter().zip(root_rho).map(|(y, r)| y * r).collect();
        let next = dot(&x, &y);
        if next >= 1.0 || (next - radius).abs() < 1e-9 {
            return next;
        }
        radius = next;
        x.iter_mut().zip(&y).for_each(|(x, y)| *x += y);
    }
    radius
}

/// Smallest eigenvalue of I − R W R by inverse iteration with its Cholesky factor.
pub fn smallest_eigenvalue(l: &Lower) -> f64 {
    let mut x = l.grid.vector(|_| 1.0);
    let mut inverse = 1.0;
    for _ in 0..60 {
        normalise(&mut x);
        let mut y = x.clone();
        solve_vector(l, &mut y);
        let next = dot(&x, &y);
        let settled = (next - inverse).abs() < 1e-9 * next;
        inverse = next;
        if settled {
            break;
        }
        x = y;
    }
    1.0 / inverse
}

/// Largest eigenvalue of I − R W R by power iteration.
pub fn largest_eigenvalue(w: &Lower, root_rho: &[f64]) -> f64 {
    let mut x = random_vector(w.grid, 0);
    let mut largest = 1.0;
    for _ in 0..60 {
        normalise(&mut x);
        let scaled: Vec<f64> = x.iter().zip(root_rho).map(|(x, r)| x * r).collect();
        let reflected = w.times(&scaled);
        let y: Vec<f64> = (0..x.len()).map(|i| x[i] - root_rho[i] * reflected[i]).collect();
        let next = dot(&x, &y);
        let settled = (next - largest).abs() < 1e-5 * next;
        largest = next;
        if settled {
            break;
        }
        x = y;
    }
    largest
}

/// Sum of products in index order.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn normalise(x: &mut [f64]) {
    let length = dot(x, x).sqrt();
    x.iter_mut().for_each(|v| *v /= length);
}
