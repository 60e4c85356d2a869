//! What the solve found out about the scene and about itself.

use serde::Serialize;

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
#[derive(Clone, Debug, Serialize)]
pub struct ChannelReport {
    /// "red", "green", "blue" or "grey".
    pub name: &'static str,
    /// Spectral radius of F ρ: the factor that late bounces shrink by.
    pub spectral_radius: f64,
    /// Estimate of the condition number of I − R W R.
    pub condition: f64,
    /// Largest row sum of F ρ: what the patch gives back at most in one bounce.
    pub largest_row: PatchSum,
    /// ‖(I − W ρ) K − W‖ / ‖W‖ (Frobenius norms, estimated by random probes), before rounding to f32.
    /// With a number of bounces it is what the next bounce would bring.
    pub residual: f64,
    /// Largest error of the furnace identity, before rounding to f32: emitters of 1 − ρ everywhere and a
    /// sky of 1 light every patch with exactly 1. With a number of bounces it is the light of all later ones.
    pub furnace_max_error: f64,
    /// Mean error of the same.
    pub furnace_mean_error: f64,
    /// Largest error of the same, of the stored f32 values.
    pub furnace_max_error_stored: f64,
    /// Values below 0 by rounding that were stored as 0.
    pub clamped: u64,
    /// The lowest of them.
    pub lowest: f64,
}
