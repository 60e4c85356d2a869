//! Physical rooms without geometry: random exchange with given areas.
#![allow(dead_code)] // every test file uses its own part

use radfile::{FormFactors, Operator, Patches, Quiet};
use series::{Method, Params, Precision, Report, all_bounces};

/// Patches that have what this stage reads: areas and reflectances.
pub fn patches(area: Vec<f32>, reflectance: Vec<[f32; 3]>) -> Patches {
    Patches { area, reflectance, ..Patches::default() }
}

/// Numbers in 0 … 1 from a seed.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64
    }
}

/// A room of `n` patches whose areas differ by up to a hundred times. About half of the pairs see
/// each other; patch i sees the sky with `sky` of its view. Exchange areas A_i F_ij are symmetric and
/// balanced to the areas (Sinkhorn iteration, symmetric).
pub fn room(n: usize, sky: f64, seed: u64) -> (Vec<f32>, FormFactors<'static>) {
    let mut random = Random(seed);
    let area: Vec<f64> = (0..n).map(|_| f64::from(10f64.powf(2.0 * random.next() - 1.0) as f32)).collect();
    let mut exchange = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..i {
            let seen = if random.next() < 0.5 || i - j == 1 { random.next() + 0.01 } else { 0.0 };
            exchange[i * n + j] = seen * area[i] * area[j];
            exchange[j * n + i] = exchange[i * n + j];
        }
        exchange[i * n + i] = 0.01 * area[i] * area[i];
    }
    for _ in 0..200 {
        let scale: Vec<f64> =
            (0..n).map(|i| (area[i] * (1.0 - sky) / exchange[i * n..][..n].iter().sum::<f64>()).sqrt()).collect();
        for i in 0..n {
            for j in 0..n {
                exchange[i * n + j] *= scale[i] * scale[j];
            }
        }
    }
    let values: Vec<f32> = (0..n * n).map(|at| (exchange[at] / area[at / n]) as f32).collect();
    let factors = FormFactors { values: values.into(), sky: vec![sky as f32; n].into() };
    (area.iter().map(|&a| a as f32).collect(), factors)
}

/// Reflectances in 0 … 0.95, different in every channel.
pub fn colours(n: usize, seed: u64) -> Vec<[f32; 3]> {
    let mut random = Random(seed);
    (0..n).map(|_| std::array::from_fn(|_| 0.95 * random.next() as f32)).collect()
}

pub fn solve(patches: &Patches, factors: &FormFactors, bounces: Option<u32>) -> (Operator<'static>, Report) {
    all_bounces(patches, factors, &params(bounces), &Quiet).expect("a physical room")
}

/// All bounces, or the first by doubling.
pub fn params(bounces: Option<u32>) -> Params {
    bounces.map_or_else(Params::default, Params::first_bounces)
}

/// Every method in both precisions; those that truncate sum the first `bounces`.
pub fn every_way(bounces: u32) -> Vec<Params> {
    let methods = [Method::Cholesky, Method::Doubling, Method::Neumann, Method::Cg, Method::PaperInverse];
    let truncates = |method| matches!(method, Method::Doubling | Method::Neumann);
    let params = |method, precision| Params {
        method,
        precision,
        bounces: truncates(method).then_some(bounces),
        ..Params::default()
    };
    methods.into_iter().flat_map(|m| [Precision::F64, Precision::F32].map(|p| params(m, p))).collect()
}

/// A^{-1/2} (Σ_{b<bounces} (F ρ)^b F)… by the definition, in f64: X_ij / √(A_i A_j).
pub fn naive(area: &[f32], rho: &[f64], factors: &FormFactors, bounces: usize) -> Vec<f64> {
    let n = area.len();
    let root = |i: usize| f64::from(area[i]).sqrt();
    let w: Vec<f64> = (0..n * n)
        .map(|at| {
            let (i, j) = (at / n, at % n);
            let one = |i: usize, j: usize| root(i) * f64::from(factors.values[i * n + j]) / root(j);
            0.5 * (one(i, j) + one(j, i))
        })
        .collect();
    let mut sum = w.clone();
    for _ in 1..bounces {
        let mut next = w.clone();
        for i in 0..n {
            for k in 0..n {
                let back = w[i * n + k] * rho[k];
                for j in 0..n {
                    next[i * n + j] += back * sum[k * n + j];
                }
            }
        }
        sum = next;
    }
    sum
}

/// Largest difference relative to the largest value.
pub fn difference(found: &[f32], expected: &[f64]) -> f64 {
    let largest = expected.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    found.iter().zip(expected).map(|(&f, e)| (f64::from(f) - e).abs()).fold(0.0, f64::max) / largest
}
