//! Lamps to try a scene with before anybody has said where its lights will be.
//!
//! They hang where real ones could: in the air before a patch that is chosen by area, about half way to what lies
//! opposite, if there is room. Walls shade them. Every fifth is a sun, if any of it comes in.

use glam::Vec3;
use radfile::Patches;
use rayon::prelude::*;
use scene::{NO_TRIANGLE, PatchSampler, Rays, Sobol, SurfacePoint, hash};

/// Part of the way to what lies opposite at which lamps hang.
const HEIGHT: [f32; 2] = [0.3, 0.7];
/// Least way to what lies opposite, in diagonals of the scene: nobody hangs a lamp between the boards of a shelf.
const ROOM: f32 = 0.06;
/// Radius of lamps, in diagonals of the scene.
const RADIUS: f32 = 0.04;
/// The way where nothing lies opposite.
const OPEN: f32 = 0.4;
/// Places that are tried for a lamp.
const TRIES: u32 = 64;

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
    let upto = patches.area.iter().zip(outside).map(&mut upto).collect();
    let fold =
        |f: fn(Vec3, Vec3) -> Vec3| patches.position.iter().map(|&p| Vec3::from(p)).reduce(f).unwrap_or_default();
    let diagonal = (fold(Vec3::max) - fold(Vec3::min)).length();
    let places = Places { sampler: PatchSampler::new(patches), upto, rays, diagonal };
    let lamp = |number: u32| {
        let sobol = Sobol::new(hash(seed, number));
        let sun = (number % 5 == 4).then(|| places.sun(&sobol)).flatten();
        sun.map_or_else(|| Lamp::Ball { centre: places.airy(&sobol), radius: RADIUS * diagonal }, Lamp::Sun)
    };
    (0..count).map(lamp).collect()
}

/// Where lamps can be.
struct Places<'a> {
    sampler: PatchSampler<'a>,
    /// Area of the patches up to and including each, m².
    upto: Vec<f64>,
    rays: &'a Rays,
    /// Of the scene, metres.
    diagonal: f32,
}

impl Places<'_> {
    /// A point of a patch chosen by area, moved off it.
    fn point(&self, [x, y, z]: [f32; 3]) -> (Vec3, Vec3) {
        let all = self.upto.last().copied().unwrap_or_default();
        let patch = self.upto.partition_point(|&u| u <= f64::from(x) * all).min(self.upto.len() - 1);
        let point = self.sampler.point(patch, y, z);
        (self.rays.off_surface(point.position, point.normal), point.normal)
    }

    /// The first place with room, or the last that was tried.
    fn airy(&self, sobol: &Sobol) -> Vec3 {
        let mut place = Vec3::ZERO;
        for k in 0..TRIES {
            let [x, y, z, w] = sobol.sample(k);
            let (origin, normal) = self.point([x, y, z]);
            let opposite = self.rays.closest(origin, normal, f32::INFINITY, NO_TRIANGLE);
            let free = opposite.map_or(OPEN * self.diagonal, |hit| hit.t);
            place = origin + (HEIGHT[0] + w * (HEIGHT[1] - HEIGHT[0])) * free * normal;
            if free > ROOM * self.diagonal {
                break;
            }
        }
        place
    }

    /// A direction that some patch sees the sky in.
    fn sun(&self, sobol: &Sobol) -> Option<Vec3> {
        let [x, y, ..] = sobol.sample(0);
        let (height, (sin, cos)) = (2.0 * y - 1.0, (std::f32::consts::TAU * x).sin_cos());
        let radius = (1.0 - height * height).max(0.0).sqrt();
        let towards = Vec3::new(radius * cos, height, radius * sin);
        let comes_in = |k: u32| {
            let [x, y, z, _] = sobol.sample(k);
            let (origin, normal) = self.point([x, y, z]);
            towards.dot(normal) > 0.0 && self.rays.escapes(origin, towards, NO_TRIANGLE)
        };
        (1..=TRIES).any(comes_in).then_some(towards)
    }
}
