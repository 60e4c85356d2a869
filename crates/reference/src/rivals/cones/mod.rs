//! Voxel cone tracing.
//!
//! Source: C. Crassin, F. Neyret, M. Sainz, S. Green, E. Eisemann, Interactive indirect illumination using voxel cone
//! tracing, Computer Graphics Forum 30(7), 2011. Direct light is injected into voxels of the surfaces, which are filtered to
//! coarser ones that send light six ways; receivers gather by cones. Instead of the octree an array finds the voxels, as is usual
//! since; light is injected from points of the surfaces with shadow rays instead of a shadow map, which is the more exact.
//! The number of cones is free, and light goes on for more bounces than their two.
//!
//! What it cannot do: voxels are fog, so light leaks where walls meet or are thinner than a cell, and cones miss what lies
//! within their first cell. In a closed room of one grey 0.93 of the first bounce arrives, whatever the cells and cones, and
//! 0.87 of eight. In the Cornell box one bounce of 32 cells is off by these RMS errors against paths (lamp, bulb): 6 cones
//! 36 %, 38 %; 12: 26 %, 32 %; 24: 24 %, 27 %; 64: 19 %, 20 %; its bias is -7 to -13 %. Cones of twice the width blur, with
//! 12 of them 32 %, 36 %; of half the width 6 miss lights between them, 40 %, 59 %. All bounces, of which the lost parts
//! multiply: two of them alone leave 30 to 40 % out; eight leave 10 to 16 % out, at 26 % and 29 % RMS. Finer voxels than 16
//! along the box change little. In the bundled apartment, 14 m long, they do: all bounces are 123 % off with 16 cells along it, 82 %
//! with 32, 77 % with 64 and 71 % with 128, at four to seven times the time each (`docs/charts/rivals-apartment.md`).

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

/// Cones of a point from which voxels are lit by further bounces: the light of many points is averaged.
const POINT_CONES: u32 = 6;

/// A point and the light of its two sides: direct, gathered, and the sum of both.
const BYTES_A_POINT: u64 = (size_of::<Point>() + 3 * size_of::<[Vec3; 2]>()) as u64;

/// How a scene is voxelised and lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeParams {
    /// Cells along the longest edge of the scene, 2 to 1024.
    pub resolution: u32,
    /// Bounces: each beyond the first gathers light into the voxels once more. At least 1. The paper's: 2.
    pub bounces: u32,
    /// Cones of a receiver, at least 1. Points of voxels have six.
    pub cones: u32,
    /// Points of a voxel's surface at which light is injected, at most.
    pub points: u32,
    /// Pairs of rays from a point to quads, emitting surfaces and the sky.
    pub samples: u32,
    /// Chooses these rays.
    pub seed: u32,
}

impl Default for ConeParams {
    fn default() -> ConeParams {
        ConeParams { resolution: 32, bounces: 8, cones: 24, points: 2, samples: 4, seed: 1 }
    }
}

/// Voxels of one setting.
pub struct VoxelCones<'a> {
    setting: Setting<'a>,
    options: ConeParams,
    pyramid: Pyramid,
}

impl<'a> VoxelCones<'a> {
    /// Bytes of the voxels and their light, at most; ask for them before [`VoxelCones::new`].
    pub fn bytes_needed(setting: &Setting, options: &ConeParams) -> u64 {
        let most = grid::most(setting, checked(*options).resolution);
        let points = most.finest * u64::from(options.points.max(1));
        most.cells * size_of::<u32>() as u64 + most.voxels * Pyramid::BYTES_A_VOXEL + points * BYTES_A_POINT
    }

    /// Voxelises.
    pub fn new(setting: Setting<'a>, options: ConeParams) -> VoxelCones<'a> {
        let options = checked(options);
        let pyramid = Pyramid::new(Grid::new(&setting, options.resolution, options.points));
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

/// Within what is possible.
fn checked(options: ConeParams) -> ConeParams {
    let ConeParams { resolution, bounces, cones, .. } = options;
    ConeParams { resolution: resolution.clamp(2, 1024), bounces: bounces.max(1), cones: cones.max(1), ..options }
}

impl Rival for VoxelCones<'_> {
    fn name(&self) -> String {
        let ConeParams { resolution, bounces, cones, .. } = self.options;
        format!("voxel cones, {resolution} cells, {cones} cones, {bounces} bounces")
    }

    fn indirect(&mut self, rig: &LightRig, progress: &dyn Progress) -> Vec<[f32; 3]> {
        let ConeParams { samples, seed, bounces, cones, .. } = self.options;
        progress.begin("voxel cones", u64::from(bounces) + 1);
        let lights = self.setting.lights(rig);
        let direct = self.both_sides(|number, at| lights.irradiance(at, samples, hash(seed, number)));
        let mut light = self.pyramid.light(&direct);
        progress.advance(1);
        for _ in 1..bounces {
            let gathered = self.both_sides(|_, at| self.pyramid.gather(&light, at, POINT_CONES));
            let sum = |(a, b): (&[Vec3; 2], &[Vec3; 2])| [a[0] + b[0], a[1] + b[1]];
            light = self.pyramid.light(&direct.iter().zip(&gathered).map(sum).collect::<Vec<_>>());
            progress.advance(1);
        }
        let lit = self.setting.receivers.par_iter().map(|r| self.pyramid.gather(&light, r, cones).to_array()).collect();
        progress.advance(1);
        lit
    }

    fn bytes(&self) -> u64 {
        self.pyramid.bytes()
    }
}
