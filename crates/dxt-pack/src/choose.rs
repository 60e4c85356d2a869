//! How many outliers and how much colour: the fewest bytes that keep light within an error.
//!
//! The error of outliers is that of the texture without any error of colour, and the other way round; they are
//! independent, so their squares add. They are measured under lights that those of the report do not repeat.

use probes::{probe_lights, sent_light};
use radfile::{Colour, ColourBlock, Operator, PackedOperator, Patches};
use rayon::prelude::*;

/// Shares of outliers that are tried.
pub const SHARES: [f64; 3] = [0.002, 0.005, 0.01];
/// Numbers of columns of the basis of colour that are tried in the largest component.
pub const COLUMNS: [usize; 11] = [4, 8, 16, 24, 32, 48, 64, 80, 96, 112, 128];
/// Lights of a trial.
const LIGHTS: u32 = 12;
/// Apart from the seeds of reports.
const SEED: u64 = 0x7261_6d70;

/// Light to try with, and what becomes of it exactly. Matrices are patches × lights, one a channel.
pub struct Trial<'a> {
    operator: &'a Operator<'a>,
    sent: Vec<Vec<f64>>,
    received: Vec<Vec<f64>>,
    by_luma: Vec<Vec<f64>>,
}

impl<'a> Trial<'a> {
    /// Light through an operator and through its luma.
    pub fn new(operator: &'a Operator<'a>, luma: &Operator, patches: &Patches) -> Trial<'a> {
        let lights = probe_lights(patches, LIGHTS, SEED);
        let sent: Vec<Vec<f64>> = (0..operator.channels).map(|c| sent_light(patches, &lights, c)).collect();
        let through = |of: &Operator| {
            let channels = sent.iter().enumerate();
            channels.map(|(c, x)| dense(of.n, of.channel(c), x)).collect()
        };
        let (received, by_luma) = (through(operator), through(luma));
        Trial { operator, sent, received, by_luma }
    }

    /// Error of light by the texture and outliers of luma.
    pub fn of_luma(&self, packed: &PackedOperator) -> f64 {
        let n = self.operator.n;
        let decoder = packed.decoder();
        let mut decoded = vec![0.0; n.next_multiple_of(4) * n];
        decoded.par_chunks_exact_mut(4 * n).enumerate().for_each(|(block, rows)| decoder.rows(0, block, rows));
        let found = self.sent.iter().map(|x| dense(n, &decoded, x));
        self.error(found.zip(&self.by_luma).map(|(found, exact)| difference(&found, exact)).collect())
    }

    /// Error of light by the colour.
    pub fn of_colour(&self, colour: &Colour) -> f64 {
        let blocks = colour.blocks();
        let errors = self.sent.iter().enumerate().map(|(channel, x)| {
            let mut found = self.by_luma[channel].clone();
            blocks.iter().for_each(|block| add(block, channel, x, &mut found));
            difference(&found, &self.received[channel])
        });
        self.error(errors.collect())
    }

    /// L2 norm relative to that of the light, mean over lights.
    fn error(&self, errors: Vec<Vec<f64>>) -> f64 {
        let lights = LIGHTS as usize;
        let norm = |of: &[Vec<f64>], light: usize| {
            of.iter().flat_map(|c| c.iter().skip(light).step_by(lights)).map(|e| e * e).sum::<f64>().sqrt()
        };
        let relative = |light| match norm(&self.received, light) {
            0.0 => 0.0,
            whole => norm(&errors, light) / whole,
        };
        (0..lights).map(relative).sum::<f64>() / lights as f64
    }
}

/// The cheapest pair of (bytes, error) within an error, or the one that loses least: its two indices.
pub fn cheapest(first: &[(usize, f64)], second: &[(usize, f64)], error: f64) -> (usize, usize) {
    let pairs = || (0..first.len()).flat_map(|i| (0..second.len()).map(move |k| (i, k)));
    let lost = |(i, k): (usize, usize)| first[i].1.hypot(second[k].1);
    let bytes = |(i, k): (usize, usize)| first[i].0 + second[k].0;
    let within = pairs().filter(|&pair| lost(pair) <= error).min_by_key(|&pair| bytes(pair));
    within.or_else(|| pairs().min_by(|&a, &b| lost(a).total_cmp(&lost(b)))).expect("something to choose from")
}

/// The product of the first n rows of a matrix and light.
fn dense(n: usize, matrix: &[f32], x: &[f64]) -> Vec<f64> {
    let lights = LIGHTS as usize;
    let product = |i: usize| {
        let mut sums = [0.0; LIGHTS as usize];
        for (&k, x) in matrix[i * n..][..n].iter().zip(x.chunks_exact(lights)) {
            sums.iter_mut().zip(x).for_each(|(sum, x)| *sum += f64::from(k) * x);
        }
        sums
    };
    let rows: Vec<[f64; LIGHTS as usize]> = (0..n).into_par_iter().map(product).collect();
    rows.into_flattened()
}

/// Adds U C Uᵀ x.
fn add(block: &ColourBlock, channel: usize, x: &[f64], to: &mut [f64]) {
    let (rank, lights) = (block.rank, LIGHTS as usize);
    let basis = || block.patches.iter().map(|&i| i as usize * lights).zip(block.basis.chunks_exact(rank));
    let mut gathered = vec![0.0; rank * lights];
    for (at, row) in basis() {
        for (&u, sums) in row.iter().zip(gathered.chunks_exact_mut(lights)) {
            sums.iter_mut().zip(&x[at..]).for_each(|(sum, x)| *sum += f64::from(u) * x);
        }
    }
    let core: Vec<f64> = block.core[channel].iter().map(|&c| f64::from(c)).collect();
    let carried = crate::small::product(&core, &gathered, rank, lights);
    for (at, row) in basis() {
        for (&u, carried) in row.iter().zip(carried.chunks_exact(lights)) {
            to[at..].iter_mut().zip(carried).for_each(|(to, c)| *to += f64::from(u) * c);
        }
    }
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_within_the_error_is_chosen_or_the_best_of_all() {
        let first = [(10, 0.04), (20, 0.03), (60, 0.01)];
        let second = [(5, 0.05), (15, 0.04), (100, 0.001)];
        assert_eq!(cheapest(&first, &second, 0.05), (1, 1), "0.03 and 0.04 make 0.05");
        assert_eq!(cheapest(&first, &second, 0.042), (2, 1));
        assert_eq!(cheapest(&first, &second, 0.0001), (2, 2));
    }
}
