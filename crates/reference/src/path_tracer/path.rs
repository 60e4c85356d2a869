//! One path: irradiance of a point by following light backwards.
//!
//! With direct irradiance D of a point x, and y the surface seen from x in a cosine-weighted direction,
//! E(x) = D(x) + ρ(y) E(y) in the mean: π times the radiance ρ E / π of y.

use std::f32::consts::PI;

use glam::Vec3;
use radfile::Side;
use scene::Hit;

use super::{
    CountedRays, PathTracer, Vertex,
    random::{Group, PathNumbers, cosine_direction},
};

/// Bounces before roulette may end a path.
const SURE_BOUNCES: u32 = 3;

/// Irradiance of a point, W/m², as one path sees it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Estimate {
    /// Of lights with extent and the sky, without any bounce; lamps not counted.
    pub direct: Vec3,
    /// After exactly one bounce.
    pub single: Vec3,
    /// After one and more bounces.
    pub indirect: Vec3,
}

impl PathTracer<'_> {
    /// Follows one path from a point.
    pub(super) fn follow(&self, start: Vertex, rays: &CountedRays, numbers: PathNumbers) -> Estimate {
        let mut estimate = Estimate::default();
        let (mut at, mut weight) = (start, Vec3::ONE);
        for bounces in 0.. {
            let [x, y, light_x, light_y] = numbers.at(bounces, Group::Directions);
            let [pick_light, pick_lamp, roulette, _] = numbers.at(bounces, Group::Choices);
            let mut light = self.area.chosen(&at, rays, [pick_light, light_x, light_y]);
            if bounces > 0 {
                light += self.lamps.one(&at, rays, pick_lamp);
            }
            let direction = cosine_direction(at.normal, x, y);
            let hit = rays.closest(at.position, direction, at.triangle);
            light += self.area.met(&at, direction, hit.as_ref());
            if hit.is_none() {
                light += PI * self.sky;
            }
            light *= weight;
            match bounces {
                0 => estimate.direct = light,
                1 => (estimate.single, estimate.indirect) = (light, light),
                _ => estimate.indirect += light,
            }
            let Some(hit) = hit else { break };
            weight *= self.reflectance(&hit);
            if bounces >= SURE_BOUNCES {
                let survives = weight.max_element().min(1.0);
                if roulette >= survives {
                    break;
                }
                weight /= survives;
            }
            if weight == Vec3::ZERO {
                break;
            }
            at = self.vertex(&hit, at.position, direction);
        }
        estimate
    }

    /// Reflectance of the texel that was hit; backs of one-sided surfaces are black.
    pub(super) fn reflectance(&self, hit: &Hit) -> Vec3 {
        if self.mesh.one_sided && hit.side == Side::Back {
            return Vec3::ZERO;
        }
        Vec3::from(self.surfaces.reflectance(hit.triangle, hit.u, hit.v))
    }

    /// The point where a ray ended, on the side that it hit.
    ///
    /// It is raised off the surface, and drawn back a little along the ray: rounding must not push a point in
    /// a corner to the other side of the wall beside it.
    pub(super) fn vertex(&self, hit: &Hit, origin: Vec3, direction: Vec3) -> Vertex {
        let [a, b, c] = self.mesh.corners(hit.triangle as usize).map(Vec3::from);
        let front = (b - a).cross(c - a).normalize_or_zero();
        let normal = if hit.side == Side::Front { front } else { -front };
        let point = origin + (hit.t - (0.5 * hit.t).min(2.0 * self.rays.gap())) * direction;
        Vertex { position: self.rays.off_surface(point, normal), normal, triangle: hit.triangle }
    }
}
