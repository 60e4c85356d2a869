//! What the methods have in common: what they return, what they cost, and who is asked.

use crate::{
    Method, Params, Precision, cholesky, conjugate,
    one_bounce::OneBounce,
    paper_inverse,
    scalar::Scalar,
    tiles::{Grid, Matrix},
    truncated,
};

/// K of one channel.
pub struct Solved {
    /// The operator, row = receiver.
    pub k: Box<dyn Matrix>,
    /// Steps that an iteration took.
    pub iterations: Option<u64>,
    /// Bytes of all matrices that were alive at the same time, K among them.
    pub peak_bytes: u64,
}

/// Why there is no K.
#[derive(Debug)]
pub enum Failure {
    /// I − R W R is not positive definite in this precision.
    NotPositive,
    /// The iteration did not get there.
    Stalled {
        /// Steps that were taken.
        steps: u64,
    },
}

/// Bytes of a matrix.
pub fn bytes<T>(values: &[T]) -> u64 {
    size_of_val(values) as u64
}

/// Solves for one channel in the precision that was asked for.
pub fn solve<S: Scalar>(
    one: &OneBounce<S>,
    rho: &[f64],
    params: &Params,
    tick: &(dyn Fn(u64) + Sync),
) -> Result<Solved, Failure> {
    match params.precision {
        Precision::F32 => solve_in::<S, f32>(one, rho, params, tick),
        Precision::F64 => solve_in::<S, f64>(one, rho, params, tick),
    }
}

fn solve_in<S: Scalar, T: Scalar>(
    one: &OneBounce<S>,
    rho: &[f64],
    params: &Params,
    tick: &(dyn Fn(u64) + Sync),
) -> Result<Solved, Failure> {
    let root_rho: Vec<f64> = rho.iter().map(|r| r.sqrt()).collect();
    // Params::check has seen to it that there is a number where one is needed.
    let bounces = params.bounces.unwrap_or(1);
    match params.method {
        Method::Cholesky => cholesky::solve::<S, T>(one, &root_rho, tick),
        Method::Doubling => Ok(truncated::doubling::<S, T>(one, &root_rho, bounces, tick)),
        Method::Neumann => Ok(truncated::neumann::<S, T>(one, &root_rho, bounces, tick)),
        Method::Cg => conjugate::solve::<S, T>(one, &root_rho, params.tolerance(), tick),
        Method::PaperInverse => Ok(paper_inverse::solve::<S, T>(one, rho, tick)),
    }
}

/// Units of progress of one channel.
pub fn work(grid: Grid, params: &Params) -> u64 {
    let bounces = params.bounces.unwrap_or(1);
    match params.method {
        Method::Cholesky => cholesky::work(grid),
        Method::Doubling => truncated::doubling_work(grid, bounces),
        Method::Neumann => truncated::neumann_work(grid, bounces),
        Method::Cg => conjugate::work(grid),
        Method::PaperInverse => paper_inverse::work(grid),
    }
}

/// Bytes that one channel takes: its matrices, and what the products of every thread pack, at most a panel each.
pub fn bytes_needed(grid: Grid, params: &Params) -> u64 {
    let panels = grid.count.min(rayon::current_num_threads());
    matrix_bytes(grid, params) + number_bytes(params) * (panels * grid.panel_size()) as u64
}

/// Bytes of the matrices of one channel, as [`Solved::peak_bytes`] will tell.
fn matrix_bytes(grid: Grid, params: &Params) -> u64 {
    let (half, full) = (grid.lower_size() as u64, grid.panels_size() as u64);
    let values = match params.method {
        Method::Cholesky => half + full,
        Method::Doubling => 2 * half + 2 * full,
        Method::Neumann => half + 2 * full,
        Method::Cg => half + full + conjugate::block_values(grid),
        Method::PaperInverse => 2 * full,
    };
    values * number_bytes(params)
}

fn number_bytes(params: &Params) -> u64 {
    match params.precision {
        Precision::F32 => 4,
        Precision::F64 => 8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_method_allocates_is_what_was_foreseen() {
        for n in [1, 30, 420] {
            let f = vec![0.5 / n as f64; n * n];
            for method in [Method::Cholesky, Method::Doubling, Method::Neumann, Method::Cg, Method::PaperInverse] {
                for precision in [Precision::F32, Precision::F64] {
                    let params =
                        Params { method, precision, bounces: method.truncates().then_some(3), tolerance: None };
                    let one = OneBounce::new(&f, |_| 1.0, n, method != Method::PaperInverse);
                    let solved = solve(&one, &one.grid.vector(|_| 0.5), &params, &|_| {}).expect("light fades");
                    assert_eq!(solved.peak_bytes, matrix_bytes(one.grid, &params), "{params:?}");
                }
            }
        }
    }
}
