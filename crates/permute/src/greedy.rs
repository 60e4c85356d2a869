//! The paper's order: each row is followed by the most similar one that is left.
//!
//! Rows of n values would make this O(n³). Distances are instead taken between projections of the rows on
//! the dominant subspace of the operator (32 dimensions), which keeps what matters of them and makes it
//! O(32 n²); up to 32 patches the projection loses nothing. The subspace comes from a random start with
//! a fixed seed and one power step.
//! Source: N. Halko, P. G. Martinsson, J. A. Tropp, Finding structure with randomness, SIAM Review 53(2),
//! 2011, algorithms 4.3 and 5.1.

use radfile::Operator;
use rayon::prelude::*;

use crate::neighbours::SplitMix;

/// Dimensions that rows are compared in.
const DIMENSIONS: usize = 32;

type Sketch = [f32; DIMENSIONS];

/// New order of the rows, as old indices.
pub fn nearest_neighbour(operator: &Operator) -> Vec<u32> {
    let n = operator.n;
    let sketches = sketch(operator);
    let norm = |i: usize| (0..operator.channels).map(|c| square_norm(&operator.channel(c)[i * n..][..n])).sum::<f64>();
    let norms: Vec<f64> = (0..n).into_par_iter().map(norm).collect();
    let Some(first) = (0..n).reduce(|best, i| if norms[i] > norms[best] { i } else { best }) else { return vec![] };

    let mut left: Vec<u32> = (0..n as u32).filter(|&i| i as usize != first).collect();
    let mut order = vec![first as u32];
    while !left.is_empty() {
        let last = &sketches[order[order.len() - 1] as usize];
        let mut nearest = (f32::INFINITY, u32::MAX, 0);
        for (at, &i) in left.iter().enumerate() {
            let candidate = (distance(last, &sketches[i as usize]), i, at);
            // `left` is not sorted after removals, so equals are decided by number.
            if candidate.0 < nearest.0 || candidate.0 == nearest.0 && i < nearest.1 {
                nearest = candidate;
            }
        }
        order.push(left.swap_remove(nearest.2));
    }
    order
}

/// Rows of the sum of all channels in coordinates of its dominant subspace.
fn sketch(operator: &Operator) -> Vec<Sketch> {
    let mut random = SplitMix(0x5EED);
    let mut basis: Vec<Sketch> =
        (0..operator.n).map(|_| std::array::from_fn(|_| (random.next() * 2.0 - 1.0) as f32)).collect();
    for _ in 0..2 {
        basis = project(operator, &basis);
        orthonormalise(&mut basis);
    }
    project(operator, &basis)
}

/// (Σ_c K_c) times n × 32.
fn project(operator: &Operator, basis: &[Sketch]) -> Vec<Sketch> {
    let n = operator.n;
    let row = |i: usize| {
        let mut sum = [0.0; DIMENSIONS];
        for channel in 0..operator.channels {
            for (&k, b) in operator.channel(channel)[i * n..][..n].iter().zip(basis) {
                for d in 0..DIMENSIONS {
                    sum[d] += k * b[d];
                }
            }
        }
        sum
    };
    (0..n).into_par_iter().map(row).collect()
}

/// Modified Gram-Schmidt over the columns, twice; columns without anything new become zero.
fn orthonormalise(basis: &mut [Sketch]) {
    let product = |basis: &[Sketch], a: usize, b: usize| -> f64 {
        basis.iter().map(|row| f64::from(row[a]) * f64::from(row[b])).sum()
    };
    for column in 0..DIMENSIONS {
        let original = product(basis, column, column);
        for earlier in (0..column).chain(0..column) {
            let share = product(basis, earlier, column);
            basis.iter_mut().for_each(|row| row[column] -= (share * f64::from(row[earlier])) as f32);
        }
        let rest = product(basis, column, column);
        // What is left of a dependent column is rounding of f32.
        let scale = if rest > 1e-10 * original { 1.0 / rest.sqrt() } else { 0.0 };
        basis.iter_mut().for_each(|row| row[column] = (f64::from(row[column]) * scale) as f32);
    }
}

/// Squared distance, in eight partial sums that a compiler can keep in one register.
fn distance(a: &Sketch, b: &Sketch) -> f32 {
    let mut sums = [0.0_f32; 8];
    for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
        for lane in 0..8 {
            let d = a[lane] - b[lane];
            sums[lane] += d * d;
        }
    }
    sums.iter().sum()
}

fn square_norm(row: &[f32]) -> f64 {
    row.iter().map(|&v| f64::from(v).powi(2)).sum()
}
