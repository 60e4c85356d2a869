//! Precomputed radiance transfer in spherical harmonics, with interreflection.
//!
//! Source: P.-P. Sloan, J. Kautz, J. Snyder, Precomputed radiance transfer for real-time rendering in dynamic,
//! low-frequency lighting environments, SIGGRAPH 2002: transfer vectors of diffuse surfaces with interreflection (§4.2),
//! and incident light that varies in space, sampled at points (§5). Per channel, a receiver's irradiance is the inner product of
//! its transfer with the coefficients of incident light.
//!
//! Suns and the sky shine from afar, as the method assumes; they are exact but for the bands that are left out. The
//! published method knows lights near by only as distant light sampled at a few points without the object; in a room,
//! whose walls are the object and hide everything outside, that is darkness. Here points, spots, quads and emitting surfaces are
//! sampled *with* the scene at points in the air, and a surface takes what the nearest point that it sees receives.
//!
//! What it cannot do: shadows and falloff finer than the spacing of these points, so a lamp near a wall or a narrow spot is
//! wrong by as much as its light differs between a surface and its sample; edges of sunlight sharper than the bands show,
//! whose ringing is cut off where it would be negative.

mod basis;
mod centres;
mod incident;
mod transfer;

use glam::{DVec3, Vec3};
use radfile::Progress;
use rayon::prelude::*;
use scene::LightRig;

use self::{
    basis::Basis,
    centres::Centres,
    incident::{Nearby, distant, nearby},
    transfer::Bake,
};
use super::{Rival, Setting};

/// How transfer is baked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HarmonicsParams {
    /// Bands of spherical harmonics, 1 to 6: `bands`² functions.
    pub bands: usize,
    /// Points in the air at which light from near by is sampled; 0 where all light is distant.
    pub centres: usize,
    /// Bounces that are baked.
    pub bounces: u32,
    /// Paths for each receiver; a power of two is best.
    pub paths: u32,
    /// Points that stand for quads and emitting surfaces when light is projected; a power of two is best.
    pub light_samples: u32,
    /// Chooses paths and points.
    pub seed: u32,
}

impl Default for HarmonicsParams {
    fn default() -> HarmonicsParams {
        HarmonicsParams { bands: 4, centres: 32, bounces: 8, paths: 1024, light_samples: 256, seed: 1 }
    }
}

/// Precomputed transfer, for one setting.
pub struct Harmonics<'a> {
    setting: Setting<'a>,
    options: HarmonicsParams,
    basis: Basis,
    centres: Centres,
    /// Receivers × (1 + centres) × functions: irradiance for each coefficient of radiance, RGB.
    transfer: Vec<Vec3>,
    row_length: usize,
}

impl<'a> Harmonics<'a> {
    /// Bytes of the transfer of so many receivers: what baking asks for.
    pub fn bytes_needed(receivers: usize, options: &HarmonicsParams) -> u64 {
        let functions = Basis::new(options.bands).len() as u64;
        receivers as u64 * (1 + options.centres as u64) * functions * size_of::<Vec3>() as u64
    }

    /// Bakes.
    pub fn new(setting: Setting<'a>, options: HarmonicsParams, progress: &dyn Progress) -> Harmonics<'a> {
        let basis = Basis::new(options.bands);
        let centres = Centres::new(&setting, options.centres, options.seed);
        let HarmonicsParams { paths, bounces, seed, .. } = options;
        let bake = Bake { setting, basis: &basis, centres: &centres, paths: paths.max(1), bounces, seed };
        let row_length = bake.row_length();
        progress.begin("harmonic transfer", setting.receivers.len() as u64);
        let mut transfer = vec![Vec3::ZERO; setting.receivers.len() * row_length];
        transfer.par_chunks_mut(row_length).enumerate().for_each(|(number, row)| {
            row.copy_from_slice(&bake.row(number, &setting.receivers[number]));
            progress.advance(1);
        });
        Harmonics { setting, options, basis, centres, transfer, row_length }
    }
}

impl Rival for Harmonics<'_> {
    fn name(&self) -> String {
        format!("harmonic transfer, {} bands, {} points", self.basis.bands(), self.centres.0.len())
    }

    fn indirect(&mut self, rig: &LightRig, progress: &dyn Progress) -> Vec<[f32; 3]> {
        let functions = self.basis.len();
        let mut light = distant(rig, &self.basis)[..functions].to_vec();
        let near = Nearby::new(&self.setting, &self.basis, rig, self.options.light_samples, self.options.seed);
        light.extend(nearby(&near, &self.centres).iter().flat_map(|c| &c[..functions]));
        progress.begin("harmonic light", self.setting.receivers.len() as u64);
        let lit = |row: &[Vec3]| {
            let of_centre =
                |(row, light): (&[Vec3], &[Vec3])| row.iter().zip(light).map(|(t, l)| *t * *l).sum::<Vec3>().as_dvec3();
            let sum: DVec3 = row.chunks_exact(functions).zip(light.chunks_exact(functions)).map(of_centre).sum();
            progress.advance(1);
            sum.max(DVec3::ZERO).as_vec3().to_array()
        };
        self.transfer.par_chunks_exact(self.row_length).map(lit).collect()
    }

    fn bytes(&self) -> u64 {
        (size_of_val(&*self.transfer) + size_of_val(&*self.centres.0)) as u64
    }
}
