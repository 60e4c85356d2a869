//! The geometry volume: how likely a cell's face stops light, by direction.
//!
//! Source: Kaplanyan and Dachsbacher 2010. A surfel of area A with normal n stops light that travels along ω with
//! probability A/s² ⟨n, −ω⟩₊, s the length of a cell's edge. They see surfels in shadow maps and in the camera's
//! picture, and
//! keep the strongest of many views; ours are spread evenly over all fronts, as many as it takes, which leaves no holes.
//! As theirs, the volume lies half a cell beside the light's: its samples are at the corners of cells.

use glam::{IVec3, Vec3, Vec4};
use rayon::prelude::*;
use scene::{Sobol, square_to_triangle};

use super::{
    grid::Grid,
    harmonics::{basis, lobe},
};
use crate::rivals::Setting;

/// Surfels on a triangle for each cell face that it would cover.
const SURFELS: f32 = 8.0;
/// At most this many on one triangle: memory is not in question, time is.
const MOST_SURFELS: f32 = 1e6;

/// What is in the way on one face of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Blocker {
    /// Probability to be stopped by the opposite of the direction of travel, two bands.
    by_normal: Vec4,
    /// Mean reflectance of what stops.
    pub reflectance: Vec3,
}

impl Blocker {
    /// Probability that light along `direction` is stopped.
    pub fn stops(&self, direction: Vec3) -> f32 {
        self.by_normal.dot(basis(-direction)).clamp(0.0, 1.0)
    }

    /// Whether nothing is there.
    pub fn is_open(&self) -> bool {
        self.by_normal == Vec4::ZERO
    }

    /// The way in which light leaves that was stopped, a unit vector.
    pub fn normal(&self) -> Vec3 {
        Vec3::new(self.by_normal.y, self.by_normal.z, self.by_normal.w).normalize_or_zero()
    }
}

/// The geometry volume, read out on the faces of the cells of a light's volume.
pub struct Blockers {
    grid: Grid,
    /// For each cell its faces towards +x, +y, +z.
    faces: Vec<[Blocker; 3]>,
}

impl Blockers {
    /// No surfaces at all.
    #[cfg(test)]
    pub fn none(grid: Grid) -> Blockers {
        Blockers { grid, faces: vec![Default::default(); grid.len()] }
    }

    /// Spreads surfels over a scene and adds them up.
    pub fn new(setting: &Setting, grid: Grid) -> Blockers {
        // Sample (x, y, z) is the upper corner of cell (x, y, z).
        let corners = Grid { low: grid.low + 0.5 * grid.cell, ..grid };
        let mut samples = vec![(Vec4::ZERO, Vec4::ZERO); grid.len()];
        for triangle in 0..setting.scene.mesh.triangles.len() as u32 {
            add_surfels(setting, &corners, triangle, &mut samples);
        }
        let face = |at: IVec3, axis: usize| {
            let (a, b) = (IVec3::AXES[(axis + 1) % 3], IVec3::AXES[(axis + 2) % 3]);
            let four = [at, at - a, at - b, at - a - b];
            let read = four.iter().filter_map(|&c| grid.index(c)).map(|i| samples[i]);
            let (normal, reflectance) = read.fold((Vec4::ZERO, Vec4::ZERO), |s, x| (s.0 + x.0, s.1 + x.1));
            let reflectance = if reflectance.w > 0.0 { reflectance.truncate() / reflectance.w } else { Vec3::ZERO };
            Blocker { by_normal: 0.25 * normal, reflectance }
        };
        let faces = (0..grid.len()).into_par_iter().map(|i| [0, 1, 2].map(|axis| face(grid.at(i), axis))).collect();
        Blockers { grid, faces }
    }

    /// What is between a cell and its neighbour along an axis, up or down.
    pub fn between(&self, at: IVec3, axis: usize, up: bool) -> Blocker {
        let lower = if up { at } else { at - IVec3::AXES[axis] };
        self.grid.index(lower).map_or(Blocker::default(), |i| self.faces[i][axis])
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> u64 {
        size_of_val(self.faces.as_slice()) as u64
    }
}

/// Adds the surfels of one triangle: sum of lobes, and area times reflectance with the area as the last number.
fn add_surfels(setting: &Setting, corners: &Grid, triangle: u32, samples: &mut [(Vec4, Vec4)]) {
    let [a, b, c] = setting.scene.mesh.corners(triangle as usize).map(Vec3::from);
    let cross = (b - a).cross(c - a);
    let Some(normal) = cross.try_normalize() else { return };
    // Faces of cells that the triangle covers.
    let covers = 0.5 * cross.length() / corners.cell.powi(2);
    let count = (SURFELS * covers).clamp(1.0, MOST_SURFELS).ceil();
    let sobol = Sobol::new(triangle);
    for i in 0..count as u32 {
        let [x, y, ..] = sobol.sample(i);
        let (u, v) = square_to_triangle(x, y);
        // A hair in front of the surface, so that walls between samples belong to one layer.
        let point = a + u * (b - a) + v * (c - a) + 1e-3 * corners.cell * normal;
        if let Some(at) = corners.cell_of(point) {
            let share = covers / count;
            let reflectance = Vec3::from(setting.surfaces.reflectance(triangle, u, v));
            samples[at].0 += share * lobe(normal);
            samples[at].1 += share * reflectance.extend(1.0);
        }
    }
}
