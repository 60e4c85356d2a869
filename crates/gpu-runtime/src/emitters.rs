//! Samples of the scene's shining surfaces.
//!
//! A fixed number of points is spread over all emitting triangles, in proportion to what each emits
//! (systematic sampling along the running sum of the flux), so many small lamps cost no more than a big one.

use glam::{DVec3, Vec3};
use scene::{Scene, Sobol, Surfaces, square_to_triangle};

use crate::Result;

/// A small piece of a shining surface.
pub struct Emitter {
    /// Its middle, local axes, metres.
    pub position: DVec3,
    /// The side that shines.
    pub normal: DVec3,
    /// Radiance, W/(m² sr).
    pub radiance: [f32; 3],
    /// The area that it stands for, m².
    pub area: f32,
}

/// Points of a triangle at which its emission is looked up for its share of the samples.
const LOOKS: u32 = 16;

/// About `count` samples of what emits in the scene.
pub fn sample(scene: &Scene, count: u32, seed: u32) -> Result<Vec<Emitter>> {
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials)?;
    let sobol = Sobol::new(seed);
    let point = |i: u32| {
        let [x, y, ..] = sobol.sample(i);
        square_to_triangle(x, y)
    };
    // Triangle, area, flux (up to a factor that is the same for all).
    let mut emitters: Vec<(u32, f64, f64)> = Vec::new();
    for t in surfaces.emitters() {
        let area = 0.5 * normal_of(scene, t).length();
        let bright = |i| surfaces.emission(t, point(i).0, point(i).1).iter().map(|&v| f64::from(v)).sum::<f64>();
        let mean = (0..LOOKS).map(bright).sum::<f64>() / f64::from(LOOKS);
        if area * mean > 0.0 {
            emitters.push((t, area, area * mean));
        }
    }
    let total: f64 = emitters.iter().map(|e| e.2).sum();
    let mut samples = Vec::with_capacity(count as usize);
    let mut passed = 0.0;
    for (t, area, flux) in emitters {
        let from = passed;
        passed += flux * f64::from(count) / total;
        // Sample k sits at k + 1/2 of the running sum.
        let inside = (from - 0.5).ceil() as u32..(passed - 0.5).ceil().max(0.0) as u32;
        // A triangle that expects a sample has one, and its samples share its area; of the smaller ones a few
        // stand for all.
        let expected = passed - from;
        let share = if expected >= 1.0 { area / inside.len() as f64 } else { area / expected };
        for k in inside {
            let (u, v) = point(k);
            let [a, b, c] = scene.mesh.corners(t as usize).map(|p| Vec3::from(p).as_dvec3());
            samples.push(Emitter {
                position: a + f64::from(u) * (b - a) + f64::from(v) * (c - a),
                normal: normal_of(scene, t).normalize(),
                radiance: surfaces.emission(t, u, v),
                area: share as f32,
            });
        }
    }
    Ok(samples)
}

/// Normal of the front of a triangle, as long as twice its area.
fn normal_of(scene: &Scene, triangle: u32) -> DVec3 {
    let [a, b, c] = scene.mesh.corners(triangle as usize).map(|p| Vec3::from(p).as_dvec3());
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use radfile::{Material, Materials, Mesh};

    use super::*;

    fn scene(emission: [f32; 2]) -> Scene {
        let material = |emission: f32| Material {
            name: "m".into(),
            reflectance: [0.5; 3],
            reflectance_texture: None,
            emission: [emission; 3],
            emission_texture: None,
        };
        let mesh = Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 3, 4]],
            triangle_material: vec![0, 1],
            ..Mesh::default()
        };
        let materials = Materials { materials: emission.map(material).into(), textures: vec![] };
        Scene { mesh, materials, ..Scene::default() }
    }

    #[test]
    fn samples_carry_the_flux_of_all_emitters() {
        let samples = sample(&scene([2.0, 3.0]), 64, 1).unwrap();
        let flux: f32 = samples.iter().map(|e| e.radiance[0] * e.area).sum();
        assert_eq!(samples.len(), 64);
        // Areas 0.5 and 2; both expect samples, so nothing is lost but rounding.
        assert!((flux - (0.5 * 2.0 + 2.0 * 3.0)).abs() < 1e-5, "{flux}");
        assert!(samples.iter().all(|e| e.normal == DVec3::Z));
    }

    #[test]
    fn what_does_not_emit_has_no_samples() {
        assert!(sample(&scene([0.0, 0.0]), 64, 1).unwrap().is_empty());
    }
}
