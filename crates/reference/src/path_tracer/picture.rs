//! What a camera sees.

use std::{
    f32::consts::PI,
    sync::atomic::{AtomicU64, Ordering},
};

use glam::Vec3;
use radfile::Progress;
use scene::{Camera, NO_TRIANGLE};
use serde::Serialize;

use super::{
    CountedRays, PathTracer, Sampling,
    random::{Group, PathNumbers, batch_seed},
    view::View,
};
use crate::{
    progressive::{average, converge},
    statistics::{COLOUR, LUMINANCE, channels},
};

/// Paths in a batch.
const BATCH: u32 = 16;

/// Linear RGB radiance, W/(m² sr), rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Their radiance.
    pub pixels: Vec<[f32; 3]>,
}

/// What a picture took and how sure it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PictureReport {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Paths of all pixels.
    pub paths: u64,
    /// Rays, shadow rays included.
    pub rays: u64,
    /// Pixels that did not reach the relative error within the largest number of paths.
    pub pixels_short_of_error: usize,
    /// Mean of all pixels, W/(m² sr).
    pub mean_radiance: [f64; 3],
    /// Mean over pixels of the standard error of luminance, W/(m² sr).
    pub mean_standard_error: f64,
}

impl PathTracer<'_> {
    /// The picture that `camera` takes: emitting surfaces and the sky are seen, quads are not, as they are
    /// no surface.
    pub fn picture(
        &self,
        camera: &Camera,
        [width, height]: [usize; 2],
        sampling: &Sampling,
        progress: &dyn Progress,
    ) -> (Picture, PictureReport) {
        let (origin, view) = (self.local(camera.origin), View::new(camera, width, height));
        let size = sampling.stop.batch(BATCH);
        let rays = AtomicU64::new(0);
        let batch = |pixel: usize, number: u32| {
            let rays = self.counted(&rays);
            let (x, y) = ((pixel % width) as f64, (pixel / width) as f64);
            let mut sum = [0.0; 3];
            for path in 0..size {
                let numbers = PathNumbers { batch: batch_seed(sampling.seed, pixel, number), path };
                let [dx, dy, ..] = numbers.at(0, Group::Pixel);
                let direction = view.direction(x + f64::from(dx), y + f64::from(dy));
                let radiance = self.radiance(origin, direction, &rays, numbers);
                sum = std::array::from_fn(|c| sum[c] + f64::from(radiance[c]));
            }
            channels(sum.map(|s| s / f64::from(size)))
        };
        let (tallies, short) = converge::<COLOUR>(width * height, size, sampling.stop, &[LUMINANCE], progress, batch);
        let pixels = tallies.iter().map(|t| t.colour(0).value.map(|v| v as f32)).collect();
        let report = PictureReport {
            width,
            height,
            paths: tallies.iter().map(|t| u64::from(t.estimates()) * u64::from(size)).sum(),
            rays: rays.load(Ordering::Relaxed),
            pixels_short_of_error: short,
            mean_radiance: std::array::from_fn(|c| average(&tallies, c)),
            mean_standard_error: tallies.iter().map(|t| t.error(LUMINANCE)).sum::<f64>() / tallies.len().max(1) as f64,
        };
        (Picture { width, height, pixels }, report)
    }

    /// Radiance that comes against a ray, W/(m² sr), as one path sees it.
    fn radiance(&self, origin: Vec3, direction: Vec3, rays: &CountedRays, numbers: PathNumbers) -> Vec3 {
        let Some(hit) = rays.closest(origin, direction, NO_TRIANGLE) else { return self.sky };
        let (emission, reflectance) = (self.area.emission(&hit), self.reflectance(&hit));
        if reflectance == Vec3::ZERO {
            return emission;
        }
        let at = self.vertex(&hit, origin, direction);
        let light = self.follow(at, rays, numbers);
        emission + reflectance / PI * (self.lamps.all(&at, rays) + light.direct + light.indirect)
    }
}
