//! Where lamps could hang, before anybody has said where they will: in the air before a surface, about half way to what
//! lies opposite, if there is room; and from where a sun could come in.

use glam::Vec3;

use crate::{NO_TRIANGLE, Rays, Sobol};

/// Part of the way to what lies opposite at which lamps hang.
const HEIGHT: [f32; 2] = [0.3, 0.7];
/// Least way to what lies opposite, in diagonals of the scene: nobody hangs a lamp between the boards of a shelf.
const ROOM: f32 = 0.06;
/// The way where nothing lies opposite.
const OPEN: f32 = 0.4;
/// Places that are tried for a lamp.
const TRIES: u32 = 64;

/// The air of a scene. `point` gives a point a little off a surface and the normal there, by three numbers from 0 to 1.
pub struct Air<'a, P: Fn([f32; 3]) -> (Vec3, Vec3)> {
    pub rays: &'a Rays,
    /// Of the scene, metres.
    pub diagonal: f32,
    pub point: P,
}

impl<P: Fn([f32; 3]) -> (Vec3, Vec3)> Air<'_, P> {
    /// The first place with room, or the last that was tried, and the normal of the surface that it lies before.
    pub fn place(&self, sobol: &Sobol) -> (Vec3, Vec3) {
        let (mut place, mut upward) = (Vec3::ZERO, Vec3::Y);
        for k in 0..TRIES {
            let [x, y, z, w] = sobol.sample(k);
            let (origin, normal) = (self.point)([x, y, z]);
            let opposite = self.rays.closest(origin, normal, f32::INFINITY, NO_TRIANGLE);
            let free = opposite.map_or(OPEN * self.diagonal, |hit| hit.t);
            (place, upward) = (origin + (HEIGHT[0] + w * (HEIGHT[1] - HEIGHT[0])) * free * normal, normal);
            if free > ROOM * self.diagonal {
                break;
            }
        }
        (place, upward)
    }

    /// A direction that some surface sees the sky in, if one is found.
    pub fn sun(&self, sobol: &Sobol) -> Option<Vec3> {
        let [x, y, ..] = sobol.sample(0);
        let (height, (sin, cos)) = (2.0 * y - 1.0, (std::f32::consts::TAU * x).sin_cos());
        let radius = (1.0 - height * height).max(0.0).sqrt();
        let towards = Vec3::new(radius * cos, height, radius * sin);
        let comes_in = |k: u32| {
            let [x, y, z, _] = sobol.sample(k);
            let (origin, normal) = (self.point)([x, y, z]);
            towards.dot(normal) > 0.0 && self.rays.escapes(origin, towards, NO_TRIANGLE)
        };
        (1..=TRIES).any(comes_in).then_some(towards)
    }
}
