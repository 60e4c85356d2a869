//! Direct light alone, for methods that follow no paths.

use std::{f32::consts::PI, sync::atomic::AtomicU64};

use glam::Vec3;
use scene::{Rays, SurfacePoint};

use super::{
    Glow, PathTracer, Vertex,
    random::{Group, PathNumbers, cosine_direction},
};

/// How lights with extent are sampled.
#[derive(Clone, Copy, Debug)]
pub struct DirectNumbers {
    /// Pairs of rays, one to a light and one into the open.
    pub samples: u32,
    /// Chooses them.
    pub seed: u32,
}

impl Vertex {
    /// Raised off the surface of a point.
    pub fn above(rays: &Rays, point: &SurfacePoint) -> Vertex {
        Vertex {
            position: rays.off_surface(point.position, point.normal),
            normal: point.normal,
            triangle: point.triangle,
        }
    }
}

impl PathTracer<'_> {
    /// Irradiance of all lights without any bounce, W/m²; `rays` counts rays.
    pub fn direct(&self, at: Vertex, rays: &AtomicU64, numbers: DirectNumbers) -> Vec3 {
        let rays = self.counted(rays);
        let lamps = self.lamps.all(&at, &rays);
        if self.area.is_empty() && self.sky == Vec3::ZERO {
            return lamps;
        }
        let one = |path: u32| {
            let numbers = PathNumbers { batch: numbers.seed, path };
            let [x, y, light_x, light_y] = numbers.at(0, Group::Directions);
            let [pick, ..] = numbers.at(0, Group::Choices);
            let direction = cosine_direction(at.normal, x, y);
            let hit = rays.closest(at.position, direction, at.triangle);
            let sky = if hit.is_none() { PI * self.sky } else { Vec3::ZERO };
            self.area.chosen(&at, &rays, [pick, light_x, light_y]) + self.area.met(&at, direction, hit.as_ref()) + sky
        };
        lamps + (0..numbers.samples).map(one).sum::<Vec3>() / numbers.samples.max(1) as f32
    }

    /// A point on a quad or an emitting surface; `None` where none shines. `path` counts points.
    pub fn glow(&self, seed: u32, path: u32) -> Option<Glow> {
        let numbers = PathNumbers { batch: seed, path };
        let [_, _, x, y] = numbers.at(0, Group::Directions);
        let [pick, ..] = numbers.at(0, Group::Choices);
        self.area.glow([pick, x, y])
    }

    /// The rays that lights are sampled with.
    pub fn rays(&self) -> &Rays {
        self.rays
    }
}
