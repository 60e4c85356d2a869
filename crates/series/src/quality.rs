//! How right a solution is, measured on the solution itself, in f64, against the form factors themselves.
//!
//! Furnace identity, docs/theory.md (7.2): emitters of exitance 1 − ρ everywhere, and a sky that sends in what the
//! patches lose to it, s = 1 − F 1, light every patch with exactly 1, whatever the geometry:
//! A^{1/2} s + K A^{1/2} (1 − ρ + ρ s) = A^{1/2}.

use rayon::prelude::*;

use crate::{
    one_bounce::OneBounce,
    scalar::{Scalar, dot},
    spectrum::random_vector,
    tiles::{Grid, Matrix},
};

/// Random vectors that the residual is measured on.
const PROBES: u64 = 4;

/// ‖(I − W ρ) K − W‖ / ‖W‖ on random probes.
pub fn residual<S: Scalar>(one: &OneBounce<S>, k: &dyn Matrix, rho: &[f64]) -> f64 {
    let (mut error, mut norm) = (0.0, 0.0);
    for probe in 1..=PROBES {
        let x = random_vector(one.grid, probe);
        let kx = k.times(&x);
        let wx = one.times(&x);
        let reflected: Vec<f64> = kx.iter().zip(rho).map(|(v, r)| v * r).collect();
        let again = one.times(&reflected);
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
    /// Of an operator that is given by its product with a vector.
    pub fn of<S: Scalar>(one: &OneBounce<S>, rho: &[f64], times: impl Fn(&[f64]) -> Vec<f64>) -> Furnace {
        let leaves = |i: usize| one.root_area[i] * (1.0 - rho[i]) + one.lost[i] * rho[i];
        let light = times(&one.grid.vector(leaves));
        let n = one.grid.n;
        let error = |i: usize| ((one.lost[i] + light[i]) / one.root_area[i] - 1.0).abs();
        let errors = || (0..n).map(error);
        // Not a number is the largest of all errors.
        let max = errors().fold(0.0, |max: f64, e| if e.is_nan() || e > max { e } else { max });
        Furnace { max, mean: errors().sum::<f64>() / n as f64 }
    }
}

/// What no operator of a scene has: negative values and two directions that differ.
#[derive(Clone, Copy, Default)]
pub struct Blemishes {
    /// Values below 0.
    pub negative: u64,
    /// The lowest of them.
    pub lowest: f64,
    /// Largest |K_ij − K_ji|.
    pub difference: f64,
    /// Largest |K_ij|.
    pub largest: f64,
}

impl Blemishes {
    /// Looks at every value.
    pub fn of(k: &dyn Matrix, grid: Grid) -> Blemishes {
        let tile = |(ti, tj): (usize, usize)| {
            let mut found = Blemishes::default();
            for i in ti * grid.edge..grid.n.min((ti + 1) * grid.edge) {
                for j in tj * grid.edge..grid.n.min((tj + 1) * grid.edge).min(i + 1) {
                    found = found.and(Self::of_pair(k.at(i, j), k.at(j, i), i == j));
                }
            }
            found
        };
        grid.lower().into_par_iter().map(tile).reduce(Blemishes::default, Blemishes::and)
    }

    fn of_pair(a: f64, b: f64, same: bool) -> Blemishes {
        Blemishes {
            negative: u64::from(a < 0.0) + u64::from(!same && b < 0.0),
            lowest: a.min(b).min(0.0),
            difference: (a - b).abs(),
            largest: a.abs().max(b.abs()),
        }
    }

    fn and(self, other: Blemishes) -> Blemishes {
        Blemishes {
            negative: self.negative + other.negative,
            lowest: self.lowest.min(other.lowest),
            difference: self.difference.max(other.difference),
            largest: self.largest.max(other.largest),
        }
    }
}
