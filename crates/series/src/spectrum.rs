//! Extreme eigenvalues: how fast late bounces fade and how well the system is conditioned.
//!
//! Krylov subspaces with full orthogonalisation (Arnoldi; for symmetric operators this is Lanczos). Eigenvalues of
//! the small projected matrix approach the extreme ones of the operator from inside, so for symmetric operators
//! the spectral radius and the condition number are never overestimated, but for rounding.
//! Source: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., §10.1 and §10.5.

use faer::{
    Mat, Par, Spec,
    diag::DiagMut,
    dyn_stack::{MemBuffer, MemStack},
    linalg::evd::{ComputeEigenvectors, evd_real, evd_scratch},
};

use crate::{
    one_bounce::OneBounce,
    scalar::{Scalar, add_scaled, dot},
    tiles::Grid,
};

/// Seed of every random vector of this crate; part of the result's definition.
const SEED: u64 = 0x0A11_B0CE;

/// Largest dimension of the subspace. Rooms settle within some dozens.
const MAX_STEPS: usize = 240;

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

/// What the eigenvalues say about the sum of all bounces.
pub struct Spectrum {
    /// Spectral radius of F ρ.
    pub radius: f64,
    /// Condition number (2-norm) of the matrix that the method inverts.
    pub condition: f64,
}

impl Spectrum {
    /// Of I − R W R where W is symmetric, of I − F ρ where it is not.
    pub fn of<S: Scalar>(one: &OneBounce<S>, rho: &[f64]) -> Spectrum {
        if !one.symmetric {
            let [_, radius] = extremes(one.grid, |x| one.gather(&product(rho, x)));
            return Spectrum {
                radius: if radius < 0.0 { 0.0 } else { radius },
                condition: condition_of_inverse(one, rho),
            };
        }
        let root_rho: Vec<f64> = rho.iter().map(|r| r.sqrt()).collect();
        let bounce = |x: &[f64]| product(&root_rho, &one.times(&product(&root_rho, x)));
        let [lowest, radius] = extremes(one.grid, bounce);
        let condition = if radius < 1.0 {
            (1.0 - lowest) / (1.0 - radius)
        } else {
            let system = |x: &[f64]| difference(x, &bounce(x));
            let [smallest, largest] = extremes(one.grid, |x| system(&system(x)));
            (largest / smallest.max(0.0)).sqrt()
        };
        Spectrum { radius: if radius < 0.0 { 0.0 } else { radius }, condition }
    }
}

/// Ratio of the singular values of M = I − F ρ, by the eigenvalues of Mᵀ M.
fn condition_of_inverse<S: Scalar>(one: &OneBounce<S>, rho: &[f64]) -> f64 {
    let [smallest, largest] = extremes(one.grid, |x| {
        let y = difference(x, &one.gather(&product(rho, x)));
        difference(&y, &product(rho, &one.scatter(&y)))
    });
    (largest / smallest.max(0.0)).sqrt()
}

/// Smallest and largest real part of the eigenvalues of an operator.
fn extremes(grid: Grid, apply: impl Fn(&[f64]) -> Vec<f64>) -> [f64; 2] {
    let steps = grid.n.min(MAX_STEPS);
    // All positive, so that it cannot miss the eigenvector of the largest eigenvalue, which is positive too.
    let mut next: Vec<f64> =
        random_vector(grid, 0).iter().zip(0..).map(|(r, i)| if i < grid.n { 2.0 + r } else { 0.0 }).collect();
    let mut length = norm(&next);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut projected = Mat::<f64>::zeros(steps + 1, steps);
    let mut found = [f64::NAN; 2];
    for step in 0..steps {
        next.iter_mut().for_each(|v| *v /= length);
        basis.push(next);
        next = apply(&basis[step]);
        let before = norm(&next);
        // Twice is enough: the second pass removes what rounding left of the first.
        for _ in 0..2 {
            for (row, direction) in basis.iter().enumerate() {
                let part = dot(direction, &next);
                projected[(row, step)] += part;
                add_scaled(&mut next, -part, direction);
            }
        }
        length = norm(&next);
        projected[(step + 1, step)] = length;
        let exhausted = length <= 1e-14 * before;
        if exhausted || step + 1 == steps || (step + 1) % 8 == 0 {
            let [low, high] = real_parts(&projected, step + 1);
            let settled = (low - found[0]).abs().max((high - found[1]).abs()) <= 1e-13 * high.abs().max(low.abs());
            found = [low, high];
            if exhausted || settled {
                break;
            }
        }
    }
    found
}

/// Smallest and largest real part of the eigenvalues of the leading `n` × `n` block.
fn real_parts(matrix: &Mat<f64>, n: usize) -> [f64; 2] {
    let block = matrix.as_ref().submatrix(0, 0, n, n);
    if n == 1 {
        return [block[(0, 0)]; 2];
    }
    let (mut real, mut imaginary) = (vec![0.0; n], vec![0.0; n]);
    let no = ComputeEigenvectors::No;
    let mut memory = MemBuffer::new(evd_scratch::<f64>(n, no, no, Par::Seq, Spec::default()));
    let stack = MemStack::new(&mut memory);
    let (re, im) = (DiagMut::from_slice_mut(&mut real), DiagMut::from_slice_mut(&mut imaginary));
    match evd_real(block, re, im, None, None, Par::Seq, stack, Spec::default()) {
        Ok(()) => real.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], &v| [l.min(v), h.max(v)]),
        Err(_) => [f64::NAN; 2],
    }
}

fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}
