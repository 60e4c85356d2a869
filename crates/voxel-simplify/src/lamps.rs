//! Lamps to try a scene with before anybody has said where its lights will be.
//!
//! They hang where real ones could ([`Air`]), before a patch that is chosen by area. Walls shade them. Every fifth is a
//! sun, if any of it comes in.

use glam::Vec3;
use radfile::Patches;
use rayon::prelude::*;
use scene::{Air, PatchSampler, Rays, Sobol, SurfacePoint, hash};

/// Radius of lamps, in diagonals of the scene.
const RADIUS: f32 = 0.04;

/// Light of one kind.
pub enum Lamp {
    /// 1 W/sr from a place; from near it counts as a ball of some size, or one bright spot would be all that counts.
    Ball { centre: Vec3, radius: f32 },
    /// 1 W/m² from this direction, where the sky is.
    Sun(Vec3),
}

impl Lamp {
    /// Irradiance at a point, W/m².
    fn irradiance(&self, at: &SurfacePoint, rays: &Rays) -> f32 {
        let origin = rays.off_surface(at.position, at.normal);
        match self {
            Lamp::Ball { centre, radius } => {
                let way = *centre - origin;
                let height = way.dot(at.normal);
                let lit = height > 0.0 && rays.visible(origin, *centre, at.triangle);
                if lit { height / (way.length_squared() + radius * radius).powf(1.5) } else { 0.0 }
            }
            Lamp::Sun(towards) => {
                let cosine = towards.dot(at.normal);
                if cosine > 0.0 && rays.escapes(origin, *towards, at.triangle) { cosine } else { 0.0 }
            }
        }
    }
}

/// Direct irradiance of patches, a mean over `points` of each, W/m²: patches × lamps.
pub fn direct_light(patches: &Patches, lamps: &[Lamp], points: u32, rays: &Rays, seed: u32) -> Vec<f32> {
    let sampler = PatchSampler::new(patches);
    let of_patch = |patch: usize| {
        let sobol = Sobol::new(hash(seed, patch as u32));
        let mut sum = vec![0.0; lamps.len()];
        for k in 0..points {
            let [x, y, ..] = sobol.sample(k);
            let point = sampler.point(patch, x, y);
            sum.iter_mut().zip(lamps).for_each(|(sum, lamp)| *sum += lamp.irradiance(&point, rays) / points as f32);
        }
        sum
    };
    (0..patches.len()).into_par_iter().flat_map_iter(of_patch).collect()
}

/// `count` lamps in the air before those patches that lie `outside` of solids.
pub fn hang(patches: &Patches, outside: &[bool], count: u32, rays: &Rays, seed: u32) -> Vec<Lamp> {
    let mut sum = 0.0;
    let mut upto = |(area, outside): (&f32, &bool)| {
        sum += if *outside { f64::from(*area) } else { 0.0 };
        sum
    };
    let upto: Vec<f64> = patches.area.iter().zip(outside).map(&mut upto).collect();
    let fold =
        |f: fn(Vec3, Vec3) -> Vec3| patches.position.iter().map(|&p| Vec3::from(p)).reduce(f).unwrap_or_default();
    let diagonal = (fold(Vec3::max) - fold(Vec3::min)).length();
    let sampler = PatchSampler::new(patches);
    // A point of a patch chosen by area.
    let point = |[x, y, z]: [f32; 3]| {
        let all = upto.last().copied().unwrap_or_default();
        let patch = upto.partition_point(|&u| u <= f64::from(x) * all).min(upto.len() - 1);
        let point = sampler.point(patch, y, z);
        (rays.off_surface(point.position, point.normal), point.normal)
    };
    let air = Air { rays, diagonal, point };
    let lamp = |number: u32| {
        let sobol = Sobol::new(hash(seed, number));
        let sun = (number % 5 == 4).then(|| air.sun(&sobol)).flatten();
        sun.map_or_else(|| Lamp::Ball { centre: air.place(&sobol).0, radius: RADIUS * diagonal }, Lamp::Sun)
    };
    (0..count).map(lamp).collect()
}
