//! One bounce in symmetric form, W = A^{1/2} F A^{-1/2}, and what is known before anything is solved.

use radfile::{FormFactors, Patches};
use rayon::prelude::*;

use crate::{
    Error, PatchSum,
    tiles::{Grid, Lower},
};

/// W and the vectors that belong to it. Vectors are padded with zeros to whole tiles.
pub struct OneBounce {
    /// W, exactly symmetric: the mean of both directions.
    pub w: Lower,
    /// A^{1/2}, m.
    pub root_area: Vec<f64>,
    /// A^{1/2} (1 − Σ_j F_ij): light that a patch loses to the sky or to rounding.
    pub lost: Vec<f64>,
    /// Row sums of F, made reciprocal.
    pub view: Vec<f64>,
    /// Largest |W_ij − W_ji| before the mean was taken, relative to the largest W.
    pub asymmetry: f64,
}

/// Checks counts and numbers.
pub fn check(patches: &Patches, factors: &FormFactors) -> Result<(), Error> {
    let n = patches.len();
    if n == 0 {
        return Err(Error::NoPatches);
    }
    if factors.len() != n || factors.values.len() != n * n || patches.reflectance.len() != n {
        return Err(Error::Count { patches: n, factors: factors.len(), values: factors.values.len() });
    }
    let value = |what, patch, found, expected| Err(Error::Value { what, patch, found, expected });
    if let Some(i) = patches.area.iter().position(|a| !(*a > 0.0 && a.is_finite())) {
        return value("area", i, patches.area[i], "a positive number");
    }
    if let Some(at) = patches.reflectance.as_flattened().iter().position(|r| !(0.0..1.0).contains(r)) {
        return value("reflectance", at / 3, patches.reflectance.as_flattened()[at], "0 or more and less than 1");
    }
    let share = |v: &f32| (0.0..=1.0).contains(v);
    if let Some(at) = factors.values.par_iter().position_first(|v| !share(v)) {
        return value("a form factor", at / n, factors.values[at], "0 to 1");
    }
    match factors.sky.iter().position(|v| !share(v)) {
        Some(i) => value("the sky's share", i, factors.sky[i], "0 to 1"),
        None => Ok(()),
    }
}

impl OneBounce {
    /// From checked input.
    pub fn new(patches: &Patches, factors: &FormFactors) -> OneBounce {
        let n = patches.len();
        let grid = Grid::new(n);
        let root_area = grid.vector(|i| f64::from(patches.area[i]).sqrt());
        let scaled = |i: usize, j: usize| root_area[i] * f64::from(factors.values[i * n + j]) / root_area[j];
        let mut w = Lower::zeros(grid);
        let spread = w.par_tiles().map(|((ti, tj), tile)| {
            let mut spread = [0.0_f64; 2];
            for (at, value) in tile.iter_mut().enumerate() {
                let (i, j) = (ti * grid.edge + at % grid.edge, tj * grid.edge + at / grid.edge);
                if i < n && j < n {
                    let (a, b) = (scaled(i, j), scaled(j, i));
                    *value = 0.5 * (a + b);
                    spread = [spread[0].max((a - b).abs()), spread[1].max(*value)];
                }
            }
            spread
        });
        let [difference, largest] = spread.reduce(|| [0.0; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        let sums = w.times(&root_area);
        let view: Vec<f64> = (0..n).map(|i| sums[i] / root_area[i]).collect();
        let lost = grid.vector(|i| root_area[i] - sums[i]);
        OneBounce { w, root_area, lost, view, asymmetry: if largest > 0.0 { difference / largest } else { 0.0 } }
    }

    /// I − R W R for R = ρ^{1/2}, written over `out`.
    pub fn fill_system(&self, root_rho: &[f64], out: &mut Lower) {
        let grid = self.w.grid;
        let size = grid.tile_size();
        out.par_tiles().for_each(|((ti, tj), tile)| {
            let w = &self.w.values[(ti * (ti + 1) / 2 + tj) * size..][..size];
            for (at, (value, w)) in tile.iter_mut().zip(w).enumerate() {
                let (i, j) = (ti * grid.edge + at % grid.edge, tj * grid.edge + at / grid.edge);
                let diagonal = if i == j { 1.0 } else { 0.0 };
                *value = diagonal - root_rho[i] * w * root_rho[j];
            }
        });
    }

    /// Row of F ρ with the largest sum.
    pub fn largest_row(&self, rho: &[f64]) -> PatchSum {
        let emitted: Vec<f64> = rho.iter().zip(&self.root_area).map(|(r, a)| r * a).collect();
        let sums = self.w.times(&emitted);
        largest((0..self.w.grid.n).map(|i| sums[i] / self.root_area[i]))
    }
}

/// The first of the largest values.
pub fn largest(values: impl Iterator<Item = f64>) -> PatchSum {
    let first = PatchSum { patch: 0, sum: f64::NEG_INFINITY };
    values.enumerate().fold(first, |best, (patch, sum)| if sum > best.sum { PatchSum { patch, sum } } else { best })
}
