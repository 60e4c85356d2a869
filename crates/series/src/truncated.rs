//! The first k bounces, by doubling or one by one: docs/theory.md (6.1).
//!
//! With P_a = (W ρ)^{a−1} W, the light of bounce a alone, and K_a = P_1 + … + P_a:
//! K_{a+b} = K_a + P_a ρ K_b and P_{a+b} = P_a ρ P_b. All of them are symmetric, so with R = ρ^{1/2}
//! every product is (R P)ᵀ (R K) of symmetric matrices, half of which is computed. For doubling the binary digits
//! of k, highest first, say when to double (a, a) and when to add one bounce (1, a). Adding one bounce at a time,
//! K_{1+a} = W + W ρ K_a, is the gather of classical radiosity (M. F. Cohen, D. P. Greenberg, SIGGRAPH 1985),
//! for all emitters at once.

use faer::Accum;

use crate::{
    methods::{Solved, bytes},
    one_bounce::OneBounce,
    scalar::Scalar,
    tiles::{Grid, Lower, Panels},
};

/// Products of two tiles in one product of matrices.
fn product_work(grid: Grid) -> u64 {
    let t = grid.count as u64;
    t * t * (t + 1) / 2
}

/// Products of two tiles that [`doubling`] takes.
pub fn doubling_work(grid: Grid, bounces: u32) -> u64 {
    let doublings = u64::from(bounces.ilog2());
    let ones = u64::from(bounces.count_ones()) - 1;
    // The sum takes one product a doubling and one an addition; the power does not need the last of them.
    let unused = if bounces > 1 { 1 + u64::from(bounces & 1) } else { 0 };
    (2 * (doublings + ones) - unused) * product_work(grid)
}

/// Products of two tiles that [`neumann`] takes.
pub fn neumann_work(grid: Grid, bounces: u32) -> u64 {
    u64::from(bounces - 1) * product_work(grid)
}

/// K_k for k = `bounces` ≥ 1 in ⌈log₂ k⌉ steps.
pub fn doubling<S: Scalar, T: Scalar>(
    one: &OneBounce<S>,
    root_rho: &[f64],
    bounces: u32,
    tick: &(dyn Fn(u64) + Sync),
) -> Solved {
    let grid = one.grid;
    let (mut sum, mut power) = (Lower::<T>::zeros(grid), Lower::<T>::zeros(grid));
    let (mut left, mut other) = (Panels::<T>::zeros(grid), Panels::<T>::zeros(grid));
    sum.fill(|i, j| one.w(i, j));
    power.values.copy_from_slice(&sum.values);
    for bit in (0..bounces.ilog2()).rev() {
        let odd = bounces >> bit & 1 == 1;
        let more = bit > 0;
        left.fill_scaled(&power, root_rho);
        other.fill_scaled(&sum, root_rho);
        sum.accumulate_product(Accum::Add, &left, &other, tick);
        if more {
            power.accumulate_product(Accum::Replace, &left, &left, tick);
        }
        if odd {
            left.fill(|i, j| root_rho[i] * one.w(i, j));
            one_more(one, root_rho, &mut sum, &left, &mut other, tick);
            if more {
                other.fill_scaled(&power, root_rho);
                power.accumulate_product(Accum::Replace, &left, &other, tick);
            }
        }
    }
    let peak_bytes = bytes(&sum.values) + bytes(&power.values) + bytes(&left.values) + bytes(&other.values);
    Solved { k: Box::new(sum), iterations: None, peak_bytes }
}

/// K_k for k = `bounces` ≥ 1 in k − 1 steps.
pub fn neumann<S: Scalar, T: Scalar>(
    one: &OneBounce<S>,
    root_rho: &[f64],
    bounces: u32,
    tick: &(dyn Fn(u64) + Sync),
) -> Solved {
    let grid = one.grid;
    let mut sum = Lower::<T>::zeros(grid);
    let (mut left, mut other) = (Panels::<T>::zeros(grid), Panels::<T>::zeros(grid));
    sum.fill(|i, j| one.w(i, j));
    left.fill(|i, j| root_rho[i] * one.w(i, j));
    for _ in 1..bounces {
        one_more(one, root_rho, &mut sum, &left, &mut other, tick);
    }
    let peak_bytes = bytes(&sum.values) + bytes(&left.values) + bytes(&other.values);
    Solved { k: Box::new(sum), iterations: Some(u64::from(bounces - 1)), peak_bytes }
}

/// `sum` ← W + W ρ `sum`, where `left` is R W; `other` is scratch.
fn one_more<S: Scalar, T: Scalar>(
    one: &OneBounce<S>,
    root_rho: &[f64],
    sum: &mut Lower<T>,
    left: &Panels<T>,
    other: &mut Panels<T>,
    tick: &(dyn Fn(u64) + Sync),
) {
    other.fill_scaled(sum, root_rho);
    sum.fill(|i, j| one.w(i, j));
    sum.accumulate_product(Accum::Add, left, other, tick);
}
