//! What the solve found out about the scene and about itself.

use serde::Serialize;

use crate::{Method, Precision};

/// A patch and a sum over its row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PatchSum {
    /// Index of the patch.
    pub patch: usize,
    /// The sum.
    pub sum: f64,
}

/// What was solved, and how well.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Patches.
    pub patches: usize,
    /// Channels of the operator: 1 for a grey scene, else 3.
    pub channels: usize,
    /// Bounces in the sum; `None` is all.
    pub bounces: Option<u32>,
    /// Largest |W_ij − W_ji| relative to the largest W: how far the form factors were from reciprocal.
    /// Half of it was moved to either side.
    pub asymmetry: f64,
    /// Largest |Σ_j F_ij + sky_i − 1|.
    pub closure_error: f64,
    /// Largest row sum of F, at most 1 in a physical scene.
    pub largest_view: PatchSum,
    /// Rows of F that sum to more than 1 + 10⁻⁶.
    pub rows_above_one: usize,
    /// One entry a channel.
    pub channel: Vec<ChannelReport>,
}

/// Stability and accuracy of one channel. Lengths of vectors and errors are relative, so 10⁻⁶ is one in a million.
///
/// All figures are the same for any number of threads, but for `seconds`, and for `peak_bytes` of conjugate gradients.
#[derive(Clone, Debug, Serialize)]
pub struct ChannelReport {
    /// "red", "green", "blue" or "grey"; "raw" from [`crate::solve_raw`].
    pub name: &'static str,
    /// How it was solved.
    pub method: Method,
    /// In which numbers.
    pub precision: Precision,
    /// Whether light fades from bounce to bounce, that is whether `spectral_radius` is below 1. If not, the sum of
    /// all bounces does not exist, and K is what the method made of that.
    pub contracts: bool,
    /// Spectral radius of F ρ: the factor that late bounces shrink by.
    pub spectral_radius: f64,
    /// Estimate of the condition number (2-norm) of the system: I − R W R, for the paper's inverse I − F ρ.
    pub condition: f64,
    /// Largest row sum of F ρ: what the patch gives back at most in one bounce.
    pub largest_row: PatchSum,
    /// Steps: bounces after the first, or those of the slowest column of conjugate gradients.
    pub iterations: Option<u64>,
    /// ‖(I − W ρ) K − W‖ / ‖W‖ (Frobenius norms, estimated by random probes), K before any rounding to f32 for
    /// storage, W in f64. With a number of bounces it is what the next bounce would bring.
    pub residual: f64,
    /// Largest error of the furnace identity, of the same K: emitters of 1 − ρ everywhere and a
    /// sky of 1 light every patch with exactly 1. With a number of bounces it is the light of all later ones.
    pub furnace_max_error: f64,
    /// Mean error of the same.
    pub furnace_mean_error: f64,
    /// Largest error of the same, of the stored f32 values.
    pub furnace_max_error_stored: f64,
    /// Largest |K_ij − K_ji| relative to the largest K, before the mean is taken for storage.
    pub asymmetry: f64,
    /// Values of K below 0. Where light fades they are rounding, and stored as 0.
    pub negative: u64,
    /// Their share of all values.
    pub negative_share: f64,
    /// The lowest of them, 0 if there are none.
    pub lowest: f64,
    /// Bytes of all matrices that were alive at the same time, the result in the container's f32 aside.
    pub peak_bytes: u64,
    /// Wall time of the solve, without the measurements of this report.
    pub seconds: f64,
}
