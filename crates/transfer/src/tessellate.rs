//! The fine mesh: every edge longer than a limit is halved, again and again.
//!
//! A triangle is cut through the midpoint of its longest edge (M.-C. Rivara, Algorithms for
//! refining triangular grids suitable for adaptive and multigrid techniques, 1984). Whether an
//! edge is halved depends on its two ends alone, so both triangles at an edge halve it alike and
//! there are no T-junctions, although each triangle is cut without looking at its neighbours.

use std::collections::HashMap;

use glam::Vec3;
use radfile::{FineMesh, Mesh};
use rayon::prelude::*;

use crate::error::{Error, Result};

/// Bytes of one fine triangle with its share of vertices, receivers and weights: half a vertex, one receiver,
/// a dozen weights.
const BYTES_PER_TRIANGLE: u64 = 40 + 6 + 28 + 12 * 8;

/// Cuts the mesh until no edge is longer than `edge`; corners have no receivers yet.
///
/// # Errors
///
/// [`Error::Edge`], [`Error::TooFine`], [`Error::LargeMesh`].
pub fn tessellate(mesh: &Mesh, edge: f32, limit: u64) -> Result<FineMesh> {
    if !(edge > 0.0 && edge.is_finite()) {
        return Err(Error::Edge { found: edge });
    }
    refuse_absurd(mesh, edge, limit)?;
    let cut: Vec<Vec<[Vec3; 3]>> =
        (0..mesh.triangles.len()).into_par_iter().map(|t| cut(corners(mesh, t), edge)).collect();
    let mut fine = FineMesh::default();
    let mut number: HashMap<[u32; 3], u32> = HashMap::new();
    for (source, triangles) in cut.iter().enumerate() {
        for triangle in triangles {
            fine.triangle.push(triangle.map(|p| {
                let p = (p + Vec3::ZERO).to_array(); // adding zero turns -0 into +0
                *number.entry(p.map(f32::to_bits)).or_insert_with(|| {
                    fine.vertex.push(p);
                    fine.vertex.len() as u32 - 1
                })
            }));
            fine.source.push(source as u32);
        }
    }
    Ok(fine)
}

fn corners(mesh: &Mesh, triangle: usize) -> [Vec3; 3] {
    mesh.corners(triangle).map(Vec3::from)
}

/// The parts of one triangle, in its winding.
fn cut(triangle: [Vec3; 3], edge: f32) -> Vec<[Vec3; 3]> {
    let mut done = Vec::new();
    let mut open = vec![triangle];
    while let Some(triangle) = open.pop() {
        let lengths: [f32; 3] = std::array::from_fn(|i| triangle[i].distance_squared(triangle[(i + 1) % 3]));
        let i = (0..3).fold(0, |best, i| if longer(&triangle, &lengths, i, best) { i } else { best });
        let (a, b, c) = (triangle[i], triangle[(i + 1) % 3], triangle[(i + 2) % 3]);
        let middle = 0.5 * (a + b);
        // Where single precision has no number between the ends, an edge cannot be halved.
        if lengths[i] > edge * edge && middle != a && middle != b {
            open.push([middle, b, c]);
            open.push([a, middle, c]);
        } else {
            done.push(triangle);
        }
    }
    done
}

/// Whether edge `i` comes before edge `j`: by length, then by position of its ends.
fn longer(triangle: &[Vec3; 3], lengths: &[f32; 3], i: usize, j: usize) -> bool {
    let ends = |i: usize| {
        let (a, b) = (triangle[i].to_array(), triangle[(i + 1) % 3].to_array());
        if a <= b { (a, b) } else { (b, a) }
    };
    lengths[i] > lengths[j] || (lengths[i] == lengths[j] && ends(i) < ends(j))
}

fn refuse_absurd(mesh: &Mesh, edge: f32, limit: u64) -> Result<()> {
    let sources = mesh.triangles.len() as u64;
    if sources > limit {
        return Err(Error::LargeMesh { triangles: sources, limit });
    }
    let triangles = estimate(mesh, edge);
    if triangles <= limit as f64 {
        return Ok(());
    }
    let mut remedy = edge;
    while estimate(mesh, remedy) > limit as f64 {
        remedy *= 1.25;
    }
    let triangles = triangles as u64;
    let mebibytes = triangles.saturating_mul(BYTES_PER_TRIANGLE) >> 20;
    Err(Error::TooFine { edge, triangles, mebibytes, limit, remedy })
}

/// About how many triangles there will be: a part has an area of edge²/8 to edge²/4, a sliver is
/// cut into parts at least half an edge long.
pub fn estimate(mesh: &Mesh, edge: f32) -> f64 {
    let edge = f64::from(edge);
    (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = corners(mesh, t);
            let longest = f64::from(a.distance(b).max(b.distance(c)).max(c.distance(a)));
            let area = 0.5 * f64::from((b - a).cross(c - a).length());
            if longest <= edge { 1.0 } else { (6.0 * area / (edge * edge)).max(longest / edge).max(2.0) }
        })
        .sum()
}
