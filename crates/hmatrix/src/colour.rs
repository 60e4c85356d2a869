//! The channels as luma and up to two planes of colour.
//!
//! What luma K_Y = Σ w_c K_c leaves of the channels, Δ_c = K_c − K_Y, is orthogonal to w, so two symmetric planes
//! hold it: Δ_c = e_1c P_1 + e_2c P_2. The e are the principal axes of the Δ, so P_1 holds as much as one
//! plane can and P_2 costs next to nothing in most scenes. The first bounce has no colour: planes are
//! smooth, and small against luma, hence coarse. Errors of planes add up over the channels as their squares.
//!
//! One symmetric low-rank factor for the whole of Δ was tried instead. Rooms with doors have no low rank: of 126
//! columns for 2618 patches 1 % of the light was still missing, at twice the bytes of luma.

use radfile::{Operator, luma};
use rayon::prelude::*;

use crate::{
    plan::{Matrix, Side, unit},
    small::eigen,
};

/// A plane with less than this share of the square of luma is rounding.
const ROUNDING: f64 = 1e-13;

/// How much of a plane is in red, green and blue.
pub type Colour = [f32; 3];

/// The colours that planes have: luma's first. Grey operators have no other.
pub fn colours(operator: &Operator) -> Vec<Colour> {
    let mut colours = vec![[1.0; 3]];
    if operator.channels == 1 {
        return colours;
    }
    let of_row = |row: usize| {
        let mut products = [[0.0; 3]; 3];
        let mut square = 0.0;
        for column in 0..operator.n {
            let k = operator.entry(row, column);
            let y = luma(k);
            let d = k.map(|k| f64::from(k - y));
            square += f64::from(y).powi(2);
            for a in 0..3 {
                (0..3).for_each(|b| products[a][b] += d[a] * d[b]);
            }
        }
        (products, square)
    };
    let rows: Vec<_> = (0..operator.n).into_par_iter().map(of_row).collect();
    let square: f64 = rows.iter().map(|row| row.1).sum();
    let sum = |a: usize, b: usize| rows.iter().map(|row| row.0[a][b]).sum();
    let products = (0..3).map(|a| (0..3).map(|b| sum(a, b)).collect()).collect();
    let axes = eigen(products).into_iter().take(2).filter(|axis| axis.0 > ROUNDING * square);
    colours.extend(axes.map(|(_, axis)| [0, 1, 2].map(|c| axis[c] as f32)));
    colours
}

/// A plane of the operator in the order of clusters; `number` counts as [`colours`] does.
pub fn plane(operator: &Operator, order: &[u32], side: &Side, number: usize, colour: Colour) -> Matrix {
    let n = operator.n;
    let value = |row: u32, column: u32| {
        let k = operator.entry(row as usize, column as usize);
        let y = luma(k);
        if number == 0 { y } else { (0..3).map(|c| colour[c] * (k[c] - y)).sum() }
    };
    let mut values = vec![0.0; n * n];
    let rows = values.par_chunks_mut(n).zip(order);
    rows.for_each(|(to, &row)| to.iter_mut().zip(order).for_each(|(to, &column)| *to = value(row, column)));
    let largest = values.par_iter().map(|v| v.abs()).reduce(|| 0.0, f32::max);
    Matrix { values, unit: unit(largest), rows: side.clone(), columns: side.clone() }
}
