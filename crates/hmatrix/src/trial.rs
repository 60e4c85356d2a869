//! Light through the exact operator, to hold packed ones against.

use std::cell::Cell;

use probes::{Errors, Row, probe_lights, sent_light, summarise};
use radfile::{Kernel, Operator, Patches, Progress, luma};
use rayon::prelude::*;

use crate::{HMatrix, Params, Solve};

/// What a solve of the exact operator leaves: far below any error that can be asked for.
const EXACT: f64 = 1e-5;
/// What a solve of the packed operator leaves, as a share of the error that was asked for.
pub const SOLVE_SHARE: f64 = 0.05;

/// Probe lights, and what comes of them.
pub struct Trial<'a> {
    kernel: Kernel,
    /// What solves leave.
    tolerance: f64,
    /// Products that the longest solve took.
    products: Cell<usize>,
    patches: &'a Patches,
    lights: Vec<Vec<f32>>,
    /// √A ρ H⁰ of every channel, patches × lights.
    sent: Vec<Vec<f64>>,
    /// √A H of every channel, patches × lights.
    exact: Vec<Vec<f64>>,
    /// The same if every channel had the operator of luma.
    exact_luma: Vec<Vec<f64>>,
}

/// Squares of errors relative to those of the light, mean over probes.
pub struct Squares {
    /// Of luma's part of the operator.
    pub luma: f64,
    /// Of colour's part.
    pub colour: f64,
}

impl<'a> Trial<'a> {
    pub fn new(
        operator: &Operator,
        patches: &'a Patches,
        params: &Params,
        seed: u64,
        progress: &dyn Progress,
    ) -> Trial<'a> {
        let lights = probe_lights(patches, params.probes, seed);
        let channels = if params.kernel == Kernel::OneBounce { 3 } else { operator.channels };
        let sent: Vec<Vec<f64>> = (0..channels).map(|c| sent_light(patches, &lights, c)).collect();
        let mut trial = Trial {
            kernel: params.kernel,
            tolerance: SOLVE_SHARE * params.error,
            products: Cell::new(1),
            patches,
            lights,
            sent,
            exact: Vec::new(),
            exact_luma: Vec::new(),
        };
        match params.kernel {
            Kernel::AllBounces => trial.multiply_exactly(operator, progress),
            Kernel::OneBounce => trial.solve_exactly(operator, progress),
        }
        trial
    }

    fn multiply_exactly(&mut self, operator: &Operator, progress: &dyn Progress) {
        progress.begin("lighting probes", operator.n as u64);
        let (sent, lights) = (&self.sent, self.lights.len());
        let rows: Vec<Vec<[Vec<f64>; 2]>> = (0..operator.n)
            .into_par_iter()
            .map(|i| {
                progress.advance(1);
                sent.iter().enumerate().map(|(c, sent)| received(operator, i, c, sent, lights)).collect()
            })
            .collect();
        let collect = |kind: usize| -> Vec<Vec<f64>> {
            (0..operator.channels).map(|c| rows.iter().flat_map(|row| row[c][kind].iter().copied()).collect()).collect()
        };
        (self.exact, self.exact_luma) = (collect(0), collect(1));
    }

    fn solve_exactly(&mut self, operator: &Operator, progress: &dyn Progress) {
        progress.begin("lighting probes", self.lights.len() as u64);
        let dense = |x: &[[f32; 3]], y: &mut [[f32; 3]]| {
            let row = |i: usize| &operator.channel(0)[i * operator.n..][..operator.n];
            y.par_iter_mut().enumerate().for_each(|(i, y)| *y = product(row(i), x));
        };
        let mut solve = Solve::new(operator.n);
        self.exact = self.lit(|x, y| {
            solve.all_bounces(dense, &self.patches.reflectance, EXACT, x, y);
            progress.advance(1);
        });
        self.exact_luma = self.exact.clone();
    }

    /// What comes out of an operator, patches × lights for every channel.
    fn lit(&self, mut operator: impl FnMut(&[[f32; 3]], &mut [[f32; 3]])) -> Vec<Vec<f64>> {
        let (n, count) = (self.patches.len(), self.lights.len());
        let mut out = vec![vec![0.0; n * count]; self.sent.len()];
        let mut y = vec![[0.0; 3]; n];
        for light in 0..count {
            let sent = |i: usize, c: usize| self.sent[c.min(self.sent.len() - 1)][i * count + light] as f32;
            let x: Vec<[f32; 3]> = (0..n).map(|i| std::array::from_fn(|c| sent(i, c))).collect();
            operator(&x, &mut y);
            for (c, out) in out.iter_mut().enumerate() {
                y.iter().enumerate().for_each(|(i, y)| out[i * count + light] = f64::from(y[c]));
            }
        }
        out
    }

    /// What comes out of `matrix`.
    fn through(&self, matrix: &HMatrix) -> Vec<Vec<f64>> {
        let mut workspace = matrix.workspace();
        match self.kernel {
            Kernel::AllBounces => self.lit(|x, y| matrix.multiply(x, y, &mut workspace)),
            Kernel::OneBounce => {
                let mut solve = Solve::new(self.patches.len());
                self.lit(|x, y| {
                    let one_bounce = |x: &[[f32; 3]], y: &mut [[f32; 3]]| matrix.multiply(x, y, &mut workspace);
                    let products = solve.all_bounces(one_bounce, &self.patches.reflectance, self.tolerance, x, y);
                    self.products.set(self.products.get().max(products));
                })
            }
        }
    }

    /// Products of a frame, the longest that was tried.
    pub fn products(&self) -> usize {
        self.products.get()
    }

    /// What the light of `matrix` is worth.
    pub fn errors(&self, matrix: &HMatrix) -> Errors {
        self.errors_of(&self.through(matrix))
    }

    /// The same and, where there is colour, errors by their source; `luma` is `matrix` without colour.
    pub fn by_source(&self, matrix: &HMatrix, luma: Option<&HMatrix>) -> (Errors, Option<Squares>) {
        let found = self.through(matrix);
        (self.errors_of(&found), luma.map(|luma| self.squares(&found, &self.through(luma))))
    }

    fn errors_of(&self, found: &[Vec<f64>]) -> Errors {
        let count = self.lights.len();
        let channels: Vec<Vec<Row>> = self
            .exact
            .iter()
            .zip(found)
            .map(|(exact, found)| {
                let rows = exact.chunks(count).zip(found.chunks(count));
                let error = |exact: &[f64], found: &[f64]| found.iter().zip(exact).map(|(f, e)| f - e).collect();
                rows.map(|(e, f)| Row { light: e.to_vec(), error: error(e, f), matrix: [0.0; 2] }).collect()
            })
            .collect();
        summarise(&channels, self.patches, &self.lights)
    }

    /// Of light with and without colour.
    fn squares(&self, found: &[Vec<f64>], found_luma: &[Vec<f64>]) -> Squares {
        let count = self.lights.len();
        let mut sums = vec![[0.0; 3]; count];
        for c in 0..self.exact.len() {
            for at in 0..self.exact[c].len() {
                let of_luma = found_luma[c][at] - self.exact_luma[c][at];
                let of_colour = found[c][at] - self.exact[c][at] - of_luma;
                let sum = &mut sums[at % count];
                *sum = [sum[0] + of_luma.powi(2), sum[1] + of_colour.powi(2), sum[2] + self.exact[c][at].powi(2)];
            }
        }
        let mean = |k: usize| sums.iter().filter(|s| s[2] > 0.0).map(|s| s[k] / s[2]).sum::<f64>() / count as f64;
        Squares { luma: mean(0), colour: mean(1) }
    }
}

/// A row times light, in double precision.
fn product(row: &[f32], x: &[[f32; 3]]) -> [f32; 3] {
    let mut sum = [0.0f64; 3];
    for (k, x) in row.iter().zip(x) {
        (0..3).for_each(|c| sum[c] += f64::from(*k) * f64::from(x[c]));
    }
    sum.map(|s| s as f32)
}

/// One receiver in one channel: through the operator of the channel, and through that of luma.
fn received(operator: &Operator, row: usize, channel: usize, sent: &[f64], lights: usize) -> [Vec<f64>; 2] {
    let mut sums = [vec![0.0; lights], vec![0.0; lights]];
    for (column, sent) in sent.chunks(lights).enumerate() {
        let k = operator.entry(row, column);
        for (sums, value) in sums.iter_mut().zip([k[channel], luma(k)]) {
            sums.iter_mut().zip(sent).for_each(|(sum, sent)| *sum += f64::from(value) * sent);
        }
    }
    sums
}
