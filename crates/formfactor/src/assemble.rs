//! Rays, joining and closing in order, and the figures of the report.

use radfile::{FormFactors, Mesh, Patches, Progress};
use rayon::prelude::*;
use scene::{PatchSampler, Rays};

use crate::{
    Budget, Error, Params, Report, Result,
    allocation::{self, Aim},
    closed::{Closed, close, share},
    gather::{Surroundings, Tally},
    halves::{self, Halves},
    probes::{Light, Probes},
    report::{PairLimit, worst},
};

/// Lamps that hang elsewhere than the probes see up to so many times their error (measured: 0.86 to 1.47), so rays are
/// spent until the probes' error, times this, is what was asked for.
pub const MARGIN: f64 = 1.5;
/// A row counts as met if its sum differs from what was measured by no more than this.
const MET: f64 = 1e-6;
/// Rays are sent no more often than this.
const ROUNDS: u32 = 16;

/// Bytes that [`form_factors`] takes at most for `patches` patches: the counts of both halves, which
/// become exchange areas and those form factors in place, where rays follow the error a matrix to
/// try that on, and the vectors of the probes.
pub fn memory_needed(patches: usize, budget: Budget) -> u64 {
    let n = patches as u64;
    let matrices = match budget {
        Budget::Rays(_) => 2,
        Budget::Error { .. } => 3,
    };
    n.saturating_mul(n).saturating_mul(4 * matrices).saturating_add(n.saturating_mul(2048))
}

/// Measures the form factors of all patches.
///
/// | argument | meaning |
/// |---|---|
/// | `mesh` | the triangles that rays meet |
/// | `patches` | n patches made of pieces of that mesh |
/// | returns `.0` | F, n × n, row i = receiver, column j = sender, and the sky of each patch |
/// | returns `.1` | what was measured, how noisy it is and how well it closed |
///
/// A_i F_ij = A_j F_ji holds to rounding, F_ij ≥ 0, Σ_j F_ij ≤ 1, so A_i F_ij ≤ min(A_i, A_j). Rays that
/// meet nothing are sky; rays that meet a face without patch (the back of a one-sided surface) are
/// absorbed: Σ_j F_ij + sky_i + absorbed_i = 1, where absorbed_i is the measured share. A patch none of
/// whose rays escaped has sky 0, even if its row could not be brought to its full sum; the report names such rows.
///
/// # Errors
///
/// [`Error::NoPatches`], [`Error::TooFewRays`], [`Error::Target`], [`Error::Memory`].
///
/// # Panics
///
/// If the patches are not of this mesh, so that faces of the mesh are unknown to the locator: a bug in the caller.
pub fn form_factors(
    mesh: &Mesh,
    patches: &Patches,
    params: &Params,
    progress: &dyn Progress,
) -> Result<(FormFactors<'static>, Report)> {
    let n = patches.len();
    if n == 0 {
        return Err(Error::NoPatches);
    }
    assert_eq!(patches.locator.face_start.len(), mesh.face_count() + 1, "patches of another mesh");
    check(params.budget)?;
    let halves = Halves::new(n, memory_needed(n, params.budget))?;
    let rays = Rays::new(mesh);
    let surroundings = Surroundings { rays: &rays, sampler: PatchSampler::new(patches), patches };
    let probes = Probes::new(patches, &rays, params.seed);
    let run = Run { surroundings, probes, seed: params.seed, progress };
    let measured = match params.budget {
        Budget::Rays(rays) => run.evenly(halves, rays),
        Budget::Error { target, max_rays } => run.by_error(halves, target / MARGIN, max_rays)?,
    };
    let report = report(patches, params.budget, &measured);
    Ok((FormFactors { values: measured.factors.into(), sky: measured.closed.sky.into() }, report))
}

fn check(budget: Budget) -> Result<()> {
    let (found, least) = match budget {
        Budget::Rays(rays) => (rays, 2),
        Budget::Error { max_rays, .. } => (max_rays, allocation::PILOT),
    };
    match budget {
        _ if found < least => Err(Error::TooFewRays { found, least }),
        Budget::Error { target, .. } if !(target > 0.0 && target.is_finite()) => Err(Error::Target(target)),
        _ => Ok(()),
    }
}

/// What all rounds need.
struct Run<'a> {
    surroundings: Surroundings<'a>,
    probes: Probes,
    seed: u32,
    progress: &'a dyn Progress,
}

/// Form factors and what is known of them.
struct Measured {
    factors: Vec<f32>,
    closed: Closed,
    tallies: Vec<Tally>,
    row_errors: Vec<f64>,
    irradiance_error: f64,
    rounds: u32,
}

impl Run<'_> {
    fn evenly(&self, mut halves: Halves, rays: u32) -> Measured {
        halves.trace(&self.surroundings, self.seed, &vec![rays; halves.tallies.len()], self.progress);
        let row_errors = halves.row_errors();
        halves::add(&mut halves.first, &halves.second);
        let (tallies, of_half) = (halves.total_tallies(), halves.second_tallies());
        let (_, half_light) = self.close(&mut halves.second, &of_half, None);
        drop(halves.second);
        let mut factors = halves.first;
        let (closed, light) = self.close(&mut factors, &tallies, Some(&half_light));
        let irradiance_error = self.probes.error(&light, &half_light);
        Measured { factors, closed, tallies, row_errors, irradiance_error, rounds: 1 }
    }

    fn by_error(&self, mut halves: Halves, target: f64, most: u32) -> Result<Measured> {
        let n = halves.tallies.len();
        let mut factors = halves::matrix(n, memory_needed(n, Budget::Error { target, max_rays: most }))?;
        let mut wanted = vec![allocation::PILOT; n];
        for rounds in 1.. {
            halves.trace(&self.surroundings, self.seed, &wanted, self.progress);
            factors.copy_from_slice(&halves.second);
            let (_, half_light) = self.close(&mut factors, &halves.second_tallies(), None);
            factors.copy_from_slice(&halves.first);
            halves::add(&mut factors, &halves.second);
            let tallies = halves.total_tallies();
            let (closed, light) = self.close(&mut factors, &tallies, Some(&half_light));
            let error = self.probes.error(&light, &half_light);
            let next = match error > target && rounds < ROUNDS {
                true => allocation::plan(&self.probes.area, &factors, &wanted, Aim { error, target, most }),
                false => wanted.clone(),
            };
            if next == wanted {
                let row_errors = halves.row_errors();
                return Ok(Measured { factors, closed, tallies, row_errors, irradiance_error: error, rounds });
            }
            wanted = next;
        }
        unreachable!("the last round plans nothing more")
    }

    /// Closes the counts in `matrix` in place and lights the probes with what they become.
    fn close(&self, matrix: &mut [f32], tallies: &[Tally], guess: Option<&Light>) -> (Closed, Light) {
        let closed = close(matrix, self.surroundings.patches, tallies);
        let light = self.probes.light(matrix, guess);
        (closed, light)
    }
}

fn report(patches: &Patches, budget: Budget, measured: &Measured) -> Report {
    let n = patches.len();
    let Measured { factors, closed, tallies, row_errors, irradiance_error, rounds } = measured;
    let total = |f: fn(&Tally) -> u32| tallies.iter().map(|t| u64::from(f(t))).sum::<u64>();
    let samples: Vec<u32> = tallies.iter().map(Tally::samples).collect();
    let irradiance_target = match budget {
        Budget::Rays(_) => None,
        Budget::Error { target, .. } => Some(target),
    };
    Report {
        patches: n,
        rays: total(|t| t.rays),
        rays_least: samples.iter().copied().min().unwrap_or(0),
        rays_mean: total(Tally::samples) as f64 / n as f64,
        rays_most: samples.iter().copied().max().unwrap_or(0),
        rounds: *rounds,
        irradiance_error: *irradiance_error,
        irradiance_target,
        target_met: irradiance_target.is_none_or(|target| MARGIN * *irradiance_error <= target),
        row_error_mean: mean(row_errors),
        row_error_max: largest(row_errors),
        noisiest_rows: worst(row_errors, 0.0),
        escaped: total(|t| t.escaped),
        absorbed: total(|t| t.absorbed),
        moved: total(|t| t.moved),
        discarded: total(|t| t.discarded),
        blind_patches: tallies.iter().filter(|t| t.rays == 0).count(),
        mean_hit_fraction: mean(&tallies.iter().map(|t| share(t.hits, t.rays)).collect::<Vec<_>>()),
        nonzero_share: factors.par_iter().filter(|v| **v != 0.0).count() as f64 / (n * n) as f64,
        reciprocity_before: closed.reciprocity_before,
        reciprocity_after: closed.limits.reciprocity,
        fullest_pair: PairLimit { patches: closed.limits.fullest_pair, share: closed.limits.fullest },
        least_factor: closed.limits.least,
        balance_max: largest(&closed.balance),
        closure_before_max: largest(&closed.errors_before),
        closure_before_mean: mean(&closed.errors_before),
        closure_after_max: largest(&closed.errors),
        closure_after_mean: mean(&closed.errors),
        iterations: closed.iterations,
        converged: closed.converged,
        rows_not_met: closed.errors.iter().filter(|e| **e > MET).count(),
        worst_rows: worst(&closed.errors_before, 0.0),
        worst_not_met: worst(&closed.errors, MET),
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}
