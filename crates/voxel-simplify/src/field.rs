//! Indirect light of fine patches under trial lamps.
//!
//! Irradiance changes where near surfaces come into view or leave it: in corners, around what stands on a floor, behind
//! doors. A coarse bake does not show that, but rays from the fine patches do, if what they meet has its own direct
//! light and takes only further bounces from the coarse bake (the final gather: M. F. Cohen, J. R. Wallace, Radiosity
//! and Realistic Image Synthesis, 1993, §8.4). So nothing has to be guessed from differences between coarse patches.
//!
//! Two halves of the rays are kept apart: noise is in both independently, so it is not in the mean of their product.

use radfile::{Patches, Progress, luma};
use rayon::prelude::*;
use scene::{PatchSampler, Rays, Sobol, cosine_direction, hash, land};

use crate::{
    lamps::{Lamp, direct_light},
    pilot::Pilot,
};

/// Rays of a half.
const RAYS: u32 = 128;
/// Points of a fine patch that are tested for shadow, a lamp.
const POINTS: u32 = 2;
/// Every so many lamps one is held back to judge by.
const HELD_BACK: usize = 4;

/// Irradiance of patches. For every lamp, its mean square by area is 1 over the number of lamps that shine.
pub struct Field {
    pub lamps: usize,
    /// Patches × lamps, luma, one from each half of the rays.
    halves: [Vec<f32>; 2],
}

impl Field {
    /// Light of those patches that are `kept`, the others have none.
    pub fn gather(
        patches: &Patches,
        kept: &[bool],
        pilot: &Pilot,
        lamps: &[Lamp],
        rays: &Rays,
        seed: u32,
        progress: &dyn Progress,
    ) -> Field {
        progress.begin("light of fine patches", patches.len() as u64);
        let leaving = radiosity(patches, pilot, lamps, rays, seed);
        let sampler = PatchSampler::new(patches);
        let half = |patch: usize, half: u32| {
            let mut sum = vec![0.0f32; lamps.len()];
            let sobol = Sobol::new(hash(hash(seed, half), patch as u32));
            for ray in 0..if kept[patch] { RAYS } else { 0 } {
                let [x, y, z, w] = sobol.sample(ray);
                let point = sampler.point(patch, x, y);
                let origin = rays.off_surface(point.position, point.normal);
                let direction = cosine_direction(point.normal, z, w);
                let landing = land(rays, &patches.locator, origin, direction, point.triangle);
                let Some(met) = landing.and_then(|landing| landing.patch) else { continue };
                let leaving = &leaving[met as usize * lamps.len()..][..lamps.len()];
                sum.iter_mut().zip(leaving).for_each(|(sum, b)| *sum += b / RAYS as f32);
            }
            progress.advance(u64::from(half));
            sum
        };
        let halves = [0, 1].map(|h| (0..patches.len()).into_par_iter().flat_map_iter(|p| half(p, h)).collect());
        let mut field = Field { lamps: lamps.len(), halves };
        field.normalise(patches);
        field
    }

    /// Brings every lamp to the same mean square.
    fn normalise(&mut self, patches: &Patches) {
        let area = |at: usize| f64::from(patches.area[at / self.lamps]);
        let mut squares = vec![0.0f64; self.lamps];
        for (at, (a, b)) in self.halves[0].iter().zip(&self.halves[1]).enumerate() {
            squares[at % self.lamps] += area(at) * f64::from(*a) * f64::from(*b);
        }
        let whole: f64 = patches.area.iter().map(|&a| f64::from(a)).sum();
        let shining = squares.iter().filter(|&&s| s > 0.0).count() as f64;
        let scale = |s: f64| if s > 0.0 { (whole / (shining * s)).sqrt() as f32 } else { 0.0 };
        let scale: Vec<f32> = squares.into_iter().map(scale).collect();
        for half in &mut self.halves {
            half.iter_mut().enumerate().for_each(|(at, h)| *h *= scale[at % self.lamps]);
        }
    }

    /// Irradiance of a patch under every lamp but those held back.
    pub fn of(&self, patch: usize) -> impl Iterator<Item = f64> + '_ {
        let shown = (0..self.lamps).filter(|lamp| !is_held_back(*lamp)).map(move |lamp| patch * self.lamps + lamp);
        shown.map(|at| 0.5 * (f64::from(self.halves[0][at]) + f64::from(self.halves[1][at])))
    }

    /// Expected error of patches that carry one irradiance each, under the lamps held back: RMS, relative to that of the
    /// irradiance. `owner` names for every fine patch the one that it is part of.
    pub fn error(&self, patches: &Patches, owner: &[Option<u32>]) -> f64 {
        let mut sums = vec![[0.0f64; 2]; patches.len() * self.lamps];
        let mut areas = vec![0.0f64; patches.len()];
        let mut whole = 0.0;
        for (patch, to) in (0..).zip(owner).filter_map(|(p, to)| Some((p, (*to)? as usize))) {
            let area = f64::from(patches.area[patch]);
            areas[to] += area;
            for lamp in (0..self.lamps).filter(|&lamp| is_held_back(lamp)) {
                let [a, b] = [0, 1].map(|h| f64::from(self.halves[h][patch * self.lamps + lamp]));
                let sum = &mut sums[to * self.lamps + lamp];
                *sum = [sum[0] + area * a, sum[1] + area * b];
                whole += area * a * b;
            }
        }
        let kept = sums.iter().enumerate().filter(|&(at, _)| areas[at / self.lamps] > 0.0);
        let means: f64 = kept.map(|(at, s)| s[0] * s[1] / areas[at / self.lamps]).sum();
        if whole > 0.0 { ((whole - means) / whole).max(0.0).sqrt() } else { 0.0 }
    }
}

fn is_held_back(lamp: usize) -> bool {
    lamp % HELD_BACK == HELD_BACK - 1
}

/// Bytes that the light of so many patches and lamps takes: direct, leaving, both halves, and means in double precision.
pub fn memory_needed(patches: usize, lamps: usize) -> u64 {
    (patches as u64).saturating_mul(lamps as u64).saturating_mul(4 * 4 + 2 * 8)
}

/// Radiosity ρ (H⁰ + H) of fine patches, luma, patches × lamps: direct light of their own, further bounces of the pilot.
fn radiosity(patches: &Patches, pilot: &Pilot, lamps: &[Lamp], rays: &Rays, seed: u32) -> Vec<f32> {
    let direct = direct_light(patches, lamps, POINTS, rays, seed);
    let indirect = pilot.indirect(lamps, rays, seed);
    let of_patch = |patch: usize| {
        let face = patches.pieces_of(patch)[0].face;
        let coarse = pilot.patches.locator.patch_at(face, patches.position[patch]);
        let (direct, indirect, rho) = (&direct, &indirect, patches.reflectance[patch]);
        (0..lamps.len()).map(move |lamp| {
            let further = |c: usize| coarse.map_or(0.0, |q| indirect[c][q as usize * lamps.len() + lamp]);
            luma([0, 1, 2].map(|c| rho[c] * (direct[patch * lamps.len() + lamp] + further(c))))
        })
    };
    (0..patches.len()).flat_map(of_patch).collect()
}
