//! The numbers that a path is made of.
//!
//! Every vertex of a path has two groups of four numbers. Across the paths of a batch each group is a
//! scrambled Sobol sequence of its own (padding: M. Pharr, W. Jakob, G. Humphreys, Physically Based
//! Rendering, 4th ed., §8.6), so a batch is stratified in every group and unbiased in all.

use glam::Vec3;
use scene::{Sobol, hash};

/// One path of a batch.
#[derive(Clone, Copy)]
pub struct PathNumbers {
    pub batch: u32,
    pub path: u32,
}

/// What a group of numbers is for.
#[derive(Clone, Copy)]
pub enum Group {
    /// The direction to go on in, and the point of an area light.
    Directions = 0,
    /// Which lights, and whether to go on.
    Choices = 1,
    /// The place in a pixel.
    Pixel = 2,
}

impl PathNumbers {
    /// Four numbers in [0, 1) for the vertex after `bounces`.
    pub fn at(&self, bounces: u32, group: Group) -> [f32; 4] {
        Sobol::new(hash(self.batch, 3 * bounces + group as u32)).sample(self.path)
    }
}

/// The seed of one batch of one point or pixel.
pub fn batch_seed(seed: u32, target: usize, batch: u32) -> u32 {
    hash(hash(hash(seed, 0x7061_7468), target as u32), batch)
}

/// A unit direction about the unit vector `normal` with density cos θ / π (Malley's method: a disk, lifted).
pub fn cosine_direction(normal: Vec3, x: f32, y: f32) -> Vec3 {
    let (radius, (sin, cos)) = (x.sqrt(), (std::f32::consts::TAU * y).sin_cos());
    let height = (1.0 - x).max(1e-8).sqrt();
    let (s, t) = normal.any_orthonormal_pair();
    (radius * cos * s + radius * sin * t + height * normal).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_cosine_weighted() {
        let normal = Vec3::new(1.0, -2.0, 0.5).normalize();
        let n = 1 << 14;
        let (mut mean, mut square) = (Vec3::ZERO, 0.0);
        for path in 0..n {
            let [x, y, ..] = PathNumbers { batch: 7, path }.at(0, Group::Directions);
            let d = cosine_direction(normal, x, y);
            assert!(d.dot(normal) > 0.0 && (d.length() - 1.0).abs() < 1e-6);
            mean += d / n as f32;
            square += f64::from(d.dot(normal)).powi(2) / f64::from(n);
        }
        // ∫ cos² / π = 2/3, ∫ cos³ / π = 1/2, nothing across.
        assert!((mean - normal * (2.0 / 3.0)).length() < 1e-3, "{mean}");
        assert!((square - 0.5).abs() < 1e-3, "{square}");
    }
}
