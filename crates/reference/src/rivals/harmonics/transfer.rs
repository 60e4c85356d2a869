//! Transfer with interreflection, baked by following paths from a receiver.
//!
//! Sloan, Kautz and Snyder gather light bounce by bounce from the transfer of other vertices (§4.2); following paths
//! gives the same in the mean and needs no mesh of receivers that covers the scene. Of a path's vertices all but the
//! receiver send on light from afar where the next ray escapes, and light from near by as the centre of the vertex sees it.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};
use radfile::Side;
use scene::{Hit, Sobol, SurfacePoint, cosine_direction, hash};

use super::{
    basis::{Basis, MAX_FUNCTIONS},
    centres::Centres,
};
use crate::rivals::Setting;

/// What paths are followed in, and how.
pub struct Bake<'a> {
    pub setting: Setting<'a>,
    pub basis: &'a Basis,
    pub centres: &'a Centres,
    /// Paths of a receiver.
    pub paths: u32,
    /// Bounces of a path, at most.
    pub bounces: u32,
    /// Chooses the paths.
    pub seed: u32,
}

impl Bake<'_> {
    /// Numbers in a row, each an RGB triple: the distant functions, then those of each centre.
    pub fn row_length(&self) -> usize {
        (1 + self.centres.0.len()) * self.basis.len()
    }

    /// Irradiance of a receiver after 1 to `bounces` bounces for each coefficient of incident light.
    pub fn row(&self, number: usize, receiver: &SurfacePoint) -> Vec<Vec3> {
        let mut row = vec![DVec3::ZERO; self.row_length()];
        let seed = hash(self.seed, number as u32);
        for path in 0..self.paths {
            self.follow(&mut row, receiver, seed, path);
        }
        row.iter().map(|sum| (*sum / f64::from(self.paths)).as_vec3()).collect()
    }

    fn follow(&self, row: &mut [DVec3], receiver: &SurfacePoint, seed: u32, path: u32) {
        let (rays, length) = (self.setting.rays, self.basis.len());
        let (mut at, mut weight) = (*receiver, Vec3::ONE);
        for bounce in 0..=self.bounces {
            let origin = rays.off_surface(at.position, at.normal);
            let [x, y, ..] = Sobol::new(hash(seed, bounce)).sample(path);
            let direction = cosine_direction(at.normal, x, y);
            let hit = rays.closest(origin, direction, f32::INFINITY, at.triangle);
            if bounce > 0 {
                if hit.is_none() {
                    add(&mut row[..length], PI * weight, &self.basis.at(direction));
                }
                if !self.centres.0.is_empty() {
                    let centre = self.centres.of(rays, origin, at.triangle);
                    let local = &mut row[(1 + centre) * length..(2 + centre) * length];
                    add(local, weight, &self.basis.clamped_cosine(at.normal));
                }
            }
            let Some(hit) = hit else { break };
            weight *= self.reflectance(&hit);
            if weight == Vec3::ZERO {
                break;
            }
            at = self.landing(&hit, origin, direction);
        }
    }

    fn reflectance(&self, hit: &Hit) -> Vec3 {
        if self.setting.scene.mesh.one_sided && hit.side == Side::Back {
            return Vec3::ZERO;
        }
        Vec3::from(self.setting.surfaces.reflectance(hit.triangle, hit.u, hit.v))
    }

    /// The point that was hit, on the side that was, drawn back a little along the ray so that rounding pushes none in a
    /// corner through the wall beside it.
    fn landing(&self, hit: &Hit, origin: Vec3, direction: Vec3) -> SurfacePoint {
        let [a, b, c] = self.setting.scene.mesh.corners(hit.triangle as usize).map(Vec3::from);
        let front = (b - a).cross(c - a).normalize_or_zero();
        let normal = if hit.side == Side::Front { front } else { -front };
        let t = hit.t - (0.5 * hit.t).min(2.0 * self.setting.rays.gap());
        SurfacePoint { position: origin + t * direction, normal, triangle: hit.triangle }
    }
}

fn add(row: &mut [DVec3], weight: Vec3, functions: &[f32; MAX_FUNCTIONS]) {
    row.iter_mut().zip(functions).for_each(|(sum, &y)| *sum += (y * weight).as_dvec3());
}
