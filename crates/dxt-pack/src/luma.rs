//! What the channels of an operator have in common, and what colour is left.

use radfile::{Operator, luma};
use rayon::prelude::*;

use crate::small::eigen;

/// A plane with less than this share of the square of luma is rounding.
const ROUNDING: f64 = 1e-13;

/// K_Y as an operator of one channel. Grey operators are their own.
pub fn of_operator<'a>(operator: &'a Operator) -> Operator<'a> {
    let n = operator.n;
    let values = if operator.channels == 1 {
        operator.values[..].into()
    } else {
        let mut values = vec![0.0; n * n];
        values.par_chunks_mut(n).enumerate().for_each(|(row, values)| {
            values.iter_mut().enumerate().for_each(|(column, value)| *value = luma(operator.entry(row, column)));
        });
        values.into()
    };
    Operator { n, channels: 1, bounces: operator.bounces, values }
}

/// Shares of up to two planes in red, green and blue: the principal axes of Δ_c = K_c − K_Y. Since luma of Δ is 0, two
/// planes hold all of it, and the first as much as one can. Grey operators have none.
pub fn axes(operator: &Operator) -> Vec<[f32; 3]> {
    if operator.channels == 1 {
        return Vec::new();
    }
    let of_row = |row: usize| {
        let mut sums = [0.0; 10];
        for column in 0..operator.n {
            let k = operator.entry(row, column);
            let y = luma(k);
            let d = k.map(|k| f64::from(k - y));
            (0..9).for_each(|at| sums[at] += d[at / 3] * d[at % 3]);
            sums[9] += f64::from(y).powi(2);
        }
        sums
    };
    let rows: Vec<[f64; 10]> = (0..operator.n).into_par_iter().map(of_row).collect();
    let sum = |at: usize| rows.iter().map(|row| row[at]).sum::<f64>();
    let (values, vectors) = eigen((0..9).map(sum).collect(), 3);
    let least = ROUNDING * sum(9);
    (0..2).filter(|&p| values[p] > least).map(|p| [0, 1, 2].map(|c| vectors[3 * c + p] as f32)).collect()
}
