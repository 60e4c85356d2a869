//! Voxel cone tracing.
//!
//! Source: C. Crassin, F. Neyret, M. Sainz, S. Green, E. Eisemann, Interactive indirect illumination using voxel cone
//! tracing, Computer Graphics Forum 30(7), 2011. Direct light is injected into voxels of the surfaces, which are filtered to
//! coarser ones that send light six ways; receivers gather by cones. Instead of the octree an array finds the voxels, as is usual
//! since; light is injected from points of the surfaces with shadow rays instead of a shadow map, which is the more exact.
//!
//! What it cannot do: voxels are fog, so light leaks where walls meet or are thinner than a cell, cones miss what lies within
//! their first cell, and six of them are a coarse hemisphere.

mod gather;
mod grid;
mod pyramid;

use glam::Vec3;
use radfile::Progress;
use rayon::prelude::*;
use scene::{LightRig, SurfacePoint, hash};

use self::{
    grid::{Grid, Point},
    pyramid::Pyramid,
};
use super::{Rival, Setting};

/// How a scene is voxelised and lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeParams {
    /// Cells along the longest edge of the scene, 2 to 1024.
    pub resolution: u32,
    /// Bounces: each beyond the first gathers light into the voxels once more. At least 1.
    pub bounces: u32,
    /// Points of a voxel's surface at which light is injected, at most.
    pub points: u32,
    /// Pairs of rays from a point to quads, emitting surfaces and the sky.
    pub samples: u32,
    /// Chooses these rays.
    pub seed: u32,
}

impl Default for ConeParams {
    fn default() -> ConeParams {
        ConeParams { resolution: 64, bounces: 2, points: 2, samples: 4, seed: 1 }
    }
}

/// Voxels of one setting.
pub struct VoxelCones<'a> {
    setting: Setting<'a>,
    options: ConeParams,
    pyramid: Pyramid,
}

impl<'a> VoxelCones<'a> {
    /// Voxelises. The array that finds voxels takes up to 4 · resolution³ · 8 / 7 bytes.
    pub fn new(setting: Setting<'a>, options: ConeParams) -> VoxelCones<'a> {
        let resolution = options.resolution.clamp(2, 1024);
        let options = ConeParams { resolution, bounces: options.bounces.max(1), ..options };
        let pyramid = Pyramid::new(Grid::new(&setting, resolution, options.points));
        VoxelCones { setting, options, pyramid }
    }

    /// What `irradiance(number, side)` finds for the front and the back of every point of the voxels.
    fn both_sides(&self, irradiance: impl Fn(u32, &SurfacePoint) -> Vec3 + Sync) -> Vec<[Vec3; 2]> {
        let one = |(number, Point { at, .. }): (usize, &Point)| {
            let back = SurfacePoint { normal: -at.normal, ..*at };
            [irradiance(2 * number as u32, at), irradiance(2 * number as u32 + 1, &back)]
        };
        self.pyramid.grid.points.par_iter().enumerate().map(one).collect()
    }
}

impl Rival for VoxelCones<'_> {
    fn name(&self) -> String {
        let ConeParams { resolution, bounces, .. } = self.options;
        format!("voxel cones, {resolution} cells, {bounces} bounces")
    }

    fn indirect(&mut self, rig: &LightRig, progress: &dyn Progress) -> Vec<[f32; 3]> {
        let ConeParams { samples, seed, bounces, .. } = self.options;
        progress.begin("voxel cones", u64::from(bounces) + 1);
        let lights = self.setting.lights(rig);
        let direct = self.both_sides(|number, at| lights.irradiance(at, samples, hash(seed, number)));
        let mut light = self.pyramid.light(&direct);
        progress.advance(1);
        for _ in 1..bounces {
            let gathered = self.both_sides(|_, at| self.pyramid.gather(&light, at));
            let sum = |(a, b): (&[Vec3; 2], &[Vec3; 2])| [a[0] + b[0], a[1] + b[1]];
            light = self.pyramid.light(&direct.iter().zip(&gathered).map(sum).collect::<Vec<_>>());
            progress.advance(1);
        }
        let lit = self.setting.receivers.par_iter().map(|r| self.pyramid.gather(&light, r).to_array()).collect();
        progress.advance(1);
        lit
    }

    fn bytes(&self) -> u64 {
        self.pyramid.bytes()
    }
}
