//! Light of very many emissive triangles: more than closed forms could be evaluated for.
//!
//! Half of the rays go to points drawn on the emitters by emitted flux, which finds small lamps; the
//! other half go where the cosine sends them, which keeps the noise of large emitters nearby
//! bounded. Both are weighed by the balance heuristic.
//! Source: E. Veach, L. Guibas, Optimally Combining Sampling Techniques for Monte Carlo
//! Rendering, 1995.

use std::{collections::HashMap, f64::consts::PI};

use scene::{NO_TRIANGLE, Sobol, Surfaces, cosine_direction, hash};

use crate::emitters::{Emitter, Light, Receiver, Sample};

/// Rays each way for one sample of a single light.
const RAYS_PER_SAMPLE: u32 = 2;

/// Emitters by emitted flux.
pub struct Crowd {
    /// Up to and including each emitter, its share of the emitted flux.
    share: Vec<f64>,
    /// Density of points drawn on each emitter, 1/m².
    density: Vec<f64>,
    /// Which emitter a triangle of the mesh is.
    emitter: HashMap<u32, usize>,
}

impl Crowd {
    /// Prepares the emitters.
    pub fn new(emitters: &[Emitter], surfaces: &Surfaces) -> Crowd {
        let flux: Vec<f64> = emitters.iter().map(|e| e.area() * e.mean_radiance(surfaces)).collect();
        let total = flux.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let share = flux.iter().scan(0.0, |sum, flux| {
            *sum += flux / total;
            Some(*sum)
        });
        let numbered = emitters.iter().enumerate();
        Crowd {
            share: share.collect(),
            density: emitters.iter().zip(&flux).map(|(e, flux)| flux / total / e.area()).collect(),
            emitter: numbered.filter_map(|(k, e)| Some((e.mesh_triangle()?, k))).collect(),
        }
    }

    /// Irradiance of all emitters at a place, W/m².
    pub fn irradiance(&self, emitters: &[Emitter], light: &Light, at: &Receiver, samples: u32, seed: u32) -> [f64; 3] {
        let rays = RAYS_PER_SAMPLE * samples;
        let (drawn, met) = (Sobol::new(hash(seed, 1)), Sobol::new(hash(seed, 2)));
        let mut sum = [0.0; 3];
        for i in 0..rays {
            for light in
                [self.drawn(emitters, light, at, drawn.sample(i)), self.met(emitters, light, at, met.sample(i))]
            {
                sum = std::array::from_fn(|c| sum[c] + light[c]);
            }
        }
        sum.map(|s| s / f64::from(rays))
    }

    /// A point drawn on an emitter, weighed by both ways of finding it.
    fn drawn(&self, emitters: &[Emitter], light: &Light, at: &Receiver, [choice, x, y, _]: [f32; 4]) -> [f64; 3] {
        let k = self.share.partition_point(|s| *s <= f64::from(choice)).min(emitters.len() - 1);
        let sample = emitters[k].sample(light.surfaces, x, y);
        let transport = emitters[k].transport(at, &sample);
        if transport > 0.0 && emitters[k].sees(light.rays, at, &sample) {
            let density = self.density[k] + transport / PI;
            sample.radiance.map(|l| l * transport / density)
        } else {
            [0.0; 3]
        }
    }

    /// What a cosine ray meets, weighed by both ways of finding it.
    fn met(&self, emitters: &[Emitter], light: &Light, at: &Receiver, [x, y, ..]: [f32; 4]) -> [f64; 3] {
        let direction = cosine_direction(at.normal, x, y);
        let Some(hit) = light.rays.closest(at.position, direction, f32::INFINITY, NO_TRIANGLE) else { return [0.0; 3] };
        let Some(&k) = self.emitter.get(&hit.triangle) else { return [0.0; 3] };
        let radiance = light.surfaces.emission(hit.triangle, hit.u, hit.v).map(f64::from);
        let sample = Sample { point: (at.position + hit.t * direction).as_dvec3(), radiance };
        let transport = emitters[k].transport(at, &sample); // 0 from behind
        let density = self.density[k] + transport / PI;
        if density > 0.0 { sample.radiance.map(|l| l * transport / density) } else { [0.0; 3] }
    }
}
