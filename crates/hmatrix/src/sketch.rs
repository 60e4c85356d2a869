//! Singular triples of a block by a randomised sketch.
//!
//! Q spans the block's image of a few random vectors; the triples of Qᵀ B are those of B as far as Q reaches. What
//! they leave is known exactly, not estimated: ‖B‖² − Σ σ², as Q is orthonormal (Halko, Martinsson, Tropp 2011).

use std::collections::BTreeSet;

use crate::small::{dot, eigen, orthonormalise};

/// Random vectors beyond the wanted rank.
const OVERSAMPLING: usize = 6;
/// Squares of singular values below this share of the largest are rounding.
const ROUNDING: f64 = 1e-12;

/// A row-major matrix.
#[derive(Clone, Copy)]
pub struct Dense<'a> {
    pub values: &'a [f64],
    pub rows: usize,
    pub columns: usize,
}

impl<'a> Dense<'a> {
    pub fn row(&self, i: usize) -> &'a [f64] {
        &self.values[i * self.columns..][..self.columns]
    }
}

/// One of the terms σ u vᵀ that a block is the sum of; `u` and `v` have unit length.
pub struct Triple {
    /// Negative for negative eigenvalues of symmetric blocks.
    pub sigma: f64,
    pub u: Vec<f32>,
    /// Empty for symmetric blocks, where it is `u`.
    pub v: Vec<f32>,
}

/// Up to `rank` triples, largest first; the same for the same seed.
pub fn triples(block: Dense, rank: usize, seed: u64) -> Vec<Triple> {
    let (m, k) = (block.rows, block.columns);
    let p = (rank + OVERSAMPLING).min(m).min(k);
    let q = if p == m { identity(m) } else { range(block, p, seed) };
    let mut c = vec![vec![0.0; k]; p];
    for i in 0..m {
        for (c, q) in c.iter_mut().zip(&q) {
            c.iter_mut().zip(block.row(i)).for_each(|(c, &v)| *c += q[i] * v);
        }
    }
    let gram = (0..p).map(|a| (0..p).map(|b| dot(&c[a], &c[b])).collect()).collect();
    let pairs = eigen(gram);
    let largest = pairs.first().map_or(0.0, |pair| pair.0);
    let kept = pairs.into_iter().take(rank).take_while(|pair| pair.0 > ROUNDING * largest && pair.0 > 0.0);
    kept.map(|(square, vector)| {
        let sigma = square.sqrt();
        let combine = |basis: &[Vec<f64>], at: usize| basis.iter().zip(&vector).map(|(b, w)| b[at] * w).sum::<f64>();
        let u = (0..m).map(|i| combine(&q, i) as f32).collect();
        let v = (0..k).map(|j| (combine(&c, j) / sigma) as f32).collect();
        Triple { sigma, u, v }
    })
    .collect()
}

/// Up to `rank` eigenpairs of a small symmetric block.
pub fn symmetric_triples(block: Dense, rank: usize) -> Vec<Triple> {
    let columns = (0..block.rows).map(|i| block.row(i).to_vec()).collect();
    let pairs = eigen(columns).into_iter().take(rank).filter(|pair| pair.0 != 0.0);
    pairs.map(|(sigma, u)| Triple { sigma, u: u.into_iter().map(|x| x as f32).collect(), v: Vec::new() }).collect()
}

/// Up to `rank` triples of a block whose rows and columns are of several groups, each triple exactly 0 outside of one of
/// them: entries between groups are 0, and stay it in any code.
pub fn apart(
    block: Dense,
    groups: [&[u32]; 2],
    rank: usize,
    approximate: impl Fn(Dense) -> Vec<Triple>,
) -> Vec<Triple> {
    let all: BTreeSet<u32> = groups[0].iter().copied().collect();
    let mut found = Vec::new();
    for group in all {
        let places = |side: usize| -> Vec<usize> {
            groups[side].iter().enumerate().filter(|(_, g)| **g == group).map(|(at, _)| at).collect()
        };
        let (rows, columns) = (places(0), places(1));
        let values: Vec<f64> = rows.iter().flat_map(|&i| columns.iter().map(move |&j| block.row(i)[j])).collect();
        if values.iter().all(|v| *v == 0.0) {
            continue;
        }
        let spread = |part: &[f32], places: &[usize], len: usize| {
            let mut whole = vec![0.0; len];
            places.iter().zip(part).for_each(|(&at, &x)| whole[at] = x);
            whole
        };
        let own = approximate(Dense { values: &values, rows: rows.len(), columns: columns.len() });
        found.extend(own.into_iter().map(|t| Triple {
            sigma: t.sigma,
            u: spread(&t.u, &rows, block.rows),
            v: if t.v.is_empty() { t.v } else { spread(&t.v, &columns, block.columns) },
        }));
    }
    found.sort_by(|a, b| b.sigma.abs().total_cmp(&a.sigma.abs()));
    found.truncate(rank);
    found
}

fn identity(m: usize) -> Vec<Vec<f64>> {
    (0..m).map(|c| (0..m).map(|i| f64::from(u8::from(i == c))).collect()).collect()
}

/// An orthonormal basis of B Ω.
fn range(block: Dense, p: usize, seed: u64) -> Vec<Vec<f64>> {
    let omega: Vec<Vec<f64>> = (0..p).map(|c| (0..block.columns).map(|j| random(seed, j, c)).collect()).collect();
    let mut image = vec![vec![0.0; block.rows]; p];
    for i in 0..block.rows {
        image.iter_mut().zip(&omega).for_each(|(image, omega)| image[i] = lanes_dot(block.row(i), omega));
    }
    orthonormalise(&mut image);
    image
}

/// [`dot`] in eight partial sums, several times as fast.
fn lanes_dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    for (a, b) in a.iter().zip(b) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + dot(a_rest, b_rest)
}

/// Uniform in ±½, by SplitMix64 of seed and place.
pub fn random(seed: u64, row: usize, column: usize) -> f64 {
    let mut x = seed.wrapping_mul(0xd134_2543_de82_ef95) ^ ((row as u64) << 32 | column as u64);
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^= x >> 31;
    (x >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}
