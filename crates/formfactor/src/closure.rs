//! Scales a symmetric matrix so that its rows have given sums: docs/theory.md (9.3), (9.4), (9.5).
//!
//! Wanted are d_i > 0 with d_i Σ_j E_ij d_j = r_i. With d = e^x they are where the convex function
//!
//!   φ(x) = ½ Σ_ij E_ij e^(x_i + x_j) − Σ_i r_i x_i + Σ_i r_i ψ(x_i)
//!
//! is least, ψ left out. Its gradient is m − r with the row sums m, its Hessian diag(m) + D E D, which
//! is positive semidefinite. Newton's method finds the place in a few steps, each solved by
//! conjugate gradients; products with E are all that is needed.
//!
//! Not every matrix can be scaled: where patches see only each other, across and never along, the sums
//! of both sides must agree, and measured ones do not quite. ψ makes the answer unique then: its slope
//! ε sinh(βx)/β is nothing for moderate x and steep beyond a factor of about e, so that what cannot be
//! met is spread evenly over the rows concerned instead of blowing up single factors.
//!
//! Source: P. A. Knight, D. Ruiz, A fast algorithm for matrix balancing, IMA J. Numer. Anal. 33, 2013
//! (Newton's method with conjugate gradients for this problem); ψ is ours.

use rayon::prelude::*;

/// Factors and how they were found.
pub struct Scaling {
    /// d; 0 where the wanted sum is 0.
    pub factor: Vec<f64>,
    /// Newton steps.
    pub iterations: u32,
    /// Whether the relative gradient came below [`TOLERANCE`].
    pub converged: bool,
}

const TOLERANCE: f64 = 1e-9;
const NEWTON_STEPS: u32 = 40;
const GRADIENT_STEPS: usize = 100;
/// ε and β of ψ.
const SOFTNESS: f64 = 1e-10;
const STEEPNESS: f64 = 16.0;

/// Finds the factors for the symmetric, non-negative `matrix` and the row sums `wanted` ≥ 0.
pub fn scale_to_row_sums(matrix: &[f32], wanted: &[f64]) -> Scaling {
    let problem = Problem { matrix, wanted };
    let mut state = problem.at(vec![0.0; wanted.len()]);
    let mut iterations = 0;
    while iterations < NEWTON_STEPS {
        let error = problem.error(&state);
        if error <= TOLERANCE {
            return Scaling { factor: state.factor, iterations, converged: true };
        }
        iterations += 1;
        let step = problem.newton_step(&state, error.min(0.1));
        match problem.line_search(&state, &step) {
            Some(next) => state = next,
            None => break,
        }
    }
    let converged = problem.error(&state) <= TOLERANCE;
    Scaling { factor: state.factor, iterations, converged }
}

/// d ∘ (E d): the row sums of the scaled matrix.
pub fn row_sums(matrix: &[f32], factor: &[f64]) -> Vec<f64> {
    let mut sums = product(matrix, factor);
    sums.iter_mut().zip(factor).for_each(|(s, d)| *s *= d);
    sums
}

struct Problem<'a> {
    matrix: &'a [f32],
    wanted: &'a [f64],
}

struct State {
    x: Vec<f64>,
    factor: Vec<f64>,
    sums: Vec<f64>,
    gradient: Vec<f64>,
    value: f64,
}

impl Problem<'_> {
    fn at(&self, x: Vec<f64>) -> State {
        let factor: Vec<f64> = x.iter().zip(self.wanted).map(|(x, &r)| if r > 0.0 { x.exp() } else { 0.0 }).collect();
        let sums = row_sums(self.matrix, &factor);
        let mut value = 0.0;
        let mut gradient = Vec::with_capacity(x.len());
        for ((&x, &m), &r) in x.iter().zip(&sums).zip(self.wanted) {
            let psi = SOFTNESS * (STEEPNESS * x).cosh() / (STEEPNESS * STEEPNESS);
            let slope = SOFTNESS * (STEEPNESS * x).sinh() / STEEPNESS;
            value += 0.5 * m - r * x + r * psi;
            gradient.push(m - r + r * slope);
        }
        State { x, factor, sums, gradient, value }
    }

    /// The largest gradient relative to the wanted row sum.
    fn error(&self, state: &State) -> f64 {
        let relative = |(g, &r): (&f64, &f64)| if r > 0.0 { (g / r).abs() } else { 0.0 };
        state.gradient.iter().zip(self.wanted).map(relative).fold(0.0, f64::max)
    }

    /// Solves Hessian · p = −gradient to a relative residual by preconditioned conjugate gradients.
    fn newton_step(&self, state: &State, tolerance: f64) -> Vec<f64> {
        let curvature = |(&x, &r): (&f64, &f64)| r * SOFTNESS * (STEEPNESS * x).cosh();
        let bend = state.x.iter().zip(self.wanted).map(curvature);
        let diagonal: Vec<f64> = state.sums.iter().zip(bend).map(|(m, b)| m + b).collect();
        let condition = |residual: &[f64]| -> Vec<f64> {
            residual.iter().zip(&diagonal).map(|(r, d)| if *d > 0.0 { r / d } else { 0.0 }).collect()
        };
        let mut p = vec![0.0; diagonal.len()];
        let mut residual: Vec<f64> = state.gradient.iter().map(|g| -g).collect();
        let mut conditioned = condition(&residual);
        let mut direction = conditioned.clone();
        let mut energy = dot(&residual, &conditioned);
        let enough = tolerance * tolerance * energy;
        for _ in 0..GRADIENT_STEPS {
            if energy <= enough {
                break;
            }
            let scaled: Vec<f64> = direction.iter().zip(&state.factor).map(|(v, d)| v * d).collect();
            let mut image = product(self.matrix, &scaled);
            for (i, h) in image.iter_mut().enumerate() {
                *h = *h * state.factor[i] + diagonal[i] * direction[i];
            }
            let length = energy / dot(&direction, &image).max(f64::MIN_POSITIVE);
            add(&mut p, length, &direction);
            add(&mut residual, -length, &image);
            conditioned = condition(&residual);
            let next = dot(&residual, &conditioned);
            let keep = next / energy;
            direction.iter_mut().zip(&conditioned).for_each(|(v, c)| *v = c + keep * *v);
            energy = next;
        }
        p
    }

    /// Goes along `step`, by at most 1 in any x, and shortens it until φ has come down enough.
    fn line_search(&self, state: &State, step: &[f64]) -> Option<State> {
        let longest = step.iter().fold(0.0f64, |m, s| m.max(s.abs()));
        if !longest.is_finite() {
            return None;
        }
        let slope = dot(&state.gradient, step);
        let mut length = if longest > 1.0 { 1.0 / longest } else { 1.0 };
        let rounding = 1e-13 * state.value.abs();
        for _ in 0..40 {
            let mut x = state.x.clone();
            add(&mut x, length, step);
            let next = self.at(x);
            if next.value <= state.value + 1e-4 * length * slope + rounding {
                return Some(next);
            }
            length *= 0.5;
        }
        None
    }
}

/// E v. Every row is summed in a fixed order, so the number of threads changes nothing.
fn product(matrix: &[f32], v: &[f64]) -> Vec<f64> {
    let n = v.len();
    matrix.par_chunks_exact(n).map(|row| row_dot(row, v)).collect()
}

/// Sum of products in eight lanes, which the compiler turns into vector instructions.
fn row_dot(row: &[f32], v: &[f64]) -> f64 {
    let (row_blocks, row_rest) = row.as_chunks::<8>();
    let (v_blocks, v_rest) = v.as_chunks::<8>();
    let mut lanes = [0.0; 8];
    for (row, v) in row_blocks.iter().zip(v_blocks) {
        lanes = std::array::from_fn(|k| lanes[k] + f64::from(row[k]) * v[k]);
    }
    let rest: f64 = row_rest.iter().zip(v_rest).map(|(a, b)| f64::from(*a) * b).sum();
    lanes.iter().sum::<f64>() + rest
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn add(to: &mut [f64], factor: f64, what: &[f64]) {
    to.iter_mut().zip(what).for_each(|(t, w)| *t += factor * w);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Symmetric, about a third of it zero, without a diagonal.
    fn sparse(n: usize) -> Vec<f32> {
        let value = |i: usize, j: usize| {
            let bits = scene::hash(i.min(j) as u32, i.max(j) as u32);
            if i == j || bits.is_multiple_of(3) { 0.0 } else { (bits >> 8) as f32 * 1e-7 }
        };
        (0..n * n).map(|at| value(at / n, at % n)).collect()
    }

    #[test]
    fn sums_that_can_be_met_are_met() {
        let n = 60;
        let matrix = sparse(n);
        let truth: Vec<f64> = (0..n).map(|i| 0.7 + 0.7 * i as f64 / n as f64).collect();
        let mut wanted = row_sums(&matrix, &truth);
        wanted[7] = 0.0;
        let scaling = scale_to_row_sums(&matrix, &wanted);
        assert!(scaling.converged && scaling.iterations < 10, "{} steps", scaling.iterations);
        let sums = row_sums(&matrix, &scaling.factor);
        assert_eq!((scaling.factor[7], sums[7]), (0.0, 0.0), "who sees nothing exchanges nothing");
        for i in (0..n).filter(|&i| i != 7) {
            assert!((sums[i] / wanted[i] - 1.0).abs() < 1e-7, "row {i}: {} of {}", sums[i], wanted[i]);
        }
    }

    /// Three patches on either side that see only across: the sides want 1 % more and less than their mean.
    #[test]
    fn sums_that_cannot_be_met_are_missed_evenly() {
        let n = 6;
        let matrix: Vec<f32> = (0..n * n).map(|at| if (at / n < 3) == (at % n < 3) { 0.0 } else { 1.0 }).collect();
        let wanted: Vec<f64> = (0..n).map(|i| if i < 3 { 3.03 } else { 2.97 }).collect();
        let scaling = scale_to_row_sums(&matrix, &wanted);
        assert!(scaling.converged);
        for sum in row_sums(&matrix, &scaling.factor) {
            // All rows miss by 1 %, to a hundredth of that.
            assert!((sum - 3.03 * 0.99).abs() < 3e-4, "a row sums to {sum}");
        }
    }
}
