//! Interpolation: the patches around a receiver, weighed by nearness, side and size.

use std::collections::HashMap;

use glam::Vec3;
use radfile::Patches;
use rayon::prelude::*;
use scene::{Rays, basis};

use crate::{
    fit::{Sample, fit},
    rows::Row,
    sight::{Place, Sight},
    triangle::nearest_point,
};

/// Patches that face away by more than this cosine lie on another surface.
const SAME_SIDE: f32 = 0.5;
/// Distance from the tangent plane at which a patch no longer counts, in search radii.
const OFF_PLANE: f32 = 0.3;
/// Where no patch is in sight the radius grows by this factor, so often.
const GROWTH: f32 = 1.6;
const WIDENINGS: u32 = 3;
/// A patch that is a small part of its voxel speaks for a small part of the surface, but not for nothing.
const SMALLEST_SHARE: f32 = 1e-3;

/// How far the position of a patch is moved towards the middle of a piece.
const INWARD: f32 = 0.02;

/// Patches by place.
pub struct Neighbours<'a> {
    patches: &'a Patches,
    /// The looks along surfaces that decide.
    pub sight: Sight<'a>,
    places: Vec<Place>,
    /// Patches in each cell of a grid, in increasing order.
    grid: HashMap<[i32; 3], Vec<u32>>,
    radius: f32,
}

impl<'a> Neighbours<'a> {
    /// Prepares the patches; `radius` is in voxels.
    pub fn new(patches: &'a Patches, rays: &'a Rays, radius: f32) -> Neighbours<'a> {
        let cell = patches.locator.cell_size;
        let sight = Sight::new(rays, cell);
        let places: Vec<Place> = (0..patches.len())
            .into_par_iter()
            .map(|p| sight.place(inner_position(patches, p), Vec3::from(patches.normal[p])))
            .collect();
        let radius = radius * cell;
        let mut grid: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
        for (p, place) in places.iter().enumerate() {
            grid.entry(cell_of(place.position, radius)).or_default().push(p as u32);
        }
        Neighbours { patches, sight, places, grid, radius }
    }

    /// The weights of a receiver; `own` is the patch that it lies on, asked only where none is in sight.
    pub fn row(&self, position: Vec3, normal: Vec3, own: impl FnOnce() -> Option<u32>) -> Row {
        let receiver = self.sight.place(position, normal);
        for widening in 0..=WIDENINGS {
            let samples = self.in_sight(&receiver, self.radius * GROWTH.powi(widening as i32));
            if !samples.is_empty() {
                return Row { entries: fit(&samples), fallback: false, widened: widening > 0 };
            }
        }
        let entries: Vec<(u32, f32)> = own().map(|p| (p, 1.0)).into_iter().collect();
        Row { fallback: !entries.is_empty(), widened: false, entries }
    }

    /// The patches within `radius` that a receiver can see along its surface.
    fn in_sight(&self, receiver: &Place, radius: f32) -> Vec<Sample> {
        let low = cell_of(receiver.position - radius, self.radius);
        let high = cell_of(receiver.position + radius, self.radius);
        let (s, t) = basis(receiver.normal);
        let mut samples = Vec::new();
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                for x in low[0]..=high[0] {
                    for &patch in self.grid.get(&[x, y, z]).map_or(&[][..], Vec::as_slice) {
                        let place = &self.places[patch as usize];
                        let kernel = self.kernel(receiver, patch, radius);
                        if kernel > 0.0 && self.sight.joined(receiver, place) {
                            let offset = (place.position - receiver.position) / radius;
                            let at = [offset.dot(s).into(), offset.dot(t).into()];
                            samples.push(Sample { patch, at, kernel: kernel.into() });
                        }
                    }
                }
            }
        }
        samples
    }

    /// Nearness, same side, same plane and size in one number; smooth, and 0 beyond the radius.
    fn kernel(&self, receiver: &Place, patch: u32, radius: f32) -> f32 {
        let place = &self.places[patch as usize];
        let way = place.position - receiver.position;
        let near = 1.0 - way.length_squared() / (radius * radius);
        let same_side = (receiver.normal.dot(place.normal) - SAME_SIDE) / (1.0 - SAME_SIDE);
        if near <= 0.0 || same_side <= 0.0 {
            return 0.0;
        }
        let off_plane = way.dot(receiver.normal).abs().max(way.dot(place.normal).abs()) / (OFF_PLANE * radius);
        let in_plane = (1.0 - off_plane * off_plane).max(0.0);
        let cell = self.patches.locator.cell_size;
        let share = (self.patches.area[patch as usize] / (cell * cell)).clamp(SMALLEST_SHARE, 1.0);
        let smooth = same_side.min(1.0);
        (near * in_plane).powi(2) * smooth * smooth * (3.0 - 2.0 * smooth) * share
    }
}

/// The position of a patch, a little inside its nearest piece: on an edge it might be rounded through the next wall.
fn inner_position(patches: &Patches, patch: usize) -> Vec3 {
    let position = Vec3::from(patches.position[patch]);
    let pieces = patches.pieces_of(patch).iter().map(|p| p.corners.map(Vec3::from));
    let distance = |corners: &[Vec3; 3]| nearest_point(*corners, position).distance_squared(position);
    let nearest = pieces.min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.map_or(position, |[a, b, c]| position.lerp((a + b + c) / 3.0, INWARD))
}

fn cell_of(position: Vec3, size: f32) -> [i32; 3] {
    (position / size).floor().as_ivec3().to_array()
}
