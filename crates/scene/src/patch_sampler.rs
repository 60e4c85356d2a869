//! Points on the real pieces of a patch, uniform by area.
//!
//! Points keep a distance from the edges of their piece that is above the rounding of coordinates.
//! Walls meet at edges; a point that is rounded onto or past the next wall would see what is behind it.

use glam::Vec3;
use radfile::{Patches, Piece};

use crate::square_to_triangle;

/// Distance that points keep from the edges of their piece, relative to the largest coordinate:
/// four times the gap of `Rays::off_surface`.
const INSET: f32 = 64.0 * f32::EPSILON;

/// Draws points on patches. Shared by form factors, direct light and the GPU's sample points.
pub struct PatchSampler<'a> {
    patches: &'a Patches,
    /// What is known of each piece beforehand.
    prepared: Vec<Prepared>,
}

struct Prepared {
    /// Number of the piece.
    piece: u32,
    /// Area of the patch's pieces up to and including this one, as a share of the whole.
    share: f32,
    /// Unit normal on the patch's side.
    normal: Vec3,
    /// Least weight of each corner, so that points keep their distance from the edge opposite to it.
    least: [f32; 3],
}

/// A point on a piece of a patch.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position, local axes, metres.
    pub position: Vec3,
    /// Unit normal of the piece, on the patch's side.
    pub normal: Vec3,
    /// Triangle of the mesh it lies on.
    pub triangle: u32,
}

impl<'a> PatchSampler<'a> {
    /// Prepares the patches.
    pub fn new(patches: &'a Patches) -> PatchSampler<'a> {
        let corners = patches.pieces.iter().flat_map(|p| p.corners.as_flattened());
        let inset = INSET * corners.fold(0.0f32, |m, x| m.max(x.abs()));
        let mut prepared = Vec::with_capacity(patches.pieces.len());
        for patch in 0..patches.len() {
            let order = along_curve(patches, patch);
            let total: f64 = patches.pieces_of(patch).iter().map(area).sum();
            let mut sum = 0.0;
            prepared.extend(order.iter().enumerate().map(|(k, &number)| {
                let piece = &patches.pieces[number as usize];
                sum += area(piece);
                // A patch of nothing but slivers: all of them count the same.
                let share = if total > 0.0 { sum / total } else { (k + 1) as f64 / order.len() as f64 };
                let normal = normal(piece).unwrap_or(Vec3::from(patches.normal[patch]));
                Prepared { piece: number, share: share as f32, normal, least: least_weights(piece, inset) }
            }));
        }
        PatchSampler { patches, prepared }
    }

    /// The point of a patch at `(x, y)` of the unit square: x chooses the piece by area and is then
    /// stretched over it, so stratified numbers give stratified points.
    pub fn point(&self, patch: usize, x: f32, y: f32) -> SurfacePoint {
        let start = self.patches.piece_start[patch] as usize;
        let prepared = &self.prepared[start..self.patches.piece_start[patch + 1] as usize];
        let k = prepared.partition_point(|p| p.share <= x).min(prepared.len() - 1);
        let low = if k == 0 { 0.0 } else { prepared[k - 1].share };
        let width = prepared[k].share - low;
        let stretched = if width > 0.0 { ((x - low) / width).clamp(0.0, 1.0) } else { 0.5 };
        let piece = &self.patches.pieces[prepared[k].piece as usize];
        let (u, v) = square_to_triangle(stretched, y);
        let [_, u, v] = keep_inside([1.0 - u - v, u, v], prepared[k].least);
        let [a, b, c] = piece.corners.map(Vec3::from);
        SurfacePoint { position: a + u * (b - a) + v * (c - a), normal: prepared[k].normal, triangle: piece.face / 2 }
    }
}

/// Numbers of a patch's pieces along a space-filling curve (G. M. Morton, 1966), so that numbers
/// that are stratified choose pieces that are.
fn along_curve(patches: &Patches, patch: usize) -> Vec<u32> {
    let range = patches.piece_start[patch]..patches.piece_start[patch + 1];
    let middle = |k: u32| patches.pieces[k as usize].corners.iter().map(|&c| Vec3::from(c) / 3.0).sum::<Vec3>();
    let fold = |f: fn(Vec3, Vec3) -> Vec3| range.clone().map(middle).reduce(f).unwrap_or_default();
    let (low, high) = (fold(Vec3::min), fold(Vec3::max));
    let scale = 1023.0 / (high - low).max_element().max(f32::MIN_POSITIVE);
    let code = |k: u32| {
        let cell = ((middle(k) - low) * scale).to_array().map(|x| x as u32);
        (0..10).map(|bit| (0..3).map(|a| (cell[a] >> bit & 1) << (3 * bit + a)).sum::<u32>()).sum::<u32>()
    };
    let mut order: Vec<u32> = range.clone().collect();
    order.sort_by_cached_key(|&k| code(k));
    order
}

/// Twice the area of a piece as a vector along the normal of its front.
fn cross(piece: &Piece) -> glam::DVec3 {
    let [a, b, c] = piece.corners.map(|p| Vec3::from(p).as_dvec3());
    (b - a).cross(c - a)
}

/// Area of a piece, m².
fn area(piece: &Piece) -> f64 {
    0.5 * cross(piece).length()
}

/// Unit normal of a piece on its patch's side, `None` for a piece without area.
fn normal(piece: &Piece) -> Option<Vec3> {
    let front = cross(piece).try_normalize()?.as_vec3();
    Some(if piece.face.is_multiple_of(2) { front } else { -front })
}

/// The corners' weights at the distance `inset` from the opposite edges; their sum is at most 1,
/// which is reached by pieces so thin that only their middle is left.
fn least_weights(piece: &Piece, inset: f32) -> [f32; 3] {
    let [a, b, c] = piece.corners.map(|p| Vec3::from(p).as_dvec3());
    let twice_area = cross(piece).length();
    let edges = [(c - b).length(), (a - c).length(), (b - a).length()];
    let perimeter: f64 = edges.iter().sum();
    if perimeter == 0.0 {
        return [1.0 / 3.0; 3];
    }
    // The height over an edge is twice the area divided by the edge.
    let inset = f64::from(inset).min(twice_area / perimeter);
    edges.map(|e| if twice_area > 0.0 { (inset * e / twice_area) as f32 } else { (e / perimeter) as f32 })
}

/// Raises weights to their least value; the others give what is gained, in proportion to what they can spare.
fn keep_inside(weights: [f32; 3], least: [f32; 3]) -> [f32; 3] {
    let spare: [f32; 3] = std::array::from_fn(|i| (weights[i] - least[i]).max(0.0));
    let (all, wanted) = (spare.iter().sum::<f32>(), (1.0 - least.iter().sum::<f32>()).max(0.0));
    let factor = if all > 0.0 { wanted / all } else { 0.0 };
    std::array::from_fn(|i| least[i] + factor * spare[i])
}
