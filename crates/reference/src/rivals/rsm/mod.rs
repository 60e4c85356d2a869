//! Reflective shadow maps: every pixel of what a light sees is a small light, and nothing is in its way.
//!
//! Source: C. Dachsbacher, M. Stamminger, Reflective Shadow Maps, I3D 2005. One bounce. A receiver gathers from some pixels
//! about its own projection in the map, nearer ones more densely. Their interpolation between the pixels of a
//! picture is not made: receivers are not in a picture.
//!
//! What it cannot do: more than one bounce, and shadows of it. In an empty room lit by a bulb it is one bounce: 0.6 % too
//! little in the mean, 2.5 % RMS with 256² pixels and 400 samples. In the Cornell box, where boxes are in the way, it is 17 %
//! too much of one bounce; of all bounces it leaves 44 % out, however many the samples.

mod eye;
mod eyes;
mod map;

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use radfile::Progress;
use rayon::prelude::*;
use scene::{LightRig, SurfacePoint, hash};

pub use map::{Map, Pixel};

use super::{Rival, Setting};

/// How reflective shadow maps are made and gathered from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowMapParams {
    /// Pixels along each side of a map. The paper's: 512.
    pub side: usize,
    /// Pixels that a receiver gathers from, shared by all maps in proportion to the flux they reflect. The paper's: 400.
    pub samples: u32,
    /// The largest distance of a pixel from the receiver's projection, as a part of the map's largest. 1 reaches all of it
    /// from everywhere, less leaves light out.
    pub reach: f32,
    /// Metres that pixels are moved behind their surface, as a part of the scene's diagonal.
    pub offset: f32,
    /// Maps for all quads and emitting surfaces together, and for the sky; these have as many pixels together as one other.
    pub shared_maps: u32,
}

impl Default for ShadowMapParams {
    fn default() -> ShadowMapParams {
        ShadowMapParams { side: 256, samples: 400, reach: 1.0, offset: 0.003, shared_maps: 16 }
    }
}

/// The method, for one setting.
pub struct ReflectiveShadowMaps<'a> {
    setting: Setting<'a>,
    params: ShadowMapParams,
    /// Metres that pixels are moved behind their surface.
    offset: f32,
    /// Directions of the pattern: any first few cover the circle.
    circle: Vec<Vec2>,
}

impl<'a> ReflectiveShadowMaps<'a> {
    /// Prepares the pattern.
    pub fn new(setting: Setting<'a>, params: ShadowMapParams) -> ReflectiveShadowMaps<'a> {
        let offset = params.offset * diagonal(&setting);
        let circle = (0..params.samples.max(1)).map(|i| Vec2::from_angle(TAU * fraction(i.reverse_bits()))).collect();
        ReflectiveShadowMaps { setting, params, offset, circle }
    }

    /// Irradiance at a receiver of all maps, W/m².
    fn gather(&self, maps: &[(Map, u32)], receiver: usize) -> Vec3 {
        let point = &self.setting.receivers[receiver];
        let seed = hash(0x0072_736d, receiver as u32);
        let one = |(number, (map, samples)): (usize, &(Map, u32))| {
            self.of_map(map, *samples, point, hash(seed, number as u32))
        };
        maps.iter().enumerate().map(one).sum()
    }

    /// Irradiance of one map, from `samples` of its pixels.
    ///
    /// The paper's pattern: radius ξ₁ and angle 2πξ₂, so that density falls as 1/radius, made up for by the
    /// weight.
    /// The paper weighs by ξ₁²; what keeps the mean right is 2ξ₁ times the area of the disk. Its one pattern for all
    /// receivers is turned and shifted for each, noise instead of bands.
    fn of_map(&self, map: &Map, samples: u32, point: &SurfacePoint, seed: u32) -> Vec3 {
        let about = map.about(point.position);
        let (shift, turn) = (fraction(seed), Vec2::from_angle(TAU * fraction(hash(seed, 1))));
        let mut sum = Vec3::ZERO;
        for i in 0..samples {
            let near = (i as f32 + shift) / samples as f32;
            if let Some(pixel) = about.pixel(self.params.reach * near * turn.rotate(self.circle[i as usize])) {
                sum += near * self.irradiance(pixel, point);
            }
        }
        sum * (2.0 * self.params.reach.powi(2) * about.pixels / samples as f32)
    }

    /// Irradiance of one pixel (the paper's, with another unit: our flux is that of the hemisphere, π times theirs). Near a common edge
    /// of two walls it grows without bound; as in the paper, pixels are moved along their negative normal. Those that
    /// then are on the other side of a sheet do not shine there; positions are known to less than four gaps.
    fn irradiance(&self, pixel: &Pixel, point: &SurfacePoint) -> Vec3 {
        let way = point.position - pixel.position;
        let moved = way + self.offset * pixel.normal;
        let (before, leaving, facing) = (pixel.normal.dot(way), pixel.normal.dot(moved), -point.normal.dot(moved));
        if !(before > 4.0 * self.setting.rays.gap() && facing > 0.0) {
            return Vec3::ZERO;
        }
        pixel.flux * (leaving * facing / (PI * moved.length_squared().powi(2)))
    }
}

impl Rival for ReflectiveShadowMaps<'_> {
    fn name(&self) -> String {
        format!("reflective shadow maps, {}², {} samples", self.params.side, self.params.samples)
    }

    fn indirect(&mut self, rig: &LightRig, progress: &dyn Progress) -> Vec<[f32; 3]> {
        let maps =
            with_samples(maps(&self.setting, rig, self.params.side, self.params.shared_maps), self.params.samples);
        let count = self.setting.receivers.len();
        progress.begin("gathering", count as u64);
        let one = |receiver| {
            let light = self.gather(&maps, receiver).to_array();
            progress.advance(1);
            light
        };
        (0..count).into_par_iter().map(one).collect()
    }

    fn bytes(&self) -> u64 {
        0
    }
}

/// The maps of all lights of a rig that reflect anything.
pub fn maps(setting: &Setting, rig: &LightRig, side: usize, shared: u32) -> Vec<Map> {
    let small = ((side as f32 / (shared as f32).sqrt()).ceil() as usize).max(1);
    let sided = |(eye, alone)| Map::new(setting, eye, if alone { side } else { small });
    eyes::eyes(setting, rig, shared).into_iter().map(sided).filter(|map| map.power() > 0.0).collect()
}

/// A number in [0, 1).
fn fraction(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// Shares samples among maps by flux, at least one each.
fn with_samples(maps: Vec<Map>, samples: u32) -> Vec<(Map, u32)> {
    let total: f64 = maps.iter().map(Map::power).sum();
    let share = |map: &Map| ((f64::from(samples) * map.power() / total).round() as u32).max(1);
    maps.into_iter()
        .map(|map| {
            let samples = share(&map);
            (map, samples)
        })
        .collect()
}

/// Length of the diagonal of the scene's bounds, metres.
fn diagonal(setting: &Setting) -> f32 {
    let points = setting.scene.mesh.positions.iter().map(|&p| Vec3::from(p));
    let (low, high) = points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    if low.x <= high.x { low.distance(high) } else { 0.0 }
}
