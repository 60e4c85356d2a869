//! Triangles cut into the pieces that lie in one cell each.
//!
//! A triangle is cut into slabs along x, each slab along y, each of those along z, always by the
//! one plane next to it (I. Sutherland, G. Hodgman, Reentrant polygon clipping, CACM 17(1), 1974,
//! with both halves kept). So only cells that the triangle crosses are walked and no area is lost.
//! A polygon that lies in a plane between two layers belongs to the upper one.

use std::ops::Range;

use glam::DVec3;
use radfile::CellKey;
use rayon::prelude::*;

use crate::{grid::Grid, surface::Surface, tree::Cutting};

/// Pieces smaller than this part of a cell's side are rounding, not surface.
const LEAST_AREA: f64 = 1e-12;
/// Triangles that a thread takes at a time.
const BATCH: usize = 256;

/// A corner of a polygon and the edge that leads from it to the next.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    pub point: DVec3,
    pub edge: Edge,
}

/// Where an edge of a polygon comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// Edge of the triangle, from this corner of it to the next.
    Triangle(u8),
    /// The lower plane of the cell across this axis.
    Below(u8),
    /// The upper plane of the cell across this axis.
    Above(u8),
    /// A node of the piece's [`Cutting`].
    Cut(u8),
}

/// The part of a triangle that lies in a cell, or a part of that: a convex polygon in the triangle's winding.
#[derive(Clone, Debug)]
pub struct Clip {
    pub triangle: u32,
    pub cell: CellKey,
    /// m².
    pub area: f64,
    pub corners: Vec<Corner>,
    /// What stands on the triangle in this cell, by its number in [`Clips::cuttings`]; the parts of a triangle in a cell
    /// that was cut have it in common.
    pub cutting: Option<u32>,
}

impl Clip {
    /// Whether the triangle was cut in this cell.
    pub fn is_part(&self) -> bool {
        self.corners.iter().any(|corner| matches!(corner.edge, Edge::Cut(_)))
    }

    /// The edges with their ends.
    pub fn edges(&self) -> impl Iterator<Item = (Edge, [DVec3; 2])> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).map(|(corner, next)| (corner.edge, [corner.point, next.point]))
    }
}

/// All pieces of a surface.
pub struct Clips {
    /// By triangle, then by cell.
    pub clips: Vec<Clip>,
    /// For every triangle of the mesh, its pieces.
    pub of_triangle: Vec<Range<u32>>,
    pub cuttings: Vec<Cutting>,
    /// Area that was lost as rounding, one side, m².
    pub lost_area: f64,
}

impl Clips {
    /// The pieces of a triangle in a cell: several if it was cut there.
    pub fn pieces_of(&self, triangle: u32, cell: CellKey) -> Range<u32> {
        let all = self.of_triangle[triangle as usize].clone();
        let own = &self.clips[all.start as usize..all.end as usize];
        let first = own.partition_point(|c| c.cell < cell);
        let count = own[first..].iter().take_while(|c| c.cell == cell).count();
        all.start + first as u32..all.start + (first + count) as u32
    }
}

/// Cuts every triangle of the surface.
pub fn clip(surface: &Surface, grid: &Grid) -> Clips {
    let cut_batch = |batch: &[u32]| -> Vec<_> { batch.iter().map(|&t| cut(surface, grid, t)).collect() };
    let batches: Vec<Vec<(Vec<Clip>, f64)>> = surface.triangles.par_chunks(BATCH).map(cut_batch).collect();
    let of_triangle = vec![0..0; surface.area.len()];
    let mut all = Clips { clips: Vec::new(), of_triangle, cuttings: vec![], lost_area: 0.0 };
    for (&triangle, (pieces, lost)) in surface.triangles.iter().zip(batches.into_iter().flatten()) {
        let start = all.clips.len() as u32;
        all.clips.extend(pieces);
        all.of_triangle[triangle as usize] = start..all.clips.len() as u32;
        all.lost_area += lost;
    }
    all
}

/// The pieces of one triangle, by cell, and the area of those too small to keep.
fn cut(surface: &Surface, grid: &Grid, triangle: u32) -> (Vec<Clip>, f64) {
    let corners = surface.corners(triangle);
    let polygon = (0..3).map(|k| Corner { point: corners[k], edge: Edge::Triangle(k as u8) }).collect();
    let least = (LEAST_AREA * grid.size * grid.size).min(0.5 * surface.area[triangle as usize]);
    let mut pieces = Vec::new();
    let mut lost = 0.0;
    for (i, slab) in slabs(grid, 0, polygon) {
        for (j, bar) in slabs(grid, 1, slab) {
            for (k, corners) in slabs(grid, 2, bar) {
                match area(&corners) {
                    area if area < least => lost += area,
                    area => pieces.push(Clip { triangle, cell: CellKey::new([i, j, k]), area, corners, cutting: None }),
                }
            }
        }
    }
    pieces.sort_by_key(|p| p.cell);
    (pieces, lost)
}

/// A polygon cut by the planes across one axis.
fn slabs(grid: &Grid, axis: usize, polygon: Vec<Corner>) -> Vec<(i64, Vec<Corner>)> {
    let coordinates = || polygon.iter().map(|c| c.point[axis]);
    let first = grid.layer(axis, coordinates().fold(f64::INFINITY, f64::min));
    let last = grid.layer(axis, coordinates().fold(f64::NEG_INFINITY, f64::max));
    let mut slabs = Vec::with_capacity((last - first + 1) as usize);
    let mut rest = polygon;
    for layer in first..last {
        let plane = grid.plane(axis, layer + 1);
        let edges = [Edge::Above(axis as u8), Edge::Below(axis as u8)];
        let put = |mut point: DVec3| {
            point[axis] = plane;
            point
        };
        let (below, above) = split(&rest, |p| p[axis] - plane, edges, put);
        slabs.push((layer, below));
        rest = above;
    }
    slabs.push((last, rest));
    slabs.retain(|(_, polygon)| polygon.len() >= 3);
    slabs
}

/// The parts of a convex polygon where a distance is negative and where it is positive.
///
/// The new edge of the part below is `edges[0]`, that of the part above `edges[1]`; `put` puts new corners exactly in
/// the plane.
pub fn split(
    polygon: &[Corner],
    distance: impl Fn(DVec3) -> f64,
    edges: [Edge; 2],
    put: impl Fn(DVec3) -> DVec3,
) -> (Vec<Corner>, Vec<Corner>) {
    let mut below = Vec::with_capacity(polygon.len() + 2);
    let mut above = Vec::with_capacity(polygon.len() + 2);
    for (i, corner) in polygon.iter().enumerate() {
        let next = &polygon[(i + 1) % polygon.len()];
        let (d, e) = (distance(corner.point), distance(next.point));
        if d <= 0.0 {
            let leaves = d == 0.0 && e > 0.0;
            below.push(Corner { edge: if leaves { edges[0] } else { corner.edge }, ..*corner });
        }
        if d >= 0.0 {
            let leaves = d == 0.0 && e < 0.0;
            above.push(Corner { edge: if leaves { edges[1] } else { corner.edge }, ..*corner });
        }
        if (d < 0.0 && e > 0.0) || (d > 0.0 && e < 0.0) {
            let point = put(corner.point + d / (d - e) * (next.point - corner.point));
            let falls = d > 0.0;
            below.push(Corner { point, edge: if falls { corner.edge } else { edges[0] } });
            above.push(Corner { point, edge: if falls { edges[1] } else { corner.edge } });
        }
    }
    (below, above)
}

/// Area of a plane polygon, m².
pub fn area(corners: &[Corner]) -> f64 {
    let origin = corners[0].point;
    let cross: DVec3 = corners.windows(2).map(|w| (w[0].point - origin).cross(w[1].point - origin)).sum();
    0.5 * cross.length()
}
