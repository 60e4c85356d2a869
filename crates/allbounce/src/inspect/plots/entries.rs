//! Matrices of any size as square pictures: a pixel is the mean over a rectangle of entries, found row by row.

use plot::{Colours, Key};
use rayon::prelude::*;

use crate::numbers;

/// Most pixels along an edge.
const MOST: usize = 420;

/// Means over rectangles of a square matrix.
pub struct Cells {
    /// Cells along an edge.
    pub side: usize,
    /// Row by row.
    pub mean: Vec<f64>,
    /// Mean over all entries.
    pub whole: f64,
}

/// Means of `value`, a function of row and column, over a matrix whose rows and columns stand in `order`.
pub fn cells(order: &[u32], value: impl Fn(usize, usize) -> f64 + Sync) -> Cells {
    let (n, side) = (order.len(), order.len().min(MOST));
    let places = |cell: usize| cell * n / side..(cell + 1) * n / side;
    let cell_of: Vec<usize> = (0..side).flat_map(|cell| places(cell).map(move |_| cell)).collect();
    let row_of_cells = |cell: usize| {
        let mut sum = vec![0.0; side];
        for &row in &order[places(cell)] {
            for (&column, &cell) in order.iter().zip(&cell_of) {
                sum[cell] += value(row as usize, column as usize);
            }
        }
        sum
    };
    let sums: Vec<Vec<f64>> = (0..side).into_par_iter().map(row_of_cells).collect();
    let whole = sums.iter().flatten().sum::<f64>() / (n as f64).powi(2);
    let mean = |(row, sums): (usize, &Vec<f64>)| {
        let rows = places(row).len();
        sums.iter().enumerate().map(|(c, sum)| sum / (rows * places(c).len()) as f64).collect::<Vec<f64>>()
    };
    Cells { side, mean: sums.iter().enumerate().flat_map(mean).collect(), whole }
}

/// Numbers as colours by their logarithm, from `top` down some decades; what is below has the lowest colour.
#[derive(Clone, Copy)]
pub struct LogColours {
    pub top: f64,
    pub decades: u32,
}

impl LogColours {
    pub fn at(self, value: f64) -> [u8; 3] {
        Colours::Sequential.at(1.0 + (value / self.top).log10() / f64::from(self.decades))
    }

    pub fn pixels(self, cells: &Cells) -> Vec<[u8; 3]> {
        cells.mean.iter().map(|mean| self.at(*mean)).collect()
    }

    /// Percent of `unit`, at powers of ten of it.
    pub fn key(self, unit: f64, label: String) -> Key {
        let top = (self.top / unit).log10();
        let powers = (0..=self.decades as i32).map(|k| top.floor() as i32 - k);
        let place = |power: i32| 1.0 + (f64::from(power) - top) / f64::from(self.decades);
        let ticks = powers.filter(|power| place(*power) >= 0.0);
        let ticks = ticks.map(|power| (place(power), numbers::percent(10f64.powi(power)))).collect();
        Key::Strip { colours: Colours::Sequential, ticks, label }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_means_whatever_the_order() {
        let value = |i: usize, j: usize| (3 * i + j) as f64;
        let exact = cells(&[2, 0, 1], value);
        assert_eq!((exact.side, exact.whole), (3, 4.0));
        assert_eq!(exact.mean[..3], [8.0, 6.0, 7.0], "row 2, columns 2, 0, 1");
        // 841 patches in 420 cells: one has three.
        let order: Vec<u32> = (0..2 * MOST as u32 + 1).rev().collect();
        let rows = cells(&order, |i, _| i as f64);
        assert_eq!((rows.side, rows.whole), (MOST, MOST as f64));
        assert!(rows.mean.chunks(MOST).all(|row| row.iter().all(|v| *v == row[0])), "constant along rows");
        assert_eq!(rows.mean[0], 2.0 * MOST as f64 - 0.5);
    }

    #[test]
    fn colours_end_at_their_ends() {
        let colours = LogColours { top: 50.0, decades: 3 };
        assert_eq!([colours.at(50.0), colours.at(0.0)], [1.0, 0.0].map(|at| Colours::Sequential.at(at)));
        let Key::Strip { ticks, .. } = colours.key(10.0, String::new()) else { panic!("a strip") };
        let words: Vec<&str> = ticks.iter().map(|tick| tick.1.as_str()).collect();
        assert_eq!(words, ["100 %", "10 %", "1 %"]);
    }
}
