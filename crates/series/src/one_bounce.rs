//! One bounce, W = A^{1/2} F A^{-1/2}, applied to vectors in f64 straight from the form factors.
//!
//! Solvers copy W into matrices of their own precision; whatever judges them uses this.

use radfile::{FormFactors, Patches};
use rayon::prelude::*;

use crate::{
    Error, PatchSum,
    scalar::{Scalar, add_scaled, dot},
    tiles::Grid,
};

/// W and the vectors that belong to it. Vectors are padded with zeros to whole tiles.
pub struct OneBounce<'a, S> {
    /// F, n × n, row = receiver.
    factors: &'a [S],
    /// Whether W is the mean of both directions, or F as it is.
    pub symmetric: bool,
    pub grid: Grid,
    /// A^{1/2}, m.
    pub root_area: Vec<f64>,
    /// A^{-1/2}, 0 in the padding.
    pub inverse_root: Vec<f64>,
    /// A^{1/2} (1 − Σ_j F_ij): light that a patch gets from the sky, or loses to rounding.
    pub lost: Vec<f64>,
    /// Row sums of F, as W has them.
    pub view: Vec<f64>,
    /// Largest |W_ij − W_ji| before any mean was taken, relative to the largest W.
    pub asymmetry: f64,
}

impl<'a, S: Scalar> OneBounce<'a, S> {
    /// From checked input.
    pub fn new(factors: &'a [S], area: impl Fn(usize) -> f64, n: usize, symmetric: bool) -> OneBounce<'a, S> {
        let grid = Grid::new(n);
        let root_area = grid.vector(|i| area(i).sqrt());
        let inverse_root = grid.vector(|i| 1.0 / root_area[i]);
        let (lost, view) = (vec![], vec![]);
        let mut one = OneBounce { factors, symmetric, grid, root_area, inverse_root, lost, view, asymmetry: 0.0 };
        one.asymmetry = one.measure_asymmetry();
        let sums = one.times(&one.root_area);
        one.view = (0..n).map(|i| sums[i] / one.root_area[i]).collect();
        one.lost = grid.vector(|i| one.root_area[i] - sums[i]);
        one
    }

    /// F_ij as given, 0 in the padding.
    pub fn factor(&self, i: usize, j: usize) -> f64 {
        let n = self.grid.n;
        if i < n && j < n { self.factors[i * n + j].into() } else { 0.0 }
    }

    /// W_ij, 0 in the padding. With `symmetric` exactly W_ji.
    pub fn w(&self, i: usize, j: usize) -> f64 {
        if i.max(j) >= self.grid.n {
            0.0
        } else if self.symmetric {
            0.5 * (self.scaled(i, j) + self.scaled(j, i))
        } else {
            self.scaled(i, j)
        }
    }

    fn scaled(&self, i: usize, j: usize) -> f64 {
        self.root_area[i] * self.factor(i, j) / self.root_area[j]
    }

    fn measure_asymmetry(&self) -> f64 {
        let Grid { n, edge, .. } = self.grid;
        let spread = self.grid.lower().into_par_iter().map(|(ti, tj)| {
            let mut spread = [0.0_f64; 2];
            for i in ti * edge..n.min((ti + 1) * edge) {
                for j in tj * edge..n.min((tj + 1) * edge) {
                    let (a, b) = (self.scaled(i, j), self.scaled(j, i));
                    spread = [spread[0].max((a - b).abs()), spread[1].max(0.5 * (a + b))];
                }
            }
            spread
        });
        let [difference, largest] = spread.reduce(|| [0.0; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        if largest > 0.0 { difference / largest } else { 0.0 }
    }

    /// F x, with F as given.
    pub fn gather(&self, x: &[f64]) -> Vec<f64> {
        let n = self.grid.n;
        let mut out = vec![0.0; x.len()];
        out.par_chunks_mut(self.grid.edge).zip(self.factors.par_chunks(n * self.grid.edge)).for_each(|(out, rows)| {
            rows.chunks_exact(n).zip(out).for_each(|(row, out)| *out = dot(row, &x[..n]));
        });
        out
    }

    /// Fᵀ x, with F as given.
    pub fn scatter(&self, x: &[f64]) -> Vec<f64> {
        let Grid { n, edge, .. } = self.grid;
        let mut out = vec![0.0; x.len()];
        out.par_chunks_mut(edge).enumerate().for_each(|(block, out)| {
            let columns = block * edge..n.min((block + 1) * edge);
            self.factors.chunks_exact(n).zip(x).for_each(|(row, &x)| add_scaled(out, x, &row[columns.clone()]));
        });
        out
    }

    /// W x.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let product = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
        let received = product(&self.root_area, &self.gather(&product(&self.inverse_root, x)));
        if !self.symmetric {
            return received;
        }
        let sent = product(&self.inverse_root, &self.scatter(&product(&self.root_area, x)));
        received.iter().zip(&sent).map(|(a, b)| 0.5 * (a + b)).collect()
    }

    /// Row of F ρ with the largest sum.
    pub fn largest_row(&self, rho: &[f64]) -> PatchSum {
        let emitted: Vec<f64> = rho.iter().zip(&self.root_area).map(|(r, a)| r * a).collect();
        let sums = self.times(&emitted);
        largest((0..self.grid.n).map(|i| sums[i] / self.root_area[i]))
    }
}

/// The first of the largest values.
pub fn largest(values: impl Iterator<Item = f64>) -> PatchSum {
    let first = PatchSum { patch: 0, sum: f64::NEG_INFINITY };
    values.enumerate().fold(first, |best, (patch, sum)| if sum > best.sum { PatchSum { patch, sum } } else { best })
}

/// Checks counts and numbers of a scene.
pub fn check(patches: &Patches, factors: &FormFactors) -> Result<(), Error> {
    let n = patches.len();
    check_counts(n, &[factors.len(), patches.reflectance.len()], factors.values.len())?;
    check_values("area", &patches.area, 1, is_area, AREA)?;
    check_values("reflectance", patches.reflectance.as_flattened(), 3, is_reflectance, REFLECTANCE)?;
    check_values("a form factor", &factors.values, n, |v| (0.0..=1.0).contains(&v), "0 to 1")?;
    check_values("the sky's share", &factors.sky, 1, |v| (0.0..=1.0).contains(&v), "0 to 1")
}

/// Checks counts and numbers that need not come from a scene.
pub fn check_raw(f: &[f64], rho: &[f64], area: &[f64]) -> Result<(), Error> {
    let n = area.len();
    check_counts(n, &[rho.len()], f.len())?;
    check_values("area", area, 1, is_area, AREA)?;
    check_values("reflectance", rho, 1, is_reflectance, REFLECTANCE)?;
    check_values("a form factor", f, n, |v| v >= 0.0 && v.is_finite(), "0 or more")
}

const AREA: &str = "a positive number";
const REFLECTANCE: &str = "0 or more and less than 1";

fn is_area(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

fn is_reflectance(value: f64) -> bool {
    (0.0..1.0).contains(&value)
}

fn check_counts(patches: usize, rows: &[usize], values: usize) -> Result<(), Error> {
    if patches == 0 {
        return Err(Error::NoPatches);
    }
    match rows.iter().find(|&&rows| rows != patches) {
        Some(&factors) => Err(Error::Count { patches, factors, values }),
        None if values != patches * patches => Err(Error::Count { patches, factors: patches, values }),
        None => Ok(()),
    }
}

/// Looks for the first number that is not `good`; there are `per_patch` of them a patch.
fn check_values<S: Scalar>(
    what: &'static str,
    values: &[S],
    per_patch: usize,
    good: impl Fn(f64) -> bool + Sync,
    expected: &'static str,
) -> Result<(), Error> {
    match values.par_iter().position_first(|&v| !good(v.into())) {
        Some(at) => {
            let found: f64 = values[at].into();
            Err(Error::Value { what, patch: at / per_patch, found: found as f32, expected })
        }
        None => Ok(()),
    }
}
