//! Irradiance of a point by a few wide cones.
//!
//! Source: Crassin et al., Interactive indirect illumination using voxel cone tracing, 2011: cones through the levels, front
//! to back, and a few of them over the hemisphere. They take five or so for diffuse light; here their number is free.
//! Directions follow the cosine, so that all count alike, along a spiral of golden angles.

use std::f32::consts::{PI, TAU};

use glam::Vec3;
use scene::SurfacePoint;

use super::pyramid::{Pyramid, View, VoxelLight};

/// Cones start so far above the surface, in cells: clear of its own voxels, which reach one cell beyond the middle of
/// theirs when they are interpolated.
const OFFSET: f32 = 1.0;
/// Length of a step over the edge of the voxels.
const STEP: f32 = 0.5;
/// Light that is left is not followed below this part.
const LEFT: f32 = 1e-3;
/// From one direction of the spiral to the next, turns.
const GOLDEN: f32 = 0.618_034;

impl Pyramid {
    /// Irradiance at a point from the voxels by so many cones, at least 1, W/m².
    pub fn gather(&self, light: &VoxelLight, point: &SurfacePoint, cones: u32) -> Vec3 {
        let normal = point.normal;
        let origin = point.position + OFFSET * self.grid.edge * normal;
        let (s, t) = normal.any_orthonormal_pair();
        let one = |number: u32| {
            let part = (number as f32 + 0.5) / cones as f32;
            let (sin, cos) = (part.sqrt(), (1.0 - part).sqrt());
            let (y, x) = (TAU * GOLDEN * number as f32).sin_cos();
            // Its solid angle is π / (cones cos θ), that of a circle of this radius at distance 1.
            let radius = (1.0 / (cones as f32 * cos)).sqrt();
            self.cone(light, origin, cos * normal + sin * (x * s + y * t), radius)
        };
        PI / cones as f32 * (0..cones).map(one).sum::<Vec3>()
    }

    /// Radiance along a cone that has a `radius` at distance 1, W/(m² sr).
    fn cone(&self, light: &VoxelLight, origin: Vec3, direction: Vec3, radius: f32) -> Vec3 {
        let view = View::new(origin, direction);
        let edge = self.grid.edge;
        let (low, size) = (self.grid.low, edge * self.grid.finest.dims.as_vec3());
        let (mut radiance, mut left, mut distance) = (Vec3::ZERO, 1.0f32, 0.5 * edge);
        while left > LEFT && distance < size.length() {
            // Voxels as wide as the cone, interpolated over twice their edge, blur a room to fog; these are half as wide.
            let width = (radius * distance).max(edge);
            let at = origin + distance * direction;
            if (low - at).max(at - low - size).max_element() > width {
                break;
            }
            let (seen, hidden) = self.look(light, at, width, &view);
            if hidden > 0.0 {
                // What a voxel hides on its length, a shorter step hides less of.
                let here = 1.0 - (1.0 - hidden.min(1.0)).powf(STEP);
                radiance += left * here / hidden * seen;
                left *= 1.0 - here;
            }
            distance += STEP * width;
        }
        radiance
    }
}
