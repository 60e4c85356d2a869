//! Figures of a run, for people and for tests.

use serde::Serialize;

/// What happened while form factors were measured and closed.
///
/// Row errors are |Σ_j F_ij − share of the rays of i that met a patch|.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Number of patches n.
    pub patches: usize,
    /// Rays that were traced, all patches together.
    pub rays: u64,
    /// Fewest, mean and most samples of a patch.
    pub rays_least: u32,
    pub rays_mean: f64,
    pub rays_most: u32,
    /// How often rays were sent, each time where they were worth most.
    pub rounds: u32,
    /// What noise of the form factors does to final light: standard error of indirect irradiance, RMS over
    /// patches by area relative to the RMS of the irradiance itself, RMS over probe lamps; see `probes.rs`.
    pub irradiance_error: f64,
    /// The error that was asked for, if one was.
    pub irradiance_target: Option<f64>,
    /// Whether `irradiance_error`, with a margin of one half for lamps that hang elsewhere, is no more than that.
    pub target_met: bool,
    /// Standard error of a row as measured by its own rays, ‖F¹ − F²‖ / ‖F¹ + F²‖ with the rows of the
    /// two halves of its rays, before the rays of the other patches are joined to them: mean and largest.
    pub row_error_mean: f64,
    pub row_error_max: f64,
    /// Up to five rows with the largest standard error, worst first.
    pub noisiest_rows: Vec<RowError>,
    /// Rays that met no surface.
    pub escaped: u64,
    /// Rays that met a face without a patch, such as the back of a one-sided surface.
    pub absorbed: u64,
    /// Samples in acute corners whose start was moved halfway to the next wall.
    pub moved: u64,
    /// Samples that were left out because there was no room to start from.
    pub discarded: u64,
    /// Patches all of whose samples were left out; they keep what others saw of them.
    pub blind_patches: usize,
    /// Mean over patches of the share of rays that met a patch.
    pub mean_hit_fraction: f64,
    /// Share of the n² form factors that are not zero.
    pub nonzero_share: f64,
    /// RMS of A_i F_ij − A_j F_ji as measured, relative to the RMS of their mean.
    pub reciprocity_before: f64,
    /// The largest |A_i F_ij − A_j F_ji| of the stored numbers, relative to the pair's mean.
    pub reciprocity_after: f64,
    /// The pair that exchanges the largest part of what it can.
    pub fullest_pair: PairLimit,
    /// The least F_ij; below 0 there is a bug.
    pub least_factor: f64,
    /// Largest |Σ_j F_ij + sky_i + absorbed_i − 1|.
    pub balance_max: f64,
    /// Largest row error after the two measurements of each pair were joined.
    pub closure_before_max: f64,
    /// Mean row error after the two measurements of each pair were joined.
    pub closure_before_mean: f64,
    /// Largest row error of the stored numbers.
    pub closure_after_max: f64,
    /// Mean row error of the stored numbers.
    pub closure_after_mean: f64,
    /// Newton steps of the scaling.
    pub iterations: u32,
    /// Whether the scaling came to rest; if not, the row errors say how far it got.
    pub converged: bool,
    /// Rows whose stored sum differs from what was measured by more than 1e-6.
    ///
    /// Patches that see only each other have one common exchange area, and two measurements of
    /// it that differ by noise cannot both be met.
    pub rows_not_met: usize,
    /// Up to five rows with the largest error before the scaling, worst first.
    pub worst_rows: Vec<RowError>,
    /// Up to five rows that could not be met, worst first.
    pub worst_not_met: Vec<RowError>,
}

/// A pair of patches and A_i F_ij / min(A_i, A_j), which physics limits to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PairLimit {
    /// Numbers of the patches.
    pub patches: [usize; 2],
    /// Part of the limit.
    pub share: f64,
}

/// A patch and the error of its row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RowError {
    /// Number of the patch.
    pub patch: usize,
    /// Row error.
    pub error: f64,
}

/// The five largest errors above `threshold`, worst first; equal ones in the order of patches.
pub fn worst(errors: &[f64], threshold: f64) -> Vec<RowError> {
    let mut rows: Vec<RowError> = errors
        .iter()
        .enumerate()
        .filter(|(_, error)| **error > threshold)
        .map(|(patch, &error)| RowError { patch, error })
        .collect();
    rows.sort_by(|a, b| b.error.total_cmp(&a.error).then(a.patch.cmp(&b.patch)));
    rows.truncate(5);
    rows
}
