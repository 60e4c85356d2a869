//! Points on the real pieces of a patch, uniform by area.

use glam::Vec3;
use radfile::{Patches, Piece};

use crate::square_to_triangle;

/// Draws points on patches. Shared by form factors, direct light and the GPU's sample points.
pub struct PatchSampler<'a> {
    patches: &'a Patches,
    /// For every piece, the area of its patch's pieces up to and including it, as a share of the whole.
    share: Vec<f32>,
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
        let mut share = Vec::with_capacity(patches.pieces.len());
        for patch in 0..patches.len() {
            let areas: Vec<f64> = patches.pieces_of(patch).iter().map(|p| f64::from(area(p))).collect();
            let total: f64 = areas.iter().sum();
            let mut sum = 0.0;
            share.extend(areas.iter().map(|a| {
                sum += a;
                (sum / total) as f32
            }));
        }
        PatchSampler { patches, share }
    }

    /// The point of a patch at `(x, y)` of the unit square: x chooses the piece by area and is then
    /// stretched over it, so stratified numbers give stratified points.
    pub fn point(&self, patch: usize, x: f32, y: f32) -> SurfacePoint {
        let start = self.patches.piece_start[patch] as usize;
        let shares = &self.share[start..self.patches.piece_start[patch + 1] as usize];
        let k = shares.partition_point(|&s| s <= x).min(shares.len() - 1);
        let low = if k == 0 { 0.0 } else { shares[k - 1] };
        let stretched = ((x - low) / (shares[k] - low)).clamp(0.0, 1.0);
        let piece = &self.patches.pieces[start + k];
        let (u, v) = square_to_triangle(if stretched.is_nan() { 0.5 } else { stretched }, y);
        let [a, b, c] = piece.corners.map(Vec3::from);
        SurfacePoint { position: a + u * (b - a) + v * (c - a), normal: self.normal(piece), triangle: piece.face / 2 }
    }

    /// Unit normal of a piece on its patch's side; slivers take the patch's normal.
    fn normal(&self, piece: &Piece) -> Vec3 {
        let [a, b, c] = piece.corners.map(Vec3::from);
        let front = (b - a).cross(c - a);
        if piece.face % 2 == 0 { front.normalize_or_zero() } else { -front.normalize_or_zero() }
    }
}

/// Area of a piece, m².
fn area(piece: &Piece) -> f32 {
    let [a, b, c] = piece.corners.map(Vec3::from);
    0.5 * (b - a).cross(c - a).length()
}
