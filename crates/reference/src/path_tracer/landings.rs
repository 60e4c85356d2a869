//! Where photons land: paths that start at the lights.
//!
//! A photon that lands with flux Φ on reflectance ρ leaves with ρ Φ, in cosine-weighted directions. Roulette with the
//! part that is left keeps the brightest channel's flux what it was, so all landings of a light are about as strong.

use std::sync::atomic::AtomicU64;

use glam::Vec3;
use rayon::prelude::*;

use super::{
    PathTracer, Vertex,
    emission::{Emission, Photon},
    random::{Group, PathNumbers, cosine_direction},
};

/// A point that a photon reached.
#[derive(Clone, Copy, Debug)]
pub struct Landing {
    /// Raised off the surface, local axes, metres.
    pub position: Vec3,
    /// Unit normal of the side that was hit.
    pub normal: Vec3,
    /// Its triangle.
    pub triangle: u32,
    /// Flux that arrives, W: the sum of all landings estimates what all surfaces receive.
    pub flux: Vec3,
    /// Part of it that leaves again; backs of one-sided surfaces are black.
    pub reflectance: Vec3,
}

impl PathTracer<'_> {
    /// The landings of `paths` photons, which go on after a landing up to `bounces` times; those of a path are together.
    /// Powers of two are stratified best.
    pub fn landings(&self, paths: u32, bounces: u32, seed: u32) -> Vec<Landing> {
        let emission = self.emission();
        let all = (0..paths).into_par_iter().map(|path| {
            let numbers = PathNumbers { batch: seed, path };
            self.walk(&emission, numbers, bounces, 1.0 / paths as f32)
        });
        all.collect::<Vec<_>>().concat()
    }

    fn walk(&self, emission: &Emission, numbers: PathNumbers, bounces: u32, share: f32) -> Vec<Landing> {
        let mut landings = vec![];
        let Some(Photon { mut origin, mut direction, flux, mut triangle }) = emission.photon(numbers) else {
            return landings;
        };
        let (count, mut flux) = (AtomicU64::new(0), share * flux);
        let rays = self.counted(&count);
        for bounce in 0..=bounces {
            if flux == Vec3::ZERO {
                break;
            }
            let Some(hit) = rays.closest(origin, direction, triangle) else { break };
            let (Vertex { position, normal, triangle: met }, reflectance) =
                (self.vertex(&hit, origin, direction), self.reflectance(&hit));
            landings.push(Landing { position, normal, triangle: met, flux, reflectance });
            let [roulette, ..] = numbers.at(bounce + 1, Group::Choices);
            let survives = (flux * reflectance).max_element() / flux.max_element();
            if roulette >= survives {
                break;
            }
            let [x, y, ..] = numbers.at(bounce + 1, Group::Directions);
            flux *= reflectance / survives;
            (origin, direction, triangle) = (position, cosine_direction(normal, x, y), met);
        }
        landings
    }
}
