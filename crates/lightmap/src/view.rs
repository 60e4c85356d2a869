//! What rays from the sides of triangles meet.

use glam::Vec3;
use radfile::{Mesh, Side};
use scene::{Hit, Rays, cosine_direction};

/// A mesh with the rays over it.
pub struct View<'a> {
    pub mesh: &'a Mesh,
    pub rays: &'a Rays,
}

impl View<'_> {
    /// Unit normal of a side of a triangle; `None` if it has no area.
    pub fn normal(&self, triangle: u32, side: Side) -> Option<Vec3> {
        let front = crate::cross(self.mesh, triangle).try_normalize()?.as_vec3();
        Some(if side == Side::Front { front } else { -front })
    }

    /// What a ray from a point of a triangle meets, distances in metres; `x` and `y` between 0 and 1 choose its
    /// direction, distributed by the cosine to the normal.
    pub fn look(&self, triangle: u32, from: Vec3, normal: Vec3, [x, y]: [f32; 2]) -> Option<Hit> {
        let origin = self.rays.off_surface(from, normal);
        self.rays.closest(origin, cosine_direction(normal, x, y), f32::INFINITY, triangle)
    }
}
