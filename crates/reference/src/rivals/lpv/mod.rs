//! Light propagation volumes: light of reflective shadow maps moves through a grid.
//!
//! Source: A. Kaplanyan, C. Dachsbacher, Cascaded Light Propagation Volumes for Real-Time Indirect Illumination, I3D
//! 2010: injection, geometry volume, propagation, and light that is reflected where it is stopped (their extension for
//! several bounces). Two cascades: cells over the whole scene, and cells of half their size over half of it about the
//! receivers.
//!
//! Where the paper steers by the camera, this steers by the receivers. Light that enters the fine cascade from outside is
//! taken from the coarse one, so that none is missing and none counted twice.
//!
//! What it cannot do: a step from cell to cell leaves light 0.3 of its direction (see the test of it), as if a medium
//! scattered it at every cell. Light stays about what it left and reaches what is far too weakly, the more so the finer the
//! cells: in the Cornell box one bounce is off by 45 to 53 % RMS with 4 to 8 cells along it and by 100 % with 16; the lit floor
//! gets twice and the ceiling a quarter of its light. A geometry volume of two bands stops 3/4 of what meets a wall head
//! on, so a closed room loses light at each bounce, and interpolation reaches behind walls. Of all bounces in a closed room
//! of one grey 0.7 arrive. In the Cornell box (lamp, bulb) their RMS errors are 43 %, 45 % with 6 cells, 38 %, 51 % with 8,
//! 68 %, 105 % with 16. Light that scatters needs many steps: with 8 cells 16 steps leave 31 % of it out, 32 steps 14 %,
//! 64 steps 8 %. In the bundled apartment, 14 m long, none is of use: 490 % with 6 cells, 168 % with 8, 241 % with 16, 606 %
//! with 32 (`docs/charts/rivals-apartment.md`).

mod blockers;
mod grid;
mod harmonics;
mod volume;

use std::f32::consts::PI;

use glam::Vec3;
use radfile::Progress;
use rayon::prelude::*;
use scene::{LightRig, SurfacePoint};

use blockers::Blockers;
use grid::Grid;
use harmonics::Colours;
use volume::{Propagation, Volume};

use super::{
    Rival, Setting,
    rsm::{Map, maps},
};

/// Cells over which the fine cascade takes over from the coarse one.
const BLEND: f32 = 2.0;

/// How light propagation volumes are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeParams {
    /// Cells along the longest side of a cascade. The paper's: 32. Light spreads at every step, so in a plain room
    /// 6 to 8 are nearest the truth.
    pub cells: u32,
    /// Steps that light goes, from cell to cell. One bounce needs about twice as many as there are cells, several bounces
    /// four to eight times as many.
    pub steps: u32,
    /// Whether light that is stopped is reflected: several bounces, otherwise one.
    pub bounces: bool,
    /// Pixels along each side of a shadow map, see [`super::ShadowMapParams::side`].
    pub map_side: usize,
    /// Maps for all quads and emitting surfaces together, and for the sky.
    pub shared_maps: u32,
}

impl Default for VolumeParams {
    fn default() -> VolumeParams {
        VolumeParams { cells: 8, steps: 32, bounces: true, map_side: 128, shared_maps: 16 }
    }
}

/// The method, for one setting.
pub struct LightPropagationVolumes<'a> {
    setting: Setting<'a>,
    params: VolumeParams,
    coarse: (Grid, Blockers),
    fine: (Grid, Blockers),
}

impl<'a> LightPropagationVolumes<'a> {
    /// Lays out both cascades and fills their geometry volumes.
    pub fn new(setting: Setting<'a>, params: VolumeParams) -> LightPropagationVolumes<'a> {
        let points = setting.scene.mesh.positions.iter().map(|&p| Vec3::from(p));
        let (low, high) = points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let sum: Vec3 = setting.receivers.iter().map(|r| r.position).sum();
        let quarter = 0.25 * (high - low);
        let centre = (sum / setting.receivers.len().max(1) as f32).clamp(low + quarter, high - quarter);
        let cascade = |low, high| {
            let grid = Grid::over(low, high, params.cells);
            (grid, Blockers::new(&setting, grid))
        };
        let (coarse, fine) = (cascade(low, high), cascade(centre - quarter, centre + quarter));
        LightPropagationVolumes { setting, params, coarse, fine }
    }

    /// All light of a cascade.
    fn fill(&self, cascade: &(Grid, Blockers), maps: &[Map], inflow: impl Fn(Vec3) -> Colours + Sync) -> Volume {
        let (grid, blockers) = cascade;
        Propagation::new(*grid, blockers, self.params.bounces).run(injected(grid, maps), inflow, self.params.steps)
    }
}

impl Rival for LightPropagationVolumes<'_> {
    fn name(&self) -> String {
        let VolumeParams { cells, steps, bounces, .. } = self.params;
        let bounces = if bounces { "several bounces" } else { "one bounce" };
        format!("light propagation volumes, 2 × {cells}³, {steps} steps, {bounces}")
    }

    fn indirect(&mut self, rig: &LightRig, progress: &dyn Progress) -> Vec<[f32; 3]> {
        progress.begin("filling light volumes", 2);
        let maps = maps(&self.setting, rig, self.params.map_side, self.params.shared_maps);
        let coarse = self.fill(&self.coarse, &maps, |_| Colours::default());
        progress.advance(1);
        // Intensity grows with the area of a cell.
        let smaller = (self.fine.0.cell / self.coarse.0.cell).powi(2);
        let inflow = |point| {
            let mut light = Colours::default();
            light.add(&coarse.at(point), smaller);
            light
        };
        let fine = self.fill(&self.fine, &maps, inflow);
        progress.advance(1);
        let light = |point: &SurfacePoint| {
            let weight = ((fine.grid().depth(point.position) - 1.0) / BLEND).clamp(0.0, 1.0);
            let [far, near] = [&coarse, &fine].map(|v| v.irradiance(point.position, point.normal));
            far.lerp(near, weight).to_array()
        };
        self.setting.receivers.par_iter().map(light).collect()
    }

    fn bytes(&self) -> u64 {
        self.coarse.1.bytes() + self.fine.1.bytes()
    }
}

/// The pixels of all maps as clamped cosines in the cells before them: each is moved half a cell along its normal, so that
/// it does not light what it lies on.
fn injected(grid: &Grid, maps: &[Map]) -> Vec<Colours> {
    let mut cells = vec![Colours::default(); grid.len()];
    for pixel in maps.iter().flat_map(Map::pixels).filter(|p| p.flux != Vec3::ZERO) {
        if let Some(cell) = grid.cell_of(pixel.position + 0.5 * grid.cell * pixel.normal) {
            cells[cell].add(&Colours::lobe(pixel.normal, pixel.flux / PI), 1.0);
        }
    }
    cells
}
