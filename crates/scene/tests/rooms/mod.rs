//! Closed rooms of many triangles that share their vertices.

use std::collections::HashMap;

use glam::Vec3;
use scene::{Rays, hash};

/// A box from -1 to 1 whose walls are cut to a grid, seen from inside.
pub struct ClosedRoom {
    scale: f32,
    offset: Vec3,
    vertices: Vec<[f32; 3]>,
    pub triangles: Vec<[usize; 3]>,
}

/// A number in [0, 1) from random bits.
pub fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}

impl ClosedRoom {
    /// Plane walls, vertices at multiples of 2/n.
    pub fn regular(n: i32) -> ClosedRoom {
        ClosedRoom::build(n, 1.0, Vec3::ZERO, 0.0)
    }

    /// Every vertex is moved by up to a third of a cell in every direction.
    pub fn irregular(n: i32, scale: f32, offset: Vec3) -> ClosedRoom {
        ClosedRoom::build(n, scale, offset, 0.66)
    }

    fn build(n: i32, scale: f32, offset: Vec3, jitter: f32) -> ClosedRoom {
        let mut room = ClosedRoom { scale, offset, vertices: vec![], triangles: vec![] };
        let mut numbers = HashMap::new();
        for wall in 0..6 {
            for (i, j) in (0..n * n).map(|c| (c / n, c % n)) {
                let corner = |i: i32, j: i32| {
                    let mut p = [0; 3];
                    p[wall % 3] = if wall < 3 { 0 } else { n };
                    (p[(wall + 1) % 3], p[(wall + 2) % 3]) = (i, j);
                    p
                };
                let cell = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                let mut v = cell.map(|p| {
                    *numbers.entry(p).or_insert_with(|| {
                        let moved = |a: usize| {
                            let shift = jitter
                                * (unit(hash(p[0] as u32 + 1000 * a as u32, (p[1] * n * 2 + p[2]) as u32)) - 0.5);
                            (p[a] as f32 + shift) * (2.0 / n as f32) - 1.0
                        };
                        room.vertices.push(room.place([moved(0), moved(1), moved(2)]).into());
                        room.vertices.len() - 1
                    })
                });
                if wall >= 3 {
                    v.reverse();
                }
                room.triangles.extend([[v[0], v[1], v[2]], [v[0], v[2], v[3]]]);
            }
        }
        room
    }

    /// A point of the unit room, brought to this one.
    pub fn place(&self, p: [f32; 3]) -> Vec3 {
        self.scale * Vec3::from(p) + self.offset
    }

    pub fn corners(&self, triangle: usize) -> [[f32; 3]; 3] {
        self.triangles[triangle].map(|v| self.vertices[v])
    }

    pub fn rays(&self) -> Rays {
        Rays::from_triangles(self.triangles.len(), |t| self.corners(t))
    }
}
