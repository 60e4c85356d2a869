//! A reflective shadow map: what one light sees, and the flux that leaves it.

use glam::{Vec2, Vec3};
use radfile::Side;
use rayon::prelude::*;
use scene::NO_TRIANGLE;

use super::eye::{About, Eye};
use crate::rivals::Setting;

/// A piece of a lit surface.
#[derive(Clone, Copy, Default)]
pub struct Pixel {
    /// Position, metres.
    pub position: Vec3,
    /// Unit normal of the lit side.
    pub normal: Vec3,
    /// Reflected flux, W; 0 where the light meets nothing.
    pub flux: Vec3,
}

/// The map of one light.
pub struct Map {
    eye: Eye,
    side: usize,
    pixels: Vec<Pixel>,
    /// Flux of all pixels, sum of the channels, W.
    power: f64,
}

impl Map {
    /// Renders a map of `side` × `side` pixels, a ray each.
    pub fn new(setting: &Setting, eye: Eye, side: usize) -> Map {
        let area = eye.measure() / (side * side) as f32;
        let pixel = |i: usize| {
            let at = Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32;
            lit(setting, &eye, at, area)
        };
        let pixels: Vec<Pixel> = (0..side * side).into_par_iter().map(pixel).collect();
        let power = pixels.iter().map(|p| f64::from(p.flux.element_sum())).sum();
        Map { eye, side, pixels, power }
    }

    /// Its pixels, row by row.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    /// Reflected flux, sum of the channels, W.
    pub fn power(&self) -> f64 {
        self.power
    }

    /// The map around a point of the scene.
    pub fn about(&self, point: Vec3) -> Surroundings<'_> {
        let about = self.eye.about(point);
        let pixels = about.measure() / self.eye.measure() * (self.side * self.side) as f32;
        Surroundings { map: self, about, pixels }
    }
}

/// A map as a unit disk about the projection of a point, see [`About`].
pub struct Surroundings<'a> {
    map: &'a Map,
    about: About<'a>,
    /// Pixels that the disk would hold.
    pub pixels: f32,
}

impl Surroundings<'_> {
    /// The pixel at an offset from the projection.
    pub fn pixel(&self, offset: Vec2) -> Option<&Pixel> {
        let side = self.map.side;
        let at = self.about.at(offset)? * side as f32;
        let column = (at.x.max(0.0) as usize).min(side - 1);
        let row = (at.y.max(0.0) as usize).min(side - 1);
        Some(&self.map.pixels[row * side + column])
    }
}

fn lit(setting: &Setting, eye: &Eye, at: Vec2, area: f32) -> Pixel {
    let ray = eye.ray(at);
    if ray.power == Vec3::ZERO {
        return Pixel::default();
    }
    let Some(hit) = setting.rays.closest(ray.origin, ray.direction, f32::INFINITY, NO_TRIANGLE) else {
        return Pixel::default();
    };
    let mesh = &setting.scene.mesh;
    if mesh.one_sided && hit.side == Side::Back {
        return Pixel::default();
    }
    let [a, b, c] = mesh.corners(hit.triangle as usize).map(Vec3::from);
    let front = (b - a).cross(c - a).normalize_or_zero();
    let reflectance = Vec3::from(setting.surfaces.reflectance(hit.triangle, hit.u, hit.v));
    Pixel {
        position: ray.origin + hit.t * ray.direction,
        normal: if hit.side == Side::Front { front } else { -front },
        flux: reflectance * ray.power * area,
    }
}
