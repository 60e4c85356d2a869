//! All bounces of light, one colour channel after the other.

use faer::Accum;
use radfile::{FormFactors, Operator, Patches, Progress};

use crate::{
    ChannelReport, Error, Method, Params, PatchSum, Precision, Report, cholesky,
    one_bounce::{self, OneBounce},
    quality::{self, Furnace},
    spectrum,
    store::store,
    tiles::{Lower, Panels},
    truncated::{self, Scratch},
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
/// directions, see [`Report::asymmetry`]). The bytes of the result do not depend on the number of threads.
///
/// # Errors
///
/// [`Error::NoPatches`], [`Error::Count`], [`Error::Value`], [`Error::NoBounces`] for input that means nothing;
/// [`Error::NotContracting`] if light would grow with every bounce, also where only a few bounces are asked for.
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
    if !matches!(params.method, Method::Cholesky | Method::Doubling) || params.precision == Precision::F32 {
        return Err(Error::NotBuilt);
    }
    let n = patches.len();
    let names: &[&'static str] = if patches.is_grey() { &["grey"] } else { &["red", "green", "blue"] };
    let one = OneBounce::new(patches, factors);
    let mut solver = Solver::new(&one, params, progress);
    let mut values = vec![0.0; names.len() * n * n];
    let mut channel = Vec::with_capacity(names.len());
    for ((&name, out), colour) in names.iter().zip(values.chunks_exact_mut(n * n)).zip(0..) {
        let rho = one.w.grid.vector(|i| f64::from(patches.reflectance[i][colour]));
        channel.push(solver.channel(name, &rho, out)?);
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

/// Largest |Σ_j F_ij + sky_i − 1| of the factors as given.
fn closure_error(factors: &FormFactors) -> f64 {
    let row = |i: usize| factors.row(i).iter().map(|&f| f64::from(f)).sum::<f64>() + f64::from(factors.sky[i]);
    (0..factors.len()).map(|i| (row(i) - 1.0).abs()).fold(0.0, f64::max)
}

/// Buffers that serve one channel after the other.
struct Solver<'a> {
    one: &'a OneBounce,
    params: &'a Params,
    progress: &'a dyn Progress,
    /// I − R W R, then L, then K.
    square: Lower,
    /// R W, then Y.
    panels: Panels,
    scratch: Option<Scratch>,
}

impl<'a> Solver<'a> {
    fn new(one: &'a OneBounce, params: &'a Params, progress: &'a dyn Progress) -> Solver<'a> {
        let grid = one.w.grid;
        let scratch = params.bounces.map(|_| Scratch::new(&one.w));
        Solver { one, params, progress, square: Lower::zeros(grid), panels: Panels::zeros(grid), scratch }
    }

    fn channel(&mut self, name: &'static str, rho: &[f64], out: &mut [f32]) -> Result<ChannelReport, Error> {
        let root_rho: Vec<f64> = rho.iter().map(|r| r.sqrt()).collect();
        self.progress.begin(&format!("series, {name}"), self.work());
        let largest_row = self.factor(name, rho, &root_rho)?;
        let smallest = spectrum::smallest_eigenvalue(&self.square);
        let condition = spectrum::largest_eigenvalue(&self.one.w, &root_rho) / smallest;
        let sky = quality::sky_light(self.one, &self.square, &root_rho);
        self.sum(&root_rho);
        let clamped = store(&self.square, out);
        let furnace = Furnace::of_solution(self.one, &self.square, rho, &sky);
        Ok(ChannelReport {
            name,
            spectral_radius: (1.0 - smallest).max(0.0),
            condition,
            largest_row,
            residual: quality::residual(self.one, &self.square, rho),
            furnace_max_error: furnace.max,
            furnace_mean_error: furnace.mean,
            furnace_max_error_stored: Furnace::of_stored(self.one, out, rho, &sky).max,
            clamped: clamped.count,
            lowest: clamped.lowest,
        })
    }

    /// Cholesky factor of I − R W R, or the reason why there is none.
    ///
    /// A matrix whose rows of F ρ all sum to less than 1 contracts for certain. Otherwise its spectral
    /// radius decides: power iteration finds a plain offender before the work, Cholesky all of them.
    fn factor(&mut self, name: &'static str, rho: &[f64], root_rho: &[f64]) -> Result<PatchSum, Error> {
        let largest_row = self.one.largest_row(rho);
        let refuse = |radius| {
            let PatchSum { patch, sum } = largest_row;
            Error::NotContracting { channel: name, patch, row_sum: sum, radius }
        };
        if largest_row.sum >= 1.0 {
            let radius = spectrum::radius_before_solving(&self.one.w, root_rho);
            if radius >= 1.0 {
                return Err(refuse(radius));
            }
        }
        self.one.fill_system(root_rho, &mut self.square);
        match cholesky::factor(&mut self.square, &|done| self.progress.advance(done)) {
            Ok(()) => Ok(largest_row),
            Err(cholesky::NotPositive) => Err(refuse(spectrum::radius_before_solving(&self.one.w, root_rho).max(1.0))),
        }
    }

    /// Replaces L by K.
    fn sum(&mut self, root_rho: &[f64]) {
        let tick = |done| self.progress.advance(done);
        let Solver { one, square, panels, .. } = self;
        match (self.params.bounces, &mut self.scratch) {
            (Some(bounces), Some(scratch)) => {
                truncated::first_bounces(&one.w, root_rho, bounces, square, panels, scratch, &tick);
            }
            _ => {
                panels.fill_scaled(&one.w, root_rho);
                cholesky::solve_panels(square, panels, &tick);
                square.values.copy_from_slice(&one.w.values);
                square.accumulate_product(Accum::Add, panels, panels, &tick);
            }
        }
    }

    /// Products of two tiles in one channel.
    fn work(&self) -> u64 {
        let t = self.square.grid.count as u64;
        let factor = t * (t * t - 1) / 6;
        let product = t * t * (t + 1) / 2;
        factor + self.params.bounces.map_or(2, truncated::product_count) * product
    }
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
/// [`Method::PaperInverse`] takes F as it is, all others take the mean of both directions.
///
/// # Errors
///
/// As [`all_bounces`]; but [`Error::NotContracting`] comes from [`Method::Cholesky`] and [`Method::Cg`] only, the
/// others compute on and report `contracts: false`.
pub fn solve_raw(f: &[f64], rho: &[f64], area: &[f64], params: &Params) -> Result<(Vec<f64>, ChannelReport), Error> {
    params.check()?;
    let _ = (f, rho, area);
    Err(Error::NotBuilt)
}
