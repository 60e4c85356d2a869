//! What light a product brings, against that of the dense operator in double precision.
//!
//! Every contestant is held to the same probe lights, which no packer has seen: packers steer by seed 1 and
//! certify by seed 2. The furnace is the light of emitters 1 − ρ, which would be 1 everywhere in a closed scene
//! (docs/theory.md (7.1)); what counts is how far a product is from the dense operator there.

use probes::{Row, probe_lights, sent_light, summarise};
use rayon::prelude::*;

use super::{Product, case::Case};

/// Number of probe lights and their seed.
const PROBES: u32 = 20;
const SEED: u64 = 1000;

/// Errors of a product, relative.
#[derive(Clone, Copy, Debug)]
pub struct Score {
    /// Area-weighted L2 norm of the error over that of indirect irradiance, mean over probes.
    pub l2: f64,
    /// 99th percentile of what is seen of it, mean over probes; [`probes::Errors::vis99`].
    pub vis99: f64,
    /// Mean of |Σ_j (K̃ − K)_ij √A_j (1 − ρ_j)| / √A_i over patches and colours.
    pub furnace: f64,
}

/// The light of the dense operator.
pub struct Judge<'a> {
    case: &'a Case,
    lights: Vec<Vec<f32>>,
    /// Of every colour: patches × (probes, furnace).
    sent: [Vec<f64>; 3],
    exact: [Vec<f64>; 3],
}

impl<'a> Judge<'a> {
    /// Multiplies the probes of a case.
    pub fn new(case: &'a Case) -> Judge<'a> {
        let lights = probe_lights(&case.patches, PROBES, SEED);
        let sent = [0, 1, 2].map(|c| with_furnace(case, &sent_light(&case.patches, &lights, c), c));
        let exact = [0, 1, 2].map(|c| multiply(case, &sent[c], c));
        Judge { case, lights, sent, exact }
    }

    /// The light that products are timed with: that of a lamp, √A ρ H⁰.
    pub fn a_lamp(&self) -> Vec<[f32; 3]> {
        self.probe(1)
    }

    /// What a product makes of the probes.
    pub fn score(&self, product: &mut dyn Product) -> Score {
        let (n, count) = (self.case.len(), PROBES as usize + 1);
        let empty = || Row { light: vec![0.0; PROBES as usize], error: vec![0.0; PROBES as usize], matrix: [0.0; 2] };
        let mut rows = [0, 1, 2].map(|_| vec![empty(); n]);
        let (mut y, mut furnace) = (vec![[0.0; 3]; n], 0.0);
        for probe in 0..count {
            product.multiply(&self.probe(probe), &mut y);
            for (i, y) in y.iter().enumerate() {
                for c in 0..3 {
                    let exact = self.exact[c][i * count + probe];
                    let error = f64::from(y[c]) - exact;
                    if probe < PROBES as usize {
                        (rows[c][i].light[probe], rows[c][i].error[probe]) = (exact, error);
                    } else {
                        furnace += error.abs() / f64::from(self.case.patches.area[i]).sqrt();
                    }
                }
            }
        }
        let errors = summarise(&rows, &self.case.patches, &self.lights);
        Score { l2: errors.l2_mean, vis99: errors.vis99, furnace: furnace / (3 * n) as f64 }
    }

    fn probe(&self, probe: usize) -> Vec<[f32; 3]> {
        let at = |i: usize| i * (PROBES as usize + 1) + probe;
        (0..self.case.len()).map(|i| [0, 1, 2].map(|c| self.sent[c][at(i)] as f32)).collect()
    }
}

/// Probes of a colour, and √A (1 − ρ) behind them.
fn with_furnace(case: &Case, sent: &[f64], channel: usize) -> Vec<f64> {
    let rows = sent.chunks_exact(PROBES as usize).zip(case.patches.area.iter().zip(&case.patches.reflectance));
    let furnace = |(area, rho): (&f32, &[f32; 3])| f64::from(*area).sqrt() * (1.0 - f64::from(rho[channel]));
    rows.flat_map(|(sent, patch)| sent.iter().copied().chain([furnace(patch)])).collect()
}

/// K times all probes, patches × probes.
fn multiply(case: &Case, sent: &[f64], channel: usize) -> Vec<f64> {
    let (n, count) = (case.len(), PROBES as usize + 1);
    let matrix = case.operator.channel(channel);
    let mut out = vec![0.0; n * count];
    out.par_chunks_mut(count).enumerate().for_each(|(i, out)| {
        for (k, sent) in matrix[i * n..][..n].iter().zip(sent.chunks_exact(count)) {
            out.iter_mut().zip(sent).for_each(|(out, sent)| *out += f64::from(*k) * sent);
        }
    });
    out
}
