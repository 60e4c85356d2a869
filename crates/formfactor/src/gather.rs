//! The rays of one patch, counted where they land.
//!
//! A sample is one point of a four-dimensional Sobol sequence: two numbers place it on the patch,
//! two give the direction. The density cos θ / π makes the plain count an unbiased estimate of F, docs/theory.md (9.1).
//!
//! No ray meets the surface that it leaves, whatever the size of the patch and the place of the scene:
//!
//! - coordinates are f32 about a local origin, to which the import moves the scene in f64 (world
//!   coordinates of 5 million metres lose nothing), so rounding is relative to the size of the scene alone;
//! - the triangle that a ray starts on is passed through, so that a plane patch cannot see itself;
//! - the ray starts a gap off the surface, 2e-6 of the largest coordinate, above the rounding of
//!   points and of the triangle test, so that coplanar neighbours are not met either;
//! - points keep four gaps from the edges of their piece, so the gap does not lead through the next wall
//!   unless the corner is acute, which is asked for each sample (`start`);
//! - where a ray lands within rounding of another patch, rays next to it tell which of them is seen ([`land`]).
//!
//! What is smaller than a few gaps is not resolved: a cube of 1e-4 of the scene is, one of 1e-6 is not.

use std::ops::{Add, Range};

use glam::Vec3;
use radfile::Patches;
use scene::{PatchSampler, Rays, Sobol, cosine_direction, hash, land};

/// What became of the samples of one patch.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Samples with a ray.
    pub rays: u32,
    /// Rays that met a patch.
    pub hits: u32,
    /// Rays that met nothing.
    pub escaped: u32,
    /// Rays that met a face without a patch.
    pub absorbed: u32,
    /// Samples whose start was moved.
    pub moved: u32,
    /// Samples that had no room to start.
    pub discarded: u32,
}

impl Tally {
    /// Samples, with a ray or without.
    pub fn samples(&self) -> u32 {
        self.rays + self.discarded
    }
}

impl Add for Tally {
    type Output = Tally;

    fn add(self, other: Tally) -> Tally {
        Tally {
            rays: self.rays + other.rays,
            hits: self.hits + other.hits,
            escaped: self.escaped + other.escaped,
            absorbed: self.absorbed + other.absorbed,
            moved: self.moved + other.moved,
            discarded: self.discarded + other.discarded,
        }
    }
}

/// Where patches can be sampled and what their rays meet.
pub struct Surroundings<'a> {
    pub rays: &'a Rays,
    pub sampler: PatchSampler<'a>,
    pub patches: &'a Patches,
}

/// A wall nearer than this share of the gap cannot be told from the surface itself.
const ROUNDING_SHARE: f32 = 0.25;

impl Surroundings<'_> {
    /// Sends the `samples` of the sequence of `patch`; `row[j]` grows by the number that met patch j.
    pub fn gather(&self, patch: usize, samples: Range<u32>, seed: u32, row: &mut [f32]) -> Tally {
        let sobol = Sobol::new(hash(seed, patch as u32));
        let mut counts = vec![0u32; row.len()];
        let mut tally = Tally::default();
        for k in samples {
            let [x, y, u, v] = sobol.sample(k);
            let point = self.sampler.point(patch, x, y);
            let Some(origin) = self.start(point.position, point.normal, point.triangle, &mut tally) else {
                continue;
            };
            tally.rays += 1;
            let direction = cosine_direction(point.normal, u, v);
            let Some(landing) = land(self.rays, &self.patches.locator, origin, direction, point.triangle) else {
                tally.escaped += 1;
                continue;
            };
            match landing.patch {
                Some(seen) => {
                    tally.hits += 1;
                    counts[seen as usize] += 1;
                }
                None => tally.absorbed += 1,
            }
        }
        for (value, count) in row.iter_mut().zip(counts) {
            *value += count as f32;
        }
        tally
    }

    /// The start of a ray: off the surface, but not through another wall that is nearer than the gap.
    ///
    /// In an acute corner the next wall may be nearer; the start is then moved halfway to it. Where
    /// that cannot be told from rounding there is no start, and the patch's other samples stand for this one.
    fn start(&self, point: Vec3, normal: Vec3, own: u32, tally: &mut Tally) -> Option<Vec3> {
        let gap = self.rays.gap();
        match self.rays.closest(point, normal, gap, own) {
            Some(wall) if wall.t > ROUNDING_SHARE * gap => {
                tally.moved += 1;
                Some(point + 0.5 * wall.t * normal)
            }
            Some(_) => {
                tally.discarded += 1;
                None
            }
            None => Some(self.rays.off_surface(point, normal)),
        }
    }
}
