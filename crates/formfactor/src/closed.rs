//! Counts to closed form factors: joined, scaled, held to their physical limits.

use radfile::Patches;
use rayon::prelude::*;

use crate::{
    closure,
    gather::Tally,
    reciprocity::{self, Limits},
};

/// What is known of form factors besides their values.
pub struct Closed {
    /// RMS of A_i F_ij − A_j F_ji as measured, relative to the RMS of their mean.
    pub reciprocity_before: f64,
    /// |row sum − what was measured| after joining.
    pub errors_before: Vec<f64>,
    /// The same of the stored rows.
    pub errors: Vec<f64>,
    /// |row + sky + absorbed − 1| of the stored rows.
    pub balance: Vec<f64>,
    /// Sky that each patch sees.
    pub sky: Vec<f32>,
    /// Pairs of the stored rows against their limits.
    pub limits: Limits,
    /// Newton steps of the scaling.
    pub iterations: u32,
    /// Whether the scaling came to rest.
    pub converged: bool,
}

/// Turns the counts in `matrix` into form factors, in place.
pub fn close(matrix: &mut [f32], patches: &Patches, tallies: &[Tally]) -> Closed {
    let area = &patches.area;
    let n = area.len();
    let reciprocity_before = reciprocity::join(matrix, area, tallies);
    let before = closure::row_sums(matrix, &vec![1.0; n]);
    let rows: Vec<Row> = (0..n).map(|i| Row::new(&tallies[i], f64::from(area[i]), before[i])).collect();
    let wanted: Vec<f64> = rows.iter().map(|r| r.wanted).collect();
    let scaling = closure::scale_to_row_sums(matrix, &wanted);
    let sums = finish(matrix, area, &rows, &scaling.factor);
    let sky: Vec<f32> = sums.iter().zip(&rows).map(|(sum, row)| row.sky(*sum)).collect();
    let balance = |i: usize| match tallies[i].rays {
        0 => 0.0, // nothing is known of the rest
        _ => (sums[i] + f64::from(sky[i]) + rows[i].absorbed - 1.0).abs(),
    };
    Closed {
        reciprocity_before,
        errors_before: (0..n).map(|i| (before[i] - wanted[i]).abs() / f64::from(area[i])).collect(),
        errors: (0..n).map(|i| (sums[i] - wanted[i] / f64::from(area[i])).abs()).collect(),
        balance: (0..n).map(balance).collect(),
        sky,
        limits: reciprocity::limits(matrix, area),
        iterations: scaling.iterations,
        converged: scaling.converged,
    }
}

/// What a row has to be, from what its rays met.
struct Row {
    /// Σ_j E_ij that was measured, m².
    wanted: f64,
    /// Σ_j E_ij that must not be passed, m².
    limit: f64,
    /// Whether some ray escaped, so that what the row lacks is sky.
    sees_sky: bool,
    /// Share of the rays that were absorbed.
    absorbed: f64,
}

impl Row {
    /// `joined` is the row sum from the rays of both ends: all there is to know of a blind patch.
    fn new(tally: &Tally, area: f64, joined: f64) -> Row {
        if tally.rays == 0 {
            return Row { wanted: joined.min(area), limit: area, sees_sky: false, absorbed: 0.0 };
        }
        let (wanted, absorbed) = (area * share(tally.hits, tally.rays), share(tally.absorbed, tally.rays));
        let sees_sky = tally.escaped > 0;
        // Sky takes what a row lacks; where none was seen, the row must not pass its measured sum.
        let limit = if sees_sky { area * (1.0 - absorbed) } else { wanted };
        Row { wanted, limit, sees_sky, absorbed }
    }

    fn sky(&self, sum: f64) -> f32 {
        if self.sees_sky { (1.0 - self.absorbed - sum).max(0.0) as f32 } else { 0.0 }
    }
}

/// Turns exchange areas into form factors; returns the sums of the stored rows.
///
/// A row above its limit shrinks to it. A pair shrinks by the stricter of its two ends, so that
/// it stays reciprocal and no row rises. As no row passes its area, no pair passes the smaller of its areas.
fn finish(matrix: &mut [f32], area: &[f32], rows: &[Row], factor: &[f64]) -> Vec<f64> {
    let sums = closure::row_sums(matrix, factor);
    let shrink: Vec<f64> = sums.iter().zip(rows).map(|(&m, r)| if m > r.limit { r.limit / m } else { 1.0 }).collect();
    let finish_row = |(i, row): (usize, &mut [f32])| {
        let mut sum = 0.0;
        for (j, value) in row.iter_mut().enumerate() {
            let exchange = f64::from(*value) * factor[i] * factor[j] * shrink[i].min(shrink[j]);
            *value = (exchange / f64::from(area[i])) as f32;
            sum += f64::from(*value);
        }
        sum
    };
    matrix.par_chunks_exact_mut(area.len()).enumerate().map(finish_row).collect()
}

/// part / whole, 0 of nothing.
pub fn share(part: u32, whole: u32) -> f64 {
    if whole == 0 { 0.0 } else { f64::from(part) / f64::from(whole) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two patches that see nothing but each other: 1 m² and 0.98 m² cannot both send all they have.
    #[test]
    fn a_pair_that_its_ends_disagree_on_takes_the_stricter_end() {
        let area = [1.0, 0.98];
        let tally = Tally { rays: 100, hits: 100, ..Tally::default() };
        let rows = [0, 1].map(|i| Row::new(&tally, f64::from(area[i]), 0.99));
        let mut matrix = vec![0.0, 0.99, 0.99, 0.0];
        let wanted: Vec<f64> = rows.iter().map(|r| r.wanted).collect();
        let scaling = closure::scale_to_row_sums(&matrix, &wanted);
        assert!(scaling.converged);
        let sums = finish(&mut matrix, &area, &rows, &scaling.factor);
        assert!((sums[0] - 0.98).abs() < 1e-6 && (sums[1] - 1.0).abs() < 1e-6, "rows sum to {sums:?}");
        assert_eq!((rows[0].sky(sums[0]), rows[1].sky(sums[1])), (0.0, 0.0), "no sky where none was seen");
    }

    #[test]
    fn a_patch_without_samples_keeps_what_others_saw_of_it() {
        let row = Row::new(&Tally::default(), 2.0, 0.5);
        assert_eq!((row.wanted, row.limit, row.sky(0.25)), (0.5, 2.0, 0.0));
        assert_eq!(Row::new(&Tally::default(), 2.0, 3.0).wanted, 2.0, "but never more than its area");
    }
}
