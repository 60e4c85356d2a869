//! Edges that end in the air above a piece: the foot of a box that hovers, the free edge of a curtain.
//!
//! Through a gap much narrower than a patch hardly any light passes, and yet a patch that lies on both sides of it would
//! carry light from one to the other. So a piece is cut below such an edge as if a wall stood there. Edges from which an
//! upright surface goes on towards the piece do not count: only the last of them hangs above it. Nor do short ones, the
//! details of a scene: they would take more patches than they are worth.

use glam::DVec3;

use crate::{
    clip::{Clip, Edge},
    contact::GOES_ON,
    surface::Surface,
};

/// An edge hangs above a piece if it is nearer than this, in cells.
pub const REACH: f64 = 0.15;
/// Least length of such an edge, in cells.
const LONG: f64 = 0.5;

/// Edges at which a surface may end.
pub struct Rims<'a> {
    surface: &'a Surface<'a>,
    /// Welded vertices of the long edges, the smaller first, and their triangles; in order.
    edges: Vec<([u32; 2], u32)>,
    /// For every triangle, the edges from which no other goes on in about the same direction.
    of_triangle: Vec<[bool; 3]>,
}

impl Rims<'_> {
    /// Those of cells of `size` metres.
    pub fn new<'a>(surface: &'a Surface, size: f64) -> Rims<'a> {
        let sides = || surface.triangles.iter().flat_map(|&t| (0..3).map(move |k| (t, k)));
        let long = |&(t, k): &(u32, usize)| length(surface, t, k) >= LONG * size;
        let mut edges: Vec<([u32; 2], u32)> = sides().filter(long).map(|(t, k)| (ends(surface, t, k), t)).collect();
        edges.sort_unstable();
        let mut rims = Rims { surface, edges, of_triangle: vec![[false; 3]; surface.area.len()] };
        for (t, k) in sides().filter(long) {
            let own = inwards(surface, t, k);
            let ends_here = rims.around(t, k).all(|other| other.dot(own) > -GOES_ON);
            rims.of_triangle[t as usize][k] = ends_here;
        }
        rims
    }

    /// Whether any edge of a piece may end above another.
    pub fn has_any(&self, piece: &Clip) -> bool {
        let is_rim = |edge| matches!(edge, Edge::Triangle(k) if self.of_triangle[piece.triangle as usize][k as usize]);
        piece.corners.iter().any(|corner| is_rim(corner.edge))
    }

    /// Where edges of `other` hang above `piece`, as far as they lie in the cell.
    pub fn above(&self, piece: &Clip, other: &Clip, [tolerance, reach]: [f64; 2]) -> Vec<[DVec3; 2]> {
        let (foot, normal) = (piece.corners[0].point, self.surface.normal[piece.triangle as usize]);
        let height = |p: DVec3| (p - foot).dot(normal);
        let middle = other.corners.iter().map(|c| height(c.point)).sum::<f64>() / other.corners.len() as f64;
        let up = middle.signum();
        let hangs = |&(edge, ends): &(Edge, [DVec3; 2])| {
            let Edge::Triangle(k) = edge else { return false };
            let (t, k, [a, b]) = (other.triangle, k as usize, ends.map(|p| up * height(p)));
            let near = a.min(b) >= tolerance && a.max(b) <= reach && a.min(b) < up * middle;
            near && self.of_triangle[t as usize][k] && !self.goes_on(t, k, up * normal)
        };
        other.edges().filter(hangs).map(|(_, ends)| ends).collect()
    }

    /// Whether an upright surface goes on from an edge of a triangle against `up`.
    fn goes_on(&self, triangle: u32, corner: usize, up: DVec3) -> bool {
        let steep = (1.0 - GOES_ON * GOES_ON).sqrt();
        self.around(triangle, corner).any(|inwards| inwards.dot(up) < -steep)
    }

    /// Directions of all triangles on an edge away from it.
    fn around(&self, triangle: u32, corner: usize) -> impl Iterator<Item = DVec3> + '_ {
        let key = ends(self.surface, triangle, corner);
        let first = self.edges.partition_point(|e| e.0 < key);
        self.edges[first..].iter().take_while(move |e| e.0 == key).map(move |&(_, t)| {
            let k = (0..3).find(|&k| ends(self.surface, t, k) == key).unwrap_or_default();
            inwards(self.surface, t, k)
        })
    }
}

/// Welded vertices of an edge of a triangle.
fn ends(surface: &Surface, triangle: u32, corner: usize) -> [u32; 2] {
    let vertices = surface.scene.mesh.triangles[triangle as usize].map(|v| surface.welded[v as usize]);
    let (v, w) = (vertices[corner], vertices[(corner + 1) % 3]);
    [v.min(w), v.max(w)]
}

fn length(surface: &Surface, triangle: u32, corner: usize) -> f64 {
    let corners = surface.corners(triangle);
    corners[corner].distance(corners[(corner + 1) % 3])
}

/// The direction from an edge into its triangle.
fn inwards(surface: &Surface, triangle: u32, corner: usize) -> DVec3 {
    let corners = surface.corners(triangle);
    let along = (corners[(corner + 1) % 3] - corners[corner]).normalize_or_zero();
    surface.normal[triangle as usize].cross(along)
}
