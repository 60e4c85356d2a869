//! How wrong indirect irradiance is, as people see it.
//!
//! H_ind = A^{-1/2} K A^{1/2} ρ H⁰ is computed with the dense and with the packed operator, summed in f64.
//! Relative RMS of the matrix is reported too, but it is a poor guide: random errors of its entries cancel
//! in the product and coherent ones do not.

use radfile::Patches;
use serde::Serialize;

/// Errors of indirect irradiance over probe lights; all are relative, 0.01 is 1 %.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Number of probe lights.
    pub probes: usize,
    /// Area-weighted L2 norm of the error relative to that of the irradiance, mean over probes.
    pub l2_mean: f64,
    /// The same, worst probe.
    pub l2_max: f64,
    /// 99th percentile of |error| relative to the mean indirect irradiance, mean over probes.
    pub p99: f64,
    /// 99th percentile of |error| relative to direct + indirect there plus a tenth of their mean, mean
    /// over probes: what can be seen, dark rooms included.
    pub vis99: f64,
    /// Flux gained (or, if negative, lost) relative to the indirect flux, mean over probes.
    pub energy_bias: f64,
    /// Frobenius norm of the error of K relative to that of K.
    pub matrix_rms: f64,
}

/// What one receiver gets from every probe.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// √A H, one a probe.
    pub light: Vec<f64>,
    /// Its error.
    pub error: Vec<f64>,
    /// Squares of its entries of K and of their errors, summed.
    pub matrix: [f64; 2],
}

/// √A ρ H⁰ of a channel, what the operator K is applied to: patches × lights.
pub fn sent_light(patches: &Patches, lights: &[Vec<f32>], channel: usize) -> Vec<f64> {
    let mut sent = Vec::with_capacity(patches.len() * lights.len());
    for (patch, (area, reflectance)) in patches.area.iter().zip(&patches.reflectance).enumerate() {
        let factor = f64::from(*area).sqrt() * f64::from(reflectance[channel]);
        sent.extend(lights.iter().map(|light| factor * f64::from(light[patch])));
    }
    sent
}

/// Errors under `lights`, direct irradiances of the patches in W/m²; every channel has a row a patch.
pub fn summarise(channels: &[Vec<Row>], patches: &Patches, lights: &[Vec<f32>]) -> Errors {
    let probes = lights.len();
    let count = probes.max(1) as f64;
    let norm = |k: usize| channels.iter().flatten().map(|row| row.matrix[k]).sum::<f64>().sqrt();
    let mut errors = Errors { probes, matrix_rms: ratio(norm(1), norm(0)), ..Errors::default() };
    for (probe, direct) in lights.iter().enumerate() {
        let one = one_probe(channels, patches, direct, probe);
        errors.l2_mean += one.l2_mean / count;
        errors.l2_max = errors.l2_max.max(one.l2_max);
        errors.p99 += one.p99 / count;
        errors.vis99 += one.vis99 / count;
        errors.energy_bias += one.energy_bias / count;
    }
    errors
}

fn one_probe(channels: &[Vec<Row>], patches: &Patches, direct: &[f32], probe: usize) -> Errors {
    let area: f64 = patches.area.iter().map(|a| f64::from(*a)).sum::<f64>() * channels.len() as f64;
    // Rows hold √A H: its square is the weighted square, √A times it the flux.
    let (mut squares, mut flux, mut direct_flux) = ([0.0; 2], [0.0; 2], 0.0);
    for (i, row) in channels.iter().flat_map(|rows| rows.iter().enumerate()) {
        let root = f64::from(patches.area[i]).sqrt();
        let (light, error) = (row.light[probe], row.error[probe]);
        squares = [squares[0] + light * light, squares[1] + error * error];
        flux = [flux[0] + root * light, flux[1] + root * error];
        direct_flux += root * root * f64::from(direct[i]);
    }
    let (mean, mean_of_all) = (flux[0] / area, (flux[0] + direct_flux) / area);
    let errors = |seen: &dyn Fn(usize, f64) -> f64| {
        let all = channels.iter().flat_map(|rows| rows.iter().enumerate());
        let pairs = all.map(|(i, row)| {
            let root = f64::from(patches.area[i]).sqrt();
            [row.error[probe] / root, seen(i, row.light[probe] / root)]
        });
        pairs.collect::<Vec<_>>()
    };
    let l2 = ratio(squares[1], squares[0]).sqrt();
    Errors {
        l2_mean: l2,
        l2_max: l2,
        p99: percentile_99(&errors(&|_, _| mean)),
        vis99: vis99(&errors(&|i, light| f64::from(direct[i]) + light), mean_of_all),
        energy_bias: ratio(flux[1], flux[0]),
        ..Errors::default()
    }
}

/// The quotient; nothing out of nothing is no error.
fn ratio(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}

/// 99th percentile of |error| relative to what is seen there, direct and indirect light together, plus a tenth of the mean
/// of all that is seen: `errors` holds the error and what is seen of every place. 0 of no places.
pub fn vis99(errors: &[[f64; 2]], mean_seen: f64) -> f64 {
    let beside = |&[error, seen]: &[f64; 2]| [error, seen + 0.1 * mean_seen];
    percentile_99(&errors.iter().map(beside).collect::<Vec<_>>())
}

/// The relative size of error that one in a hundred exceeds, of errors and what they are relative to.
fn percentile_99(errors: &[[f64; 2]]) -> f64 {
    let mut values: Vec<f64> = errors.iter().map(|&[error, to]| ratio(error.abs(), to)).collect();
    let rank = (values.len() * 99).div_ceil(100).saturating_sub(1);
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(rank, f64::total_cmp).1 }
}
