//! The first k bounces, by doubling.
//!
//! With P_a = (W ρ)^{a−1} W, the light of bounce a alone, and K_a = P_1 + … + P_a:
//! K_{a+b} = K_a + P_a ρ K_b and P_{a+b} = P_a ρ P_b. All of them are symmetric, so with R = ρ^{1/2}
//! every product is (R P)ᵀ (R K) of symmetric matrices, half of which is computed. The binary digits
//! of k, highest first, say when to double (a, a) and when to add one bounce (1, a).

use faer::Accum;

use crate::tiles::{Lower, Panels};

/// Memory that a truncated sum needs besides the solver's.
pub struct Scratch {
    power: Lower,
    other: Panels,
}

impl Scratch {
    /// For matrices cut as `w`.
    pub fn new(w: &Lower) -> Scratch {
        Scratch { power: Lower::zeros(w.grid), other: Panels::zeros(w.grid) }
    }
}

/// Products of two matrices that `first_bounces` takes.
pub fn product_count(bounces: u32) -> u64 {
    let doublings = u64::from(bounces.ilog2());
    let ones = u64::from(bounces.count_ones()) - 1;
    // The sum takes one product a doubling and one an addition; the power does not need the last of them.
    let unused = if bounces > 1 { 1 + u64::from(bounces & 1) } else { 0 };
    2 * (doublings + ones) - unused
}

/// `sum` ← K_k for k = `bounces` ≥ 1.
pub fn first_bounces(
    w: &Lower,
    root_rho: &[f64],
    bounces: u32,
    sum: &mut Lower,
    left: &mut Panels,
    scratch: &mut Scratch,
    tick: &(dyn Fn(u64) + Sync),
) {
    let Scratch { power, other } = scratch;
    sum.values.copy_from_slice(&w.values);
    power.values.copy_from_slice(&w.values);
    for bit in (0..bounces.ilog2()).rev() {
        let odd = bounces >> bit & 1 == 1;
        let more = bit > 0;
        left.fill_scaled(power, root_rho);
        other.fill_scaled(sum, root_rho);
        sum.accumulate_product(Accum::Add, left, other, tick);
        if more {
            power.accumulate_product(Accum::Replace, left, left, tick);
        }
        if odd {
            left.fill_scaled(w, root_rho);
            other.fill_scaled(sum, root_rho);
            sum.values.copy_from_slice(&w.values);
            sum.accumulate_product(Accum::Add, left, other, tick);
            if more {
                other.fill_scaled(power, root_rho);
                power.accumulate_product(Accum::Replace, left, other, tick);
            }
        }
    }
}
