//! A diffuse path tracer with next-event estimation.
//!
//! Source: J. T. Kajiya, The rendering equation, SIGGRAPH 1986; E. Veach, Robust Monte Carlo methods
//! for light transport simulation, 1997, chapters 9 (multiple importance sampling) and 10 (roulette).

mod area_lights;
mod direct;
mod emission;
mod lamps;
mod landings;
mod path;
mod picture;
mod points;
mod random;
mod view;

use std::{
    cell::Cell,
    sync::atomic::{AtomicU64, Ordering},
};

use glam::{DVec3, Vec3};
use radfile::Mesh;
use scene::{Hit, Light, LightRig, Rays, Scene, Surfaces};

use area_lights::AreaLights;
use emission::Photon;
use lamps::Lamps;

pub use area_lights::Glow;
pub use direct::DirectNumbers;
pub use landings::Landing;
pub use picture::{Picture, PictureReport};
pub use points::{PointEstimate, PointReport};

use crate::Stop;

/// How paths are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// When it is enough.
    pub stop: Stop,
    /// Chooses the paths: answers of different seeds have independent errors.
    pub seed: u32,
}

/// A scene and what shines in it.
pub struct PathTracer<'a> {
    mesh: &'a Mesh,
    surfaces: &'a Surfaces<'a>,
    rays: &'a Rays,
    lamps: Lamps,
    area: AreaLights<'a>,
    /// Radiance of every direction that leaves the scene, W/(m² sr).
    sky: Vec3,
}

impl<'a> PathTracer<'a> {
    /// The lights of `rig`, which are in the axes of the scene file, over `scene`; `surfaces` and `rays` are
    /// made of its mesh.
    pub fn new(scene: &'a Scene, surfaces: &'a Surfaces<'a>, rays: &'a Rays, rig: &LightRig) -> PathTracer<'a> {
        let radiance = |light: &Light| match light {
            Light::Sky { radiance } => Vec3::from(*radiance),
            _ => Vec3::ZERO,
        };
        PathTracer {
            mesh: &scene.mesh,
            surfaces,
            rays,
            lamps: Lamps::new(rig, scene.mesh.origin),
            area: AreaLights::new(scene, surfaces, rig, rays.gap()),
            sky: rig.lights.iter().map(radiance).sum(),
        }
    }

    /// A point of the scene file's axes about the local origin.
    fn local(&self, position: [f64; 3]) -> Vec3 {
        (DVec3::from(position) - DVec3::from(self.mesh.origin)).as_vec3()
    }

    fn counted<'b>(&'b self, total: &'b AtomicU64) -> CountedRays<'b> {
        CountedRays { rays: self.rays, count: Cell::new(0), total }
    }
}

/// A point that receives light, raised off its surface.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    position: Vec3,
    /// Unit normal of the side that receives.
    normal: Vec3,
    /// Its triangle, which rays from here pass through.
    triangle: u32,
}

/// The ray query, and how often it was asked.
struct CountedRays<'a> {
    rays: &'a Rays,
    count: Cell<u64>,
    total: &'a AtomicU64,
}

impl CountedRays<'_> {
    fn one(&self) -> &Rays {
        self.count.set(self.count.get() + 1);
        self.rays
    }

    fn closest(&self, origin: Vec3, direction: Vec3, ignore: u32) -> Option<Hit> {
        self.one().closest(origin, direction, f32::INFINITY, ignore)
    }

    fn visible(&self, from: &Vertex, to: Vec3) -> bool {
        self.one().visible(from.position, to, from.triangle)
    }

    fn escapes(&self, from: &Vertex, direction: Vec3) -> bool {
        self.one().escapes(from.position, direction, from.triangle)
    }
}

impl Drop for CountedRays<'_> {
    fn drop(&mut self) {
        self.total.fetch_add(self.count.get(), Ordering::Relaxed);
    }
}
