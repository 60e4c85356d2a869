//! Coarser and coarser voxels, and what light they send each way.
//!
//! Source: Crassin et al. 2011 (directional values of coarser voxels): seen from a face, of each pair of voxels one behind the other the front one is laid
//! over the back one, and the four pairs are averaged. Light is stored multiplied by opacity.

use std::f32::consts::PI;

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use super::grid::{FACES, Grid, Level, outward};

/// Weights of the three faces add up to 1, so a wall that is seen at a slant, and hides all, would hide the part that the
/// one face of it counts. All of it is hidden where that is at least the reciprocal of this.
const SLANT: f32 = 3.0;

/// All levels, finest first, and what of them does not depend on light.
pub struct Pyramid {
    pub grid: Grid,
    /// Above the finest.
    coarse: Vec<Level>,
}

/// Radiance times opacity of every voxel of every level, W/(m² sr).
pub struct VoxelLight(Vec<Vec<[Vec3; FACES]>>);

/// A direction to look in, and where from.
#[derive(Clone, Copy)]
pub struct View {
    /// Those that are seen, one an axis, and what counts each.
    faces: [usize; 3],
    weights: [f32; 3],
    from: Vec3,
    /// 1 or −1 on each axis.
    ahead: Vec3,
}

impl View {
    /// From a point along a unit vector.
    pub fn new(from: Vec3, direction: Vec3) -> View {
        let faces = std::array::from_fn(|axis| 2 * axis + usize::from(direction[axis] > 0.0));
        View { faces, weights: (direction * direction).to_array(), from, ahead: direction.signum() }
    }

    /// What each axis counts in a voxel with surfaces at `place`: nothing where they are behind. Coarse voxels reach back
    /// over the wall that a cone leaves, and would show it from its other side.
    fn weights_of(&self, place: Vec3) -> [f32; 3] {
        let before = ((place - self.from) * self.ahead).cmpgt(Vec3::ZERO);
        std::array::from_fn(|axis| if before.test(axis) { self.weights[axis] } else { 0.0 })
    }
}

impl Pyramid {
    /// Of a voxel: what its level stores of it, its reflectance and its light.
    pub const BYTES_A_VOXEL: u64 = (Level::BYTES_A_VOXEL + 2 * size_of::<[Vec3; FACES]>()) as u64;

    pub fn new(grid: Grid) -> Pyramid {
        let mut pyramid = Pyramid { grid, coarse: vec![] };
        while pyramid.level(pyramid.coarse.len()).dims != IVec3::ONE {
            let fine = pyramid.level(pyramid.coarse.len());
            let mut level = Level::empty((fine.dims + 1) / 2);
            for (&cell, &(place, area)) in fine.cells.iter().zip(&fine.place) {
                let voxel = level.voxel_or_new(cell / 2);
                level.enlarge(voxel, place, area);
            }
            for voxel in 0..level.cells.len() {
                let hidden = |face| {
                    let one = |cell| fine.voxel(cell).map_or(0.0, |v| fine.opacity[v][face]);
                    over_pairs(level.cells[voxel], face, |front, back| {
                        let (front, back) = (one(front), one(back));
                        front + (1.0 - front) * back
                    })
                };
                level.opacity[voxel] = std::array::from_fn(hidden);
            }
            pyramid.coarse.push(level);
        }
        pyramid
    }

    fn level(&self, number: usize) -> &Level {
        if number == 0 { &self.grid.finest } else { &self.coarse[number - 1] }
    }

    /// Light that leaves the voxels where the front and the back of [`Grid::points`] receive `irradiance`, W/m².
    pub fn light(&self, irradiance: &[[Vec3; 2]]) -> VoxelLight {
        let mut levels = vec![self.injected(irradiance)];
        for (number, level) in self.coarse.iter().enumerate() {
            let (fine, below) = (self.level(number), &levels[number]);
            let one = |cell: &IVec3| {
                std::array::from_fn(|face| {
                    let light = |cell| fine.voxel(cell).map_or(Vec3::ZERO, |v| below[v][face]);
                    let clear = |cell| fine.voxel(cell).map_or(1.0, |v| 1.0 - fine.opacity[v][face]);
                    over_pairs(*cell, face, |front, back| light(front) + clear(front) * light(back))
                })
            };
            let next = level.cells.par_iter().map(one).collect();
            levels.push(next);
        }
        VoxelLight(levels)
    }

    /// Seen from a face a voxel's light is that of the sides of its points that face there.
    fn injected(&self, irradiance: &[[Vec3; 2]]) -> Vec<[Vec3; FACES]> {
        let (points, voxels) = (&self.grid.points, self.grid.finest.cells.len());
        let one = |voxel: usize| {
            let first = points.partition_point(|p| (p.voxel as usize) < voxel);
            let here = points[first..].iter().zip(&irradiance[first..]).take_while(|(p, _)| p.voxel as usize == voxel);
            std::array::from_fn(|face| {
                let (mut sum, mut weight) = (Vec3::ZERO, 0.0);
                for (point, sides) in here.clone() {
                    let facing = point.at.normal.dot(outward(face));
                    sum += facing.abs() * sides[usize::from(facing < 0.0)];
                    weight += facing.abs();
                }
                let radiance = self.grid.reflectance[voxel][face] * sum / (PI * weight.max(f32::MIN_POSITIVE));
                self.grid.finest.opacity[voxel][face] * radiance
            })
        };
        (0..voxels).into_par_iter().map(one).collect()
    }

    /// Light, and part that is held back, at a point as voxels of an edge of `width` metres would show it on their whole
    /// length: between both levels and all eight voxels that are nearest.
    pub fn look(&self, light: &VoxelLight, at: Vec3, width: f32, view: &View) -> (Vec3, f32) {
        let level = (width / self.grid.edge).max(1.0).log2().min(self.coarse.len() as f32);
        let (fine, rest) = (level as usize, level.fract());
        let (radiance, hidden) = self.look_at_level(light, at, fine, view);
        if rest == 0.0 {
            return (radiance, hidden);
        }
        let (coarse_radiance, coarse_hidden) = self.look_at_level(light, at, fine + 1, view);
        (radiance.lerp(coarse_radiance, rest), hidden + rest * (coarse_hidden - hidden))
    }

    fn look_at_level(&self, light: &VoxelLight, at: Vec3, number: usize, view: &View) -> (Vec3, f32) {
        let (level, light) = (self.level(number), &light.0[number]);
        let place = (at - self.grid.low) / (self.grid.edge * (1u64 << number) as f32) - 0.5;
        let (first, rest) = (place.floor().as_ivec3(), place - place.floor());
        let (mut radiance, mut hidden) = (Vec3::ZERO, 0.0);
        for corner in 0..8 {
            let step = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
            let Some(voxel) = level.voxel(first + step) else { continue };
            let near = Vec3::select(step.cmpgt(IVec3::ZERO), rest, 1.0 - rest).element_product();
            for (face, weight) in view.faces.into_iter().zip(view.weights_of(level.place[voxel].0)) {
                radiance += near * weight * light[voxel][face];
                hidden += near * weight * level.opacity[voxel][face];
            }
        }
        let more = (SLANT * hidden).min(1.0) / hidden.max(f32::MIN_POSITIVE);
        (more * radiance, more * hidden)
    }

    pub fn bytes(&self) -> u64 {
        let levels: usize = (0..=self.coarse.len()).map(|n| self.level(n).bytes()).sum();
        let voxels: usize = (0..=self.coarse.len()).map(|n| self.level(n).cells.len()).sum();
        let light = voxels * size_of::<[Vec3; FACES]>();
        (levels + light + size_of_val(&*self.grid.reflectance) + size_of_val(&*self.grid.points)) as u64
    }
}

/// Mean of `pair(front, back)` over the four pairs of finer cells, one before the other as `face` sees them.
fn over_pairs<T>(cell: IVec3, face: usize, pair: impl Fn(IVec3, IVec3) -> T) -> T
where
    T: std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
{
    let axis = face / 2;
    let (front, back) = if face.is_multiple_of(2) { (1, 0) } else { (0, 1) };
    let one = |number: i32| {
        let mut child = 2 * cell;
        child[(axis + 1) % 3] += number & 1;
        child[(axis + 2) % 3] += number >> 1;
        let mut other = child;
        child[axis] += front;
        other[axis] += back;
        pair(child, other)
    };
    (one(0) + one(1) + one(2) + one(3)) * 0.25
}
