//! Surfaces as voxels: how much of each way they hide, what they reflect, and points at which light is injected.
//!
//! Source: C. Crassin, F. Neyret, M. Sainz, S. Green, E. Eisemann, Interactive indirect illumination using voxel cone
//! tracing, Computer Graphics Forum 30(7), 2011: voxels of surfaces, with six directional values.
//! Cells without surfaces take 4 bytes of an array; the rest is stored for the others alone.

use glam::{IVec3, Vec3};
use scene::{Sobol, SurfacePoint, square_to_triangle};

use crate::rivals::Setting;

/// Ways that a voxel is seen from: +x, −x, +y, −y, +z, −z.
pub const FACES: usize = 6;
/// Samples of a surface for each cell face of area.
const DENSITY: f32 = 32.0;
/// Hidden part over projected area of surfaces. A plane that cuts a corner off one cell covers the rest in the next, but
/// compositing takes the two as independent and would let light through; from 2 on walls are tight.
const SOLIDITY: f32 = 2.0;
/// In [`Level::index`] where there is no surface.
const EMPTY: u32 = u32::MAX;

/// One resolution.
pub struct Level {
    pub dims: IVec3,
    /// Number of each cell's voxel.
    index: Vec<u32>,
    /// Where each voxel is.
    pub cells: Vec<IVec3>,
    /// Part of the light that each voxel holds back, seen from each way.
    pub opacity: Vec<[f32; FACES]>,
    /// Where on each axis the surfaces of each voxel are that are seen along it, and their projected area, m².
    pub place: Vec<(Vec3, Vec3)>,
}

/// A point of a surface, in a voxel of the finest level.
pub struct Point {
    /// With the normal of the front.
    pub at: SurfacePoint,
    pub voxel: u32,
}

/// The finest level and what it was made of.
pub struct Grid {
    /// Corner of the first cell.
    pub low: Vec3,
    /// Edge of a cell, metres.
    pub edge: f32,
    pub finest: Level,
    /// Mean reflectance of each voxel, by the way that it is seen from.
    pub reflectance: Vec<[Vec3; FACES]>,
    /// Ascending voxels.
    pub points: Vec<Point>,
}

/// Unit vector of a face.
pub fn outward(face: usize) -> Vec3 {
    let sign = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    sign * Vec3::AXES[face / 2]
}

impl Level {
    /// Of a voxel: cell, opacity, place and area.
    pub const BYTES_A_VOXEL: usize = size_of::<IVec3>() + size_of::<[f32; FACES]>() + 2 * size_of::<Vec3>();

    /// Without any surface.
    pub fn empty(dims: IVec3) -> Level {
        let dims = dims.max(IVec3::ONE);
        let cells = dims.as_usizevec3().element_product();
        Level { dims, index: vec![EMPTY; cells], cells: vec![], opacity: vec![], place: vec![] }
    }

    /// The voxel of a cell, which may lie outside.
    pub fn voxel(&self, cell: IVec3) -> Option<usize> {
        let inside = cell.cmpge(IVec3::ZERO).all() && cell.cmplt(self.dims).all();
        let number = if inside { self.index[self.offset(cell)] } else { EMPTY };
        (number != EMPTY).then_some(number as usize)
    }

    /// The voxel of a cell inside, made where there is none, transparent.
    pub fn voxel_or_new(&mut self, cell: IVec3) -> usize {
        let offset = self.offset(cell);
        if self.index[offset] == EMPTY {
            self.index[offset] = self.cells.len() as u32;
            self.cells.push(cell);
            self.opacity.push([0.0; FACES]);
            self.place.push((Vec3::ZERO, Vec3::ZERO));
        }
        self.index[offset] as usize
    }

    /// More surface of a voxel, its middle at `point`; `area` is projected along each axis, m².
    pub fn enlarge(&mut self, voxel: usize, point: Vec3, area: Vec3) {
        let (place, before) = &mut self.place[voxel];
        *before += area;
        *place += (point - *place) * (area / before.max(Vec3::splat(f32::MIN_POSITIVE)));
    }

    fn offset(&self, cell: IVec3) -> usize {
        let (cell, dims) = (cell.as_usizevec3(), self.dims.as_usizevec3());
        (cell.z * dims.y + cell.y) * dims.x + cell.x
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&*self.index) + size_of_val(&*self.cells) + size_of_val(&*self.opacity) + size_of_val(&*self.place)
    }
}

impl Grid {
    /// `resolution` cells along the longest edge of the scene, cubes all; up to `kept` points a voxel.
    pub fn new(setting: &Setting, resolution: u32, kept: u32) -> Grid {
        let (low, edge, dims) = layout(setting, resolution);
        let mut grid = Grid { low, edge, finest: Level::empty(dims), reflectance: vec![], points: vec![] };
        let counts = grid.cover(setting);
        grid.keep(setting, &counts, kept.max(1));
        grid
    }

    /// Opacity and reflectance; the number of samples in each voxel.
    fn cover(&mut self, setting: &Setting) -> Vec<u32> {
        let (mut counts, one_sided) = (vec![], setting.scene.mesh.one_sided);
        self.each_sample(setting, |grid, cell, sample| {
            let voxel = grid.finest.voxel_or_new(cell);
            if voxel == counts.len() {
                counts.push(0);
                grid.reflectance.push([Vec3::ZERO; FACES]);
            }
            counts[voxel] += 1;
            grid.finest.enlarge(voxel, sample.at.position, sample.at.normal.abs() * sample.area);
            let (u, v) = sample.weights;
            let reflectance = Vec3::from(setting.surfaces.reflectance(sample.at.triangle, u, v));
            for face in 0..FACES {
                let facing = sample.at.normal.dot(outward(face));
                grid.finest.opacity[voxel][face] += facing.abs() * sample.area;
                if facing > 0.0 || !one_sided {
                    grid.reflectance[voxel][face] += facing.abs() * sample.area * reflectance;
                }
            }
        });
        let side = self.edge * self.edge;
        for (opacity, reflectance) in self.finest.opacity.iter_mut().zip(&mut self.reflectance) {
            for (opacity, reflectance) in opacity.iter_mut().zip(reflectance) {
                *reflectance /= opacity.max(f32::MIN_POSITIVE);
                *opacity = (SOLIDITY * *opacity / side).min(1.0);
            }
        }
        counts
    }

    /// Evenly chosen samples of each voxel.
    fn keep(&mut self, setting: &Setting, counts: &[u32], kept: u32) {
        let mut seen = vec![0u64; counts.len()];
        self.each_sample(setting, |grid, cell, sample| {
            let Some(voxel) = grid.finest.voxel(cell) else { return };
            let (number, count, kept) = (seen[voxel], u64::from(counts[voxel]), u64::from(kept));
            seen[voxel] += 1;
            if number * kept / count < (number + 1) * kept / count {
                grid.points.push(Point { at: sample.at, voxel: voxel as u32 });
            }
        });
        self.points.sort_by_key(|p| p.voxel);
    }

    /// Points on all triangles, each for as much area as any other of its triangle.
    fn each_sample(&mut self, setting: &Setting, mut take: impl FnMut(&mut Grid, IVec3, Sample)) {
        for triangle in 0..setting.scene.mesh.triangles.len() {
            let [a, b, c] = setting.scene.mesh.corners(triangle).map(Vec3::from);
            let across = (b - a).cross(c - a);
            let Some(normal) = across.try_normalize() else { continue };
            let area = 0.5 * across.length();
            let count = samples(area, self.edge);
            let (sobol, triangle) = (Sobol::new(triangle as u32), triangle as u32);
            for number in 0..count as u32 {
                let [x, y, ..] = sobol.sample(number);
                let (u, v) = square_to_triangle(x, y);
                let position = a + u * (b - a) + v * (c - a);
                let cell = ((position - self.low) / self.edge).floor().as_ivec3();
                let at = SurfacePoint { position, normal, triangle };
                let sample = Sample { at, weights: (u, v), area: area / count };
                take(self, cell.clamp(IVec3::ZERO, self.finest.dims - 1), sample);
            }
        }
    }
}

/// Corner of the first cell, edge of a cell, and numbers of cells, `resolution` of which lie along the longest side of the
/// scene.
fn layout(setting: &Setting, resolution: u32) -> (Vec3, f32, IVec3) {
    let corners = setting.scene.mesh.positions.iter().map(|p| Vec3::from(*p));
    let low = corners.clone().reduce(Vec3::min).unwrap_or_default();
    let size = corners.reduce(Vec3::max).unwrap_or_default() - low;
    // Outer walls lie in the middle of their cells.
    let edge = (size.max_element() / resolution.saturating_sub(1).max(1) as f32).max(f32::MIN_POSITIVE);
    (low - 0.5 * edge, edge, (size / edge + 0.5).floor().as_ivec3() + 1)
}

/// What a grid and its coarser levels hold at most.
pub struct Most {
    /// Cells of all levels.
    pub cells: u64,
    /// Voxels of all levels.
    pub voxels: u64,
    /// Voxels of the finest level.
    pub finest: u64,
}

/// Upper bounds for `resolution` cells along the longest side of the scene.
pub fn most(setting: &Setting, resolution: u32) -> Most {
    let (_, edge, mut dims) = layout(setting, resolution);
    let mesh = &setting.scene.mesh;
    let of_triangle = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle).map(Vec3::from);
        let area = 0.5 * (b - a).cross(c - a).length();
        let around = a.distance(b) + b.distance(c) + c.distance(a);
        // Columns across the axis that it faces most: as many as its area, and those that its edges pass; a plane enters
        // at most three cells of each. No more than it has samples.
        let columns = area / (edge * edge) + 2.0 * around / edge + 4.0;
        (3.0 * columns).min(samples(area, edge)) as u64
    };
    let voxels: u64 = (0..mesh.triangles.len()).map(of_triangle).sum();
    let cells_of = |dims: IVec3| dims.max(IVec3::ONE).as_u64vec3().element_product();
    let mut most = Most { cells: cells_of(dims), voxels: 0, finest: voxels.min(cells_of(dims)) };
    most.voxels = most.finest;
    while dims.max_element() > 1 {
        dims = (dims + 1) / 2;
        most.cells += cells_of(dims);
        most.voxels += most.finest.min(cells_of(dims));
    }
    most
}

/// Samples of a triangle.
fn samples(area: f32, edge: f32) -> f32 {
    (DENSITY * area / (edge * edge)).ceil().max(1.0)
}

struct Sample {
    at: SurfacePoint,
    /// Of the second and third corner.
    weights: (f32, f32),
    /// m².
    area: f32,
}
