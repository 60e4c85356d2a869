//! Irradiance at points of surfaces.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;
use radfile::Progress;
use scene::{NO_TRIANGLE, SurfacePoint};
use serde::Serialize;

use super::{
    PathTracer, Sampling, Vertex,
    random::{PathNumbers, batch_seed},
};
use crate::{
    progressive::{average, converge},
    statistics::{COLOUR, LUMINANCE, Measured, Tally, channels},
};

/// Paths in a batch.
const BATCH: u32 = 64;
/// First channel of each quantity in a tally.
const DIRECT: usize = 0;
const SINGLE: usize = COLOUR;
const INDIRECT: usize = 2 * COLOUR;
const CHANNELS: usize = 3 * COLOUR;

/// Irradiance of one point, W/m².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointEstimate {
    /// Without any bounce. Points, spots and suns are exact.
    pub direct: Measured,
    /// After exactly one bounce.
    pub single: Measured,
    /// After one and more bounces.
    pub indirect: Measured,
    /// Paths that were followed.
    pub samples: u64,
}

/// What the evaluation of points took and how sure it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointReport {
    /// Points.
    pub points: usize,
    /// Paths of all points.
    pub paths: u64,
    /// Rays, shadow rays included.
    pub rays: u64,
    /// Points that did not reach the relative error within the largest number of paths.
    pub points_short_of_error: usize,
    /// Mean of all points, W/m².
    pub mean_direct: [f64; 3],
    /// The same after one bounce.
    pub mean_single: [f64; 3],
    /// The same after one and more bounces.
    pub mean_indirect: [f64; 3],
    /// Mean over points of the standard error of direct luminance, W/m².
    pub mean_standard_error_direct: f64,
    /// The same of light after one bounce.
    pub mean_standard_error_single: f64,
    /// The same of light after one and more bounces.
    pub mean_standard_error_indirect: f64,
}

impl PathTracer<'_> {
    /// Irradiance at points in the axes of the scene file, metres; the unit normal picks the side.
    ///
    /// # Panics
    ///
    /// If there are not as many normals as positions: a bug in the caller.
    pub fn points(
        &self,
        position: &[[f64; 3]],
        normal: &[[f32; 3]],
        sampling: &Sampling,
        progress: &dyn Progress,
    ) -> (Vec<PointEstimate>, PointReport) {
        assert_eq!(position.len(), normal.len(), "one normal a point");
        let size = sampling.stop.batch(BATCH);
        let rays = AtomicU64::new(0);
        let vertex = |p: usize| self.receiver(position[p], normal[p]);
        let lamps: Vec<[f64; COLOUR]> =
            (0..position.len()).map(|p| channels(doubles(self.lamps.all(&vertex(p), &self.counted(&rays))))).collect();
        let batch = |p: usize, number: u32| {
            let rays = self.counted(&rays);
            let (start, seed) = (vertex(p), batch_seed(sampling.seed, p, number));
            let mut sum = [[0.0; 3]; 3];
            for path in 0..size {
                let one = self.follow(start, &rays, PathNumbers { batch: seed, path });
                for (sum, light) in sum.iter_mut().zip([one.direct, one.single, one.indirect]) {
                    *sum = std::array::from_fn(|c| sum[c] + f64::from(light[c]));
                }
            }
            let [direct, single, indirect] = sum.map(|s| channels(s.map(|s| s / f64::from(size))));
            let direct: [f64; COLOUR] = std::array::from_fn(|c| direct[c] + lamps[p][c]);
            let mut all = [0.0; CHANNELS];
            for (part, values) in all.chunks_exact_mut(COLOUR).zip([direct, single, indirect]) {
                part.copy_from_slice(&values);
            }
            all
        };
        let judged = [DIRECT + LUMINANCE, INDIRECT + LUMINANCE];
        let (tallies, short) = converge(position.len(), size, sampling.stop, &judged, progress, batch);
        let estimates = tallies.iter().map(|t| estimate(t, size)).collect();
        (estimates, report(&tallies, size, short, rays.load(Ordering::Relaxed)))
    }

    fn receiver(&self, position: [f64; 3], normal: [f32; 3]) -> Vertex {
        let normal = Vec3::from(normal).normalize_or_zero();
        Vertex::above(self.rays, &SurfacePoint { position: self.local(position), normal, triangle: NO_TRIANGLE })
    }
}

fn doubles(v: Vec3) -> [f64; 3] {
    v.as_dvec3().to_array()
}

fn estimate(tally: &Tally<CHANNELS>, size: u32) -> PointEstimate {
    PointEstimate {
        direct: tally.colour(DIRECT),
        single: tally.colour(SINGLE),
        indirect: tally.colour(INDIRECT),
        samples: u64::from(tally.estimates()) * u64::from(size),
    }
}

fn report(tallies: &[Tally<CHANNELS>], size: u32, short: usize, rays: u64) -> PointReport {
    let mean = |first: usize| std::array::from_fn(|c| average(tallies, first + c));
    let error = |first: usize| {
        tallies.iter().fold(0.0, |sum, t| sum + t.error(first + LUMINANCE)) / tallies.len().max(1) as f64
    };
    PointReport {
        points: tallies.len(),
        paths: tallies.iter().map(|t| u64::from(t.estimates()) * u64::from(size)).sum(),
        rays,
        points_short_of_error: short,
        mean_direct: mean(DIRECT),
        mean_single: mean(SINGLE),
        mean_indirect: mean(INDIRECT),
        mean_standard_error_direct: error(DIRECT),
        mean_standard_error_single: error(SINGLE),
        mean_standard_error_indirect: error(INDIRECT),
    }
}
