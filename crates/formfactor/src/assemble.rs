//! Counting, joining and closing in order, and the figures of the report.

use radfile::{FormFactors, Mesh, Patches, Progress};
use rayon::prelude::*;
use scene::{PatchSampler, Rays};

use crate::{
    Error, Params, Report, Result, closure,
    gather::{Surroundings, Tally},
    reciprocity,
    report::worst,
};

/// A row counts as met if its sum differs from what was measured by no more than this.
const MET: f64 = 1e-6;

/// Bytes that [`form_factors`] takes at most for `patches` patches: the matrix, in which counts become
/// exchange areas and those form factors in place, and a few vectors.
pub fn memory_needed(patches: usize) -> u64 {
    let n = patches as u64;
    n.saturating_mul(n).saturating_mul(4).saturating_add(n.saturating_mul(256))
}

/// Measures the form factors of all patches.
///
/// | argument | meaning |
/// |---|---|
/// | `mesh` | the triangles that rays meet |
/// | `patches` | n patches made of pieces of that mesh |
/// | returns `.0` | F, n × n, row i = receiver, column j = sender, and the sky of each patch |
/// | returns `.1` | what was measured and how well it closed |
///
/// A_i F_ij = A_j F_ji holds to rounding, and Σ_j F_ij ≤ 1. Rays that meet nothing are sky; rays that
/// meet a face without patch (the back of a one-sided surface) are absorbed: Σ_j F_ij + sky_i +
/// absorbed_i = 1, where absorbed_i is the measured share. A patch none of whose rays escaped has
/// sky 0, even if its row could not be brought to its full sum; the report names such rows.
///
/// # Errors
///
/// [`Error::NoPatches`], [`Error::NoRays`], [`Error::Memory`].
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
    if params.rays == 0 {
        return Err(Error::NoRays);
    }
    assert_eq!(patches.locator.face_start.len(), mesh.face_count() + 1, "patches of another mesh");
    let mut matrix = allocate(n)?;

    let rays = Rays::new(mesh);
    let surroundings = Surroundings { rays: &rays, sampler: PatchSampler::new(patches), patches };
    progress.begin("form factor rays", n as u64);
    let gather = |(patch, row): (usize, &mut [f32])| {
        let tally = surroundings.gather(patch, params, row);
        progress.advance(1);
        tally
    };
    let tallies: Vec<Tally> = matrix.par_chunks_exact_mut(n).enumerate().map(gather).collect();

    let area = &patches.area;
    let reciprocity_before = reciprocity::join(&mut matrix, area, &tallies);
    let before = closure::row_sums(&matrix, &vec![1.0; n]);
    let rows: Vec<Row> = (0..n).map(|i| Row::new(&tallies[i], f64::from(area[i]), before[i])).collect();
    let wanted: Vec<f64> = rows.iter().map(|r| r.wanted).collect();
    let scaling = closure::scale_to_row_sums(&matrix, &wanted);
    let sums = finish(&mut matrix, area, &rows, &scaling.factor);

    let sky = sums.iter().zip(&rows).map(|(sum, row)| row.sky(*sum)).collect::<Vec<f32>>();
    let errors_before: Vec<f64> = (0..n).map(|i| (before[i] - wanted[i]).abs() / f64::from(area[i])).collect();
    let errors: Vec<f64> = (0..n).map(|i| (sums[i] - wanted[i] / f64::from(area[i])).abs()).collect();
    let total = |f: fn(&Tally) -> u32| tallies.iter().map(|t| u64::from(f(t))).sum::<u64>();
    let report = Report {
        patches: n,
        rays: total(|t| t.rays),
        escaped: total(|t| t.escaped),
        absorbed: total(|t| t.absorbed),
        moved: total(|t| t.moved),
        discarded: total(|t| t.discarded),
        blind_patches: tallies.iter().filter(|t| t.rays == 0).count(),
        mean_hit_fraction: mean(&tallies.iter().map(|t| share(t.hits, t.rays)).collect::<Vec<_>>()),
        nonzero_share: matrix.par_iter().filter(|v| **v != 0.0).count() as f64 / (n * n) as f64,
        reciprocity_before,
        reciprocity_after: reciprocity::error(&matrix, area),
        closure_before_max: largest(&errors_before),
        closure_before_mean: mean(&errors_before),
        closure_after_max: largest(&errors),
        closure_after_mean: mean(&errors),
        iterations: scaling.iterations,
        converged: scaling.converged,
        rows_not_met: errors.iter().filter(|e| **e > MET).count(),
        worst_rows: worst(&errors_before, 0.0),
        worst_not_met: worst(&errors, MET),
    };
    Ok((FormFactors { values: matrix.into(), sky: sky.into() }, report))
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
/// it stays reciprocal and no row rises.
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

/// A matrix of zeros, or the error that says how much was asked for.
fn allocate(patches: usize) -> Result<Vec<f32>> {
    let refused = Error::Memory { patches, bytes: memory_needed(patches) };
    let Some(elements) = patches.checked_mul(patches) else { return Err(refused) };
    let mut matrix = Vec::new();
    match matrix.try_reserve_exact(elements) {
        Ok(()) => {
            matrix.resize(elements, 0.0);
            Ok(matrix)
        }
        Err(_) => Err(refused),
    }
}

fn share(part: u32, whole: u32) -> f64 {
    if whole == 0 { 0.0 } else { f64::from(part) / f64::from(whole) }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
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

    #[test]
    fn a_matrix_that_no_machine_holds_is_refused_with_its_size() {
        for patches in [1 << 40, 1 << 30] {
            let error = allocate(patches).expect_err("more bytes than an address has");
            let text = error.to_string();
            assert!(text.starts_with(&format!("form factors of {patches} patches need ")), "{text}");
            assert!(text.ends_with("bytes of memory, which are not there; use fewer patches"), "{text}");
        }
    }
}
