//! Which sides of the fine vertices receive light, and where exactly.
//!
//! At a vertex the triangles that meet there form groups: those that face about the same way and
//! lie in the same open air share one receiver. Where a wall stands on a floor there are
//! groups for the wall and for the floor on either side of it. A receiver is moved a little into its group, because
//! the vertex itself may lie in the wall.

use glam::Vec3;
use radfile::{FineMesh, Mesh, NO_RECEIVER, Patches, Progress, Side, face_id};
use rayon::prelude::*;

use crate::{
    sight::{Place, Sight},
    triangle::nearest_point,
};

/// Triangles that differ in direction by less than 30 degrees may share a receiver.
const SAME_FACING: f32 = 0.866;
/// How far receivers are moved from the vertex towards the middle of their triangles.
const PULL: f32 = 0.1;

/// A side of a fine vertex.
pub struct Receiver {
    pub position: Vec3,
    pub normal: Vec3,
    /// Face of the mesh that it lies on.
    pub face: u32,
    /// Corners of the fine mesh that it serves: triangle, side, corner.
    corners: Vec<[u32; 3]>,
}

/// Corners that may share a receiver, and the first of them.
struct Group {
    seed: Place,
    corners: Vec<[u32; 3]>,
}

/// Finds the receivers of the fine mesh, in the order of vertices, and enters them in `fine.receiver`.
pub fn find(
    mesh: &Mesh,
    patches: &Patches,
    sight: &Sight,
    fine: &mut FineMesh,
    progress: &dyn Progress,
) -> Vec<Receiver> {
    let (start, corner) = corners_of_vertices(fine);
    let finder = Finder { mesh, patches, sight, fine };
    let receivers: Vec<Receiver> = (0..fine.vertex.len())
        .into_par_iter()
        .flat_map_iter(|v| {
            let receivers = finder.at_vertex(&corner[start[v] as usize..start[v + 1] as usize]);
            progress.advance(1);
            receivers
        })
        .collect();
    fine.receiver = vec![[[NO_RECEIVER; 3]; 2]; fine.triangle.len()];
    for (number, receiver) in receivers.iter().enumerate() {
        for &[triangle, side, corner] in &receiver.corners {
            fine.receiver[triangle as usize][side as usize][corner as usize] = number as u32;
        }
    }
    receivers
}

/// For every vertex, offsets into the list of (triangle, corner) that meet there.
fn corners_of_vertices(fine: &FineMesh) -> (Vec<u32>, Vec<(u32, u32)>) {
    let mut start = vec![0u32; fine.vertex.len() + 1];
    for &v in fine.triangle.as_flattened() {
        start[v as usize + 1] += 1;
    }
    for v in 0..fine.vertex.len() {
        start[v + 1] += start[v];
    }
    let mut next = start.clone();
    let mut corners = vec![(0, 0); 3 * fine.triangle.len()];
    for (t, triangle) in fine.triangle.iter().enumerate() {
        for (c, &v) in triangle.iter().enumerate() {
            corners[next[v as usize] as usize] = (t as u32, c as u32);
            next[v as usize] += 1;
        }
    }
    (start, corners)
}

struct Finder<'a> {
    mesh: &'a Mesh,
    patches: &'a Patches,
    sight: &'a Sight<'a>,
    fine: &'a FineMesh,
}

impl Finder<'_> {
    fn at_vertex(&self, corners: &[(u32, u32)]) -> Vec<Receiver> {
        let mut groups: Vec<Group> = Vec::new();
        for side in [Side::Front, Side::Back] {
            for &(triangle, corner) in corners {
                let Some(place) = self.place(triangle, corner, side) else { continue };
                let corner = [triangle, side as u32, corner];
                match groups.iter_mut().find(|g| self.fits(&g.seed, &place)) {
                    Some(group) => group.corners.push(corner),
                    None => groups.push(Group { seed: place, corners: vec![corner] }),
                }
            }
        }
        groups.into_iter().map(|g| self.receiver(g)).collect()
    }

    /// Where one corner would receive; `None` if its side has no patches and so sees nothing.
    fn place(&self, triangle: u32, corner: u32, side: Side) -> Option<Place> {
        let face = face_id(self.fine.source[triangle as usize], side) as usize;
        let starts = &self.patches.locator.face_start;
        if starts[face] == starts[face + 1] || (self.mesh.one_sided && side == Side::Back) {
            return None;
        }
        let points = self.corners(triangle);
        let normal = area_normal(points, side as u32).try_normalize()?;
        let position = points[corner as usize].lerp(centroid(points), PULL);
        Some(self.sight.place(position, normal))
    }

    fn fits(&self, seed: &Place, place: &Place) -> bool {
        seed.normal.dot(place.normal) > SAME_FACING && self.sight.joined(seed, place)
    }

    fn receiver(&self, group: Group) -> Receiver {
        let [first, _, corner] = group.corners[0];
        let vertex = self.corners(first)[corner as usize];
        let (mut normal, mut middle, mut sum) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for &[triangle, side, corner] in &group.corners {
            let points = self.corners(triangle);
            let angle = angle_at(points, corner as usize);
            normal += angle * area_normal(points, side).normalize_or_zero();
            middle += angle * centroid(points);
            sum += angle;
        }
        let wanted = if sum > 0.0 { vertex.lerp(middle / sum, PULL) } else { group.seed.position };
        let on = |&[triangle, side, _]: &[u32; 3]| {
            let position = nearest_point(self.corners(triangle), wanted);
            (position, face_id(self.fine.source[triangle as usize], if side == 0 { Side::Front } else { Side::Back }))
        };
        let (position, face) = group
            .corners
            .iter()
            .map(on)
            .min_by(|a, b| a.0.distance_squared(wanted).total_cmp(&b.0.distance_squared(wanted)))
            .expect("a group starts with one corner");
        let normal = normal.try_normalize().unwrap_or(group.seed.normal);
        Receiver { position, normal, face, corners: group.corners }
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.fine.triangle[triangle as usize].map(|v| Vec3::from(self.fine.vertex[v as usize]))
    }
}

fn centroid([a, b, c]: [Vec3; 3]) -> Vec3 {
    (a + b + c) / 3.0
}

/// The angle that a triangle takes up at a corner: its share of the surface around a vertex, however it was cut.
fn angle_at(points: [Vec3; 3], corner: usize) -> f32 {
    let [p, q, r] = [0, 1, 2].map(|k| points[(corner + k) % 3]);
    let (a, b) = (q - p, r - p);
    a.cross(b).length().atan2(a.dot(b))
}

/// Normal on a side, twice the area long.
fn area_normal([a, b, c]: [Vec3; 3], side: u32) -> Vec3 {
    let front = (b - a).cross(c - a);
    if side == 0 { front } else { -front }
}
