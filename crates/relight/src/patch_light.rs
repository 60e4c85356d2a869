//! Direct irradiance H⁰ of the elements, averaged over their points.

use std::f64::consts::PI;

use radfile::{Elements, Progress};
use rayon::prelude::*;
use scene::{ElementPoints, hash};

use crate::{DirectLight, Samples};

/// How many points and rays stand for a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchSamples {
    /// Points on each patch, where its elements have none of their own.
    pub points: u32,
    /// Rays a point and area light.
    pub area: u32,
}

impl Default for PatchSamples {
    fn default() -> PatchSamples {
        PatchSamples { points: 32, area: 8 }
    }
}

/// H⁰ of every element, W/m².
///
/// `sky` is what each patch sees of the sky ([`radfile::read_sky`]); it was measured with many
/// more rays than a frame could spend, so the sky costs none. `area` is the number of rays a point and area light.
///
/// # Panics
///
/// If `sky` has not one value a patch: a bug in the caller.
pub fn element_irradiance(
    direct: &DirectLight,
    elements: &Elements,
    points: &ElementPoints,
    sky: &[f32],
    area: u32,
    progress: &dyn Progress,
) -> Vec<[f32; 3]> {
    assert_eq!(sky.len(), elements.patches(), "one share of the sky a patch");
    progress.begin("direct light of patches", elements.patches() as u64);
    let (per_point, radiance) = (Samples { area, sky: 0 }, direct.sky_radiance());
    let of_element = |patch: usize, element: usize| {
        let own = &points.points[points.of(element)];
        let lamps = direct.mean_irradiance_of_lamps(own, &per_point, |i| hash(element as u32, i));
        let seen = PI * f64::from(sky[patch]);
        std::array::from_fn(|c| (lamps[c] + seen * radiance[c]) as f32)
    };
    let of_patch = |patch: usize| {
        progress.advance(1);
        elements.of(patch).map(move |element| of_element(patch, element))
    };
    (0..elements.patches()).into_par_iter().flat_map_iter(of_patch).collect()
}
