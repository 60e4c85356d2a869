//! What all rivals are given.

use std::sync::atomic::AtomicU64;

use glam::Vec3;
use scene::{LightRig, Rays, Scene, SurfacePoint, Surfaces};

use crate::{
    PathTracer,
    path_tracer::{DirectNumbers, Glow, Landing, Vertex},
};

/// A scene and the points of its surfaces whose irradiance is asked for.
#[derive(Clone, Copy)]
pub struct Setting<'a> {
    /// Triangles and materials.
    pub scene: &'a Scene,
    /// What they reflect and emit.
    pub surfaces: &'a Surfaces<'a>,
    /// Rays against them.
    pub rays: &'a Rays,
    /// Receivers: position (local axes, metres), unit normal on the side that receives, triangle (or [`scene::NO_TRIANGLE`]).
    pub receivers: &'a [SurfacePoint],
}

/// The lights of one frame over a setting.
pub struct Lights<'a>(PathTracer<'a>);

impl<'a> Setting<'a> {
    /// The lights of `rig`.
    pub fn lights(&self, rig: &LightRig) -> Lights<'a> {
        Lights(PathTracer::new(self.scene, self.surfaces, self.rays, rig))
    }
}

impl Lights<'_> {
    /// Direct irradiance at a point, W/m²: points, spots and suns exactly, one shadow ray each; quads, emitting surfaces and
    /// the sky by `samples` pairs of rays, of which none are sent where there are no such lights.
    ///
    /// `point` is on its surface, not raised; `seed` chooses the rays.
    pub fn irradiance(&self, point: &SurfacePoint, samples: u32, seed: u32) -> Vec3 {
        let rays = AtomicU64::new(0);
        let at = Vertex::above(self.0.rays(), point);
        self.0.direct(at, &rays, DirectNumbers { samples, seed })
    }

    /// Where `paths` photons land that set out from the lights and go on up to `bounces` times: virtual lights, or flux
    /// for a grid. `seed` chooses the paths.
    pub(crate) fn landings(&self, paths: u32, bounces: u32, seed: u32) -> Vec<Landing> {
        self.0.landings(paths, bounces, seed)
    }

    /// Points of quads and emitting surfaces, `samples` of them or none, in proportion to their power; `seed` chooses them.
    pub(crate) fn glows(&self, samples: u32, seed: u32) -> Vec<Glow> {
        (0..samples).map_while(|path| self.0.glow(seed, path)).collect()
    }
}
