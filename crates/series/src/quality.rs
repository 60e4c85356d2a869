//! How right the solution is, measured on the solution itself.
//!
//! Furnace identity (docs/design.md §2): emitters of exitance 1 − ρ everywhere and a sky that replaces what is
//! lost light every patch with exactly 1, whatever the geometry:
//! Σ_j X_ij (1 − ρ_j) + A_i s_i = A_i, where s = (I − F ρ)⁻¹ (1 − F 1) is the sky's light after all bounces.
//! The sky's part is solved with the Cholesky factor, not with K, so the identity tests the one against the other.

use rayon::prelude::*;

use crate::{
    cholesky::solve_vector,
    one_bounce::OneBounce,
    spectrum::{dot, random_vector},
    tiles::Lower,
};

/// Random vectors that the residual is measured on.
const PROBES: u64 = 4;

/// A^{1/2} s, the sky's light after all bounces: u = A^{1/2} lost + W ρ u.
pub fn sky_light(one: &OneBounce, l: &Lower, root_rho: &[f64]) -> Vec<f64> {
    let mut inner: Vec<f64> = one.lost.iter().zip(root_rho).map(|(s, r)| s * r).collect();
    solve_vector(l, &mut inner);
    inner.iter_mut().zip(root_rho).for_each(|(v, r)| *v *= r);
    let reflected = one.w.times(&inner);
    one.lost.iter().zip(reflected).map(|(s, r)| s + r).collect()
}

/// ‖(I − W ρ) K − W‖ / ‖W‖ on random probes.
pub fn residual(one: &OneBounce, k: &Lower, rho: &[f64]) -> f64 {
    let (mut error, mut norm) = (0.0, 0.0);
    for probe in 1..=PROBES {
        let x = random_vector(k.grid, probe);
        let kx = k.times(&x);
        let wx = one.w.times(&x);
        let reflected: Vec<f64> = kx.iter().zip(rho).map(|(v, r)| v * r).collect();
        let again = one.w.times(&reflected);
        let difference: Vec<f64> = (0..x.len()).map(|i| kx[i] - again[i] - wx[i]).collect();
        error += dot(&difference, &difference);
        norm += dot(&wx, &wx);
    }
    if norm > 0.0 { (error / norm).sqrt() } else { 0.0 }
}

/// Largest and mean relative error of the furnace identity.
pub struct Furnace {
    pub max: f64,
    pub mean: f64,
}

impl Furnace {
    /// Of the solution in f64.
    pub fn of_solution(one: &OneBounce, k: &Lower, rho: &[f64], sky: &[f64]) -> Furnace {
        let emitted: Vec<f64> = one.root_area.iter().zip(rho).map(|(a, r)| a * (1.0 - r)).collect();
        Self::from_light(one, &k.times(&emitted), sky)
    }

    /// Of the stored values, n × n, row-major.
    pub fn of_stored(one: &OneBounce, values: &[f32], rho: &[f64], sky: &[f64]) -> Furnace {
        let emitted: Vec<f64> = one.root_area.iter().zip(rho).map(|(a, r)| a * (1.0 - r)).collect();
        let gather = |row: &[f32]| row.iter().zip(&emitted).map(|(&k, e)| f64::from(k) * e).sum();
        let light: Vec<f64> = values.par_chunks(one.w.grid.n).map(gather).collect();
        Self::from_light(one, &light, sky)
    }

    fn from_light(one: &OneBounce, light: &[f64], sky: &[f64]) -> Furnace {
        let n = one.w.grid.n;
        let error = |i: usize| ((light[i] + sky[i]) / one.root_area[i] - 1.0).abs();
        Furnace { max: (0..n).map(error).fold(0.0, f64::max), mean: (0..n).map(error).sum::<f64>() / n as f64 }
    }
}
