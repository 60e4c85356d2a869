//! Reflectance and emission of patches, sampled where they are.

use std::f64::consts::PI;

use glam::DVec3;
use radfile::{Piece, Side};
use rayon::prelude::*;
use scene::{Sobol, Surfaces, hash, square_to_triangle};

use crate::{
    draft::Draft,
    surface::{Surface, turn},
};

/// Samples that a textured patch takes at least.
const SAMPLES: f64 = 64.0;
/// Samples that the emissive textures of the whole scene take, about, for the flux that patches are held to.
const FLUX_SAMPLES: usize = 1 << 18;
/// Largest f32 below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Fills in reflectance and emitted exitance, means over the coat by weight.
pub fn colour(draft: &mut Draft, surface: &Surface, surfaces: &Surfaces, seed: u32) {
    let coat = &draft.coat;
    let colours: Vec<(DVec3, DVec3)> = (0..draft.patches.len())
        .into_par_iter()
        .map(|patch| {
            let total: f64 = coat.of(patch).iter().map(|(_, w)| f64::from(*w)).sum();
            let mut sum = (DVec3::ZERO, DVec3::ZERO);
            for (k, (piece, weight)) in coat.of(patch).iter().enumerate() {
                let share = f64::from(*weight) / total;
                let (reflectance, radiance) =
                    piece_mean(surface, surfaces, piece, share, hash(seed, patch as u32 ^ (k as u32) << 20));
                sum.0 += share * reflectance;
                sum.1 += share * radiance;
            }
            sum
        })
        .collect();
    let rgb = |v: DVec3| v.as_vec3().to_array();
    draft.patches.reflectance = colours.iter().map(|c| rgb(c.0).map(|r| r.clamp(0.0, BELOW_ONE))).collect();
    draft.patches.emission = colours.iter().map(|c| rgb(PI * c.1)).collect();
}

/// Mean reflectance and radiance of a piece that is `share` of its patch.
fn piece_mean(surface: &Surface, surfaces: &Surfaces, piece: &Piece, share: f64, seed: u32) -> (DVec3, DVec3) {
    let triangle = piece.face / 2;
    let side = if piece.face.is_multiple_of(2) { Side::Front } else { Side::Back };
    let twins = surface.twins.get(&triangle).map_or(&[][..], |t| &t[..]);
    let alike = std::iter::once(triangle).chain(twins.iter().copied());
    let shining: Vec<u32> =
        alike.filter(|&t| surface.emits[t as usize] && turn(Side::Front, surface.turned[t as usize]) == side).collect();
    let textured = is_textured(surface, triangle) || shining.iter().any(|&t| is_textured(surface, t));
    let count = if textured { (SAMPLES * share).ceil() as u32 } else { 1 };
    let sequence = Sobol::new(seed);
    let [a, b, c] = piece.corners.map(|p| DVec3::from_array(p.map(f64::from)));
    let (mut reflectance, mut radiance) = (DVec3::ZERO, DVec3::ZERO);
    for i in 0..count.max(1) {
        let [x, y, ..] = sequence.sample(i);
        let (s, t) = square_to_triangle(x, y);
        let point = a + f64::from(s) * (b - a) + f64::from(t) * (c - a);
        let (u, v) = weights(surface.corners(triangle), point);
        reflectance += colour_of(surfaces.reflectance(triangle, u, v));
        for &other in &shining {
            let (u, v) = weights(surface.corners(other), point);
            radiance += colour_of(surfaces.emission(other, u, v));
        }
    }
    let count = f64::from(count.max(1));
    (reflectance / count, radiance / count)
}

fn is_textured(surface: &Surface, triangle: u32) -> bool {
    let material = surface.scene.mesh.triangle_material[triangle as usize];
    let material = &surface.scene.materials.materials[material as usize];
    material.reflectance_texture.is_some() || material.emission_texture.is_some()
}

fn colour_of(c: [f32; 3]) -> DVec3 {
    DVec3::from_array(c.map(f64::from))
}

/// Barycentric weights of the second and third corner at a point of a triangle.
fn weights([a, b, c]: [DVec3; 3], point: DVec3) -> (f32, f32) {
    let normal = (b - a).cross(c - a);
    let inverse = 1.0 / normal.length_squared();
    let u = (point - a).cross(c - a).dot(normal) * inverse;
    let v = (b - a).cross(point - a).dot(normal) * inverse;
    let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
    let excess = (u + v).max(1.0);
    ((u / excess) as f32, (v / excess) as f32)
}

/// Flux that the scene's emissive triangles emit, W; independent of how patches were cut and sampled.
pub fn emitted_flux(surface: &Surface, surfaces: &Surfaces) -> [f64; 3] {
    let emitters = surfaces.emitters();
    let most = (FLUX_SAMPLES / emitters.len().max(1)).clamp(64, 1 << 14) as u32;
    let flux = |&t: &u32| {
        let count = if is_textured(surface, t) { most } else { 1 };
        let sequence = Sobol::new(t);
        let sum: DVec3 = (0..count)
            .map(|i| {
                let [x, y, ..] = sequence.sample(i);
                let (u, v) = square_to_triangle(x, y);
                colour_of(surfaces.emission(t, u, v))
            })
            .sum();
        PI * surface.area[t as usize] / f64::from(count) * sum
    };
    let each: Vec<DVec3> = emitters.par_iter().map(flux).collect();
    each.into_iter().sum::<DVec3>().to_array()
}
