//! All bounces of light, one colour channel after the other.

use std::time::Instant;

use radfile::{FormFactors, Operator, Patches, Progress, Quiet};
use rayon::prelude::*;

use crate::{
    ChannelReport, Error, Method, Params, PatchSum, Precision, Report,
    methods::{self, Failure, Solved},
    one_bounce::{self, OneBounce},
    quality::{self, Blemishes, Furnace},
    scalar::Scalar,
    spectrum::Spectrum,
    store::store,
};

/// Computes K for every channel: what each patch receives from each other after all bounces, scaled by areas.
///
/// | argument | meaning | shape |
/// |---|---|---|
/// | `patches` | areas A (m²) and reflectances ρ | `n` |
/// | `factors` | F, row = receiver, column = sender, and the share of the sky | `n` × `n`, `n` |
/// | returns `.0` | K = A^{-1/2} X A^{-1/2}, exactly symmetric, ≥ 0, dimensionless | 1 or 3 × `n` × `n` |
///
/// A scene whose reflectances are all grey gets one channel. F is made exactly reciprocal first (mean of both
/// directions, see [`Report::asymmetry`]); [`Method::PaperInverse`] takes it as it is and K is made symmetric
/// instead. The bytes of the result do not depend on the number of threads.
///
/// # Errors
///
/// [`Error::NoPatches`], [`Error::Count`], [`Error::Value`] for input that means nothing, those of
/// [`Params::check`]; [`Error::NotContracting`] if light would grow with every bounce, whichever the method and
/// also where only a few bounces are asked for; [`Error::Precision`] and [`Error::Stalled`] if the method fails.
///
/// # Example
///
/// Two facing plates of 1 m² that see half of each other and return half of what they receive:
///
/// ```
/// use radfile::{FormFactors, Patches, Quiet};
/// let patches = Patches { area: vec![1.0; 2], reflectance: vec![[0.5; 3]; 2], ..Patches::default() };
/// let factors = FormFactors { values: vec![0.0, 0.5, 0.5, 0.0].into(), sky: vec![0.5; 2].into() };
/// let (k, report) = series::all_bounces(&patches, &factors, &series::Params::default(), &Quiet)?;
/// // Light that left plate 1: half of it arrives at plate 0, and 1/16 of it is back there two bounces later.
/// assert!((k.values[1] - 0.5 / (1.0 - 1.0 / 16.0)).abs() < 1e-7);
/// assert!((report.channel[0].spectral_radius - 0.25).abs() < 1e-9);
/// # Ok::<(), series::Error>(())
/// ```
pub fn all_bounces(
    patches: &Patches,
    factors: &FormFactors,
    params: &Params,
    progress: &dyn Progress,
) -> Result<(Operator<'static>, Report), Error> {
    params.check()?;
    one_bounce::check(patches, factors)?;
    let n = patches.len();
    let names: &[&'static str] = if patches.is_grey() { &["grey"] } else { &["red", "green", "blue"] };
    let area = |i| f64::from(patches.area[i]);
    let one = OneBounce::new(&factors.values, area, n, params.method != Method::PaperInverse);
    let mut values = vec![0.0; names.len() * n * n];
    let mut channel = Vec::with_capacity(names.len());
    for ((&name, out), colour) in names.iter().zip(values.chunks_exact_mut(n * n)).zip(0..) {
        let rho = one.grid.vector(|i| f64::from(patches.reflectance[i][colour]));
        let (solved, mut report) = solve_channel(&one, &rho, name, Growing::Refused, params, progress)?;
        store(&*solved.k, one.grid, out);
        let times = |x: &[f64]| out.par_chunks(n).map(|row| crate::scalar::dot(row, &x[..n])).collect();
        report.furnace_max_error_stored = Furnace::of(&one, &rho, times).max;
        channel.push(report);
    }
    let report = Report {
        patches: n,
        channels: names.len(),
        bounces: params.bounces,
        asymmetry: one.asymmetry,
        closure_error: closure_error(factors),
        largest_view: one_bounce::largest(one.view.iter().copied()),
        rows_above_one: one.view.iter().filter(|&&sum| sum > 1.0 + 1e-6).count(),
        channel,
    };
    Ok((Operator { n, channels: names.len(), bounces: params.bounces, values: values.into() }, report))
}

/// K of one channel from any form factors, physical or not, with whatever negative light comes out.
///
/// This is for studying where methods fail; [`all_bounces`] is for scenes. `f` may hold values above 1, rows that
/// sum to more than 1, and need not be reciprocal.
///
/// | argument | meaning | shape |
/// |---|---|---|
/// | `f` | form factors, row = receiver, column = sender, finite, ≥ 0 | `n` × `n`, row-major |
/// | `rho` | reflectances, 0 ≤ ρ < 1 | `n` |
/// | `area` | areas, m², > 0 | `n` |
/// | returns `.0` | K = A^{-1/2} X A^{-1/2}, row-major, as computed: neither clamped nor made symmetric | `n` × `n` |
///
/// [`Method::PaperInverse`] takes F as it is, all others take the mean of both directions. Where light grows, a
/// sum of very many bounces overflows to infinity, and then to values that are not numbers.
///
/// # Errors
///
/// As [`all_bounces`]; but [`Error::NotContracting`] comes from [`Method::Cholesky`] and [`Method::Cg`] only, the
/// others compute on and report `contracts: false`.
///
/// # Example
///
/// Two plates that were measured to see more of each other than there is. The inverse exists, and is nonsense:
///
/// ```
/// let params = series::Params { method: series::Method::PaperInverse, ..Default::default() };
/// let (k, report) = series::solve_raw(&[0.0, 1.5, 1.5, 0.0], &[0.8; 2], &[1.0; 2], &params)?;
/// assert!((k[1] - 1.5 / (1.0 - 1.44)).abs() < 1e-12, "negative light");
/// assert!(!report.contracts && (report.spectral_radius - 1.2).abs() < 1e-12);
/// assert_eq!((report.negative, report.negative_share), (4, 1.0));
/// # Ok::<(), series::Error>(())
/// ```
pub fn solve_raw(f: &[f64], rho: &[f64], area: &[f64], params: &Params) -> Result<(Vec<f64>, ChannelReport), Error> {
    params.check()?;
    one_bounce::check_raw(f, rho, area)?;
    let n = area.len();
    let one = OneBounce::new(f, |i| area[i], n, params.method != Method::PaperInverse);
    let growing = match params.method {
        Method::Cholesky | Method::Cg => Growing::Refused,
        Method::Doubling | Method::Neumann | Method::PaperInverse => Growing::Computed,
    };
    let rho = one.grid.vector(|i| rho[i]);
    let (solved, report) = solve_channel(&one, &rho, "raw", growing, params, &Quiet)?;
    let mut values = vec![0.0; n * n];
    values.par_chunks_mut(n).enumerate().for_each(|(i, row)| {
        row.iter_mut().enumerate().for_each(|(j, value)| *value = solved.k.at(i, j));
    });
    Ok((values, report))
}

/// Largest |Σ_j F_ij + sky_i − 1| of the factors as given.
fn closure_error(factors: &FormFactors) -> f64 {
    let row = |i: usize| factors.row(i).iter().map(|&f| f64::from(f)).sum::<f64>() + f64::from(factors.sky[i]);
    (0..factors.len()).map(|i| (row(i) - 1.0).abs()).fold(0.0, f64::max)
}

/// What happens to a scene whose light grows from bounce to bounce.
#[derive(PartialEq)]
enum Growing {
    Refused,
    Computed,
}

fn solve_channel<S: Scalar>(
    one: &OneBounce<S>,
    rho: &[f64],
    name: &'static str,
    growing: Growing,
    params: &Params,
    progress: &dyn Progress,
) -> Result<(Solved, ChannelReport), Error> {
    progress.begin(&format!("series, {name}"), methods::work(one.grid, params));
    let largest_row = one.largest_row(rho);
    let spectrum = Spectrum::of(one, rho);
    let contracts = spectrum.radius < 1.0;
    let refuse = |radius| {
        let PatchSum { patch, sum } = largest_row;
        Error::NotContracting { channel: name, patch, row_sum: sum, radius }
    };
    if !contracts && growing == Growing::Refused {
        return Err(refuse(spectrum.radius));
    }
    let start = Instant::now();
    let solved = methods::solve(one, rho, params, &|done| progress.advance(done)).map_err(|failure| match failure {
        // The factorisation is exact where the estimate of the radius may be a little low.
        Failure::NotPositive if params.precision == Precision::F64 => refuse(spectrum.radius.max(1.0)),
        Failure::NotPositive => {
            Error::Precision { channel: name, method: params.method.name(), condition: spectrum.condition }
        }
        Failure::Stalled { steps } => Error::Stalled { channel: name, steps, tolerance: params.tolerance() },
    })?;
    let seconds = start.elapsed().as_secs_f64();
    let blemishes = Blemishes::of(&*solved.k, one.grid);
    let furnace = Furnace::of(one, rho, |x| solved.k.times(x));
    let report = ChannelReport {
        name,
        method: params.method,
        precision: params.precision,
        contracts,
        spectral_radius: spectrum.radius,
        condition: spectrum.condition,
        largest_row,
        iterations: solved.iterations,
        residual: quality::residual(one, &*solved.k, rho),
        furnace_max_error: furnace.max,
        furnace_mean_error: furnace.mean,
        furnace_max_error_stored: furnace.max,
        asymmetry: if blemishes.largest > 0.0 { blemishes.difference / blemishes.largest } else { 0.0 },
        negative: blemishes.negative,
        negative_share: blemishes.negative as f64 / (one.grid.n * one.grid.n) as f64,
        lowest: blemishes.lowest,
        peak_bytes: solved.peak_bytes,
        seconds,
    };
    Ok((solved, report))
}
