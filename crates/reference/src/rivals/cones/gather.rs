//! Irradiance of a point by a few wide cones.
//!
//! Source: Crassin et al. 2011, §5 (cones through the levels, front to back) and §6 (a few cones over the hemisphere). Six cones of 60°, one
//! along the normal and five about it, with the weights usual since.

use std::f32::consts::{FRAC_PI_3, PI, TAU};

use glam::Vec3;
use scene::SurfacePoint;

use super::pyramid::{Pyramid, View, VoxelLight};

/// Edge of voxels over distance: half the diameter of a cone whose sides are 30° from its axis. Voxels as wide as the cone,
/// interpolated over twice their edge, blur a room to fog.
const WIDENING: f32 = 0.577_350_3;
/// Cones start so far above the surface, in cells: clear of its own voxels, which reach one cell beyond the middle of
/// theirs when they are interpolated.
const OFFSET: f32 = 1.0;
/// Length of a step over the edge of the voxels.
const STEP: f32 = 0.5;
/// Light that is left is not followed below this part.
const LEFT: f32 = 1e-3;
/// Weight of the cone along the normal, and of each of the others, over π: their cosines over their solid angles.
const MIDDLE: f32 = 0.25;
const ASIDE: f32 = 0.15;

impl Pyramid {
    /// Irradiance at a point from the voxels, W/m².
    pub fn gather(&self, light: &VoxelLight, point: &SurfacePoint) -> Vec3 {
        let normal = point.normal;
        let origin = point.position + OFFSET * self.grid.edge * normal;
        let (s, t) = normal.any_orthonormal_pair();
        let (sin, cos) = FRAC_PI_3.sin_cos();
        let mut sum = MIDDLE * self.cone(light, origin, normal);
        for number in 0..5 {
            let (y, x) = (TAU * number as f32 / 5.0).sin_cos();
            let direction = cos * normal + sin * (x * s + y * t);
            sum += ASIDE * self.cone(light, origin, direction);
        }
        PI * sum
    }

    /// Radiance along a cone, W/(m² sr).
    fn cone(&self, light: &VoxelLight, origin: Vec3, direction: Vec3) -> Vec3 {
        let view = View::new(origin, direction);
        let edge = self.grid.edge;
        let farthest = edge * self.grid.finest.dims.as_vec3().length();
        let (mut radiance, mut left, mut distance) = (Vec3::ZERO, 1.0f32, 0.5 * edge);
        while left > LEFT && distance < farthest {
            let width = (WIDENING * distance).max(edge);
            let (seen, hidden) = self.look(light, origin + distance * direction, width, &view);
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
