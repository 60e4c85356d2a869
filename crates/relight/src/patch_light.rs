//! Direct irradiance H⁰ of the patches, averaged over points of their pieces.

use std::f64::consts::PI;

use radfile::{Patches, Progress};
use rayon::prelude::*;
use scene::{PatchSampler, Sobol, hash};

use crate::{DirectLight, Samples};

/// How many points and rays stand for a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchSamples {
    /// Points on each patch.
    pub points: u32,
    /// Rays a point and area light.
    pub area: u32,
}

impl Default for PatchSamples {
    fn default() -> PatchSamples {
        PatchSamples { points: 32, area: 8 }
    }
}

/// H⁰ of every patch, W/m².
///
/// `sky` is what each patch sees of the sky ([`radfile::read_sky`]); it was measured with many
/// more rays than a frame could spend, so the sky costs none.
///
/// # Panics
///
/// If `sky` has not one value a patch: a bug in the caller.
pub fn patch_irradiance(
    direct: &DirectLight,
    patches: &Patches,
    sky: &[f32],
    samples: &PatchSamples,
    progress: &dyn Progress,
) -> Vec<[f32; 3]> {
    assert_eq!(sky.len(), patches.len(), "one share of the sky a patch");
    progress.begin("direct light of patches", patches.len() as u64);
    let sampler = PatchSampler::new(patches);
    let per_point = Samples { area: samples.area, sky: 0 };
    let radiance = direct.sky_radiance();
    (0..patches.len())
        .into_par_iter()
        .map(|patch| {
            let sobol = Sobol::new(hash(0x9a7c, patch as u32));
            let mut sum = [0.0; 3];
            for i in 0..samples.points {
                let [x, y, ..] = sobol.sample(i);
                let point = sampler.point(patch, x, y);
                let light = direct.irradiance_of_lamps(&point, &per_point, hash(patch as u32, i));
                sum = std::array::from_fn(|c| sum[c] + light[c]);
            }
            progress.advance(1);
            let seen = PI * f64::from(sky[patch]);
            std::array::from_fn(|c| (sum[c] / f64::from(samples.points) + seen * radiance[c]) as f32)
        })
        .collect()
}
