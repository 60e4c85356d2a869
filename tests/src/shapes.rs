//! Shapes that rooms of physics tests are made of; every front faces where the light is.

use std::f64::consts::TAU;

use crate::mesh_text::{MeshText, Paint};

/// A parallelogram that faces along `u` × `v`.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
pub struct Plate {
    /// One corner, metres.
    pub corner: [f64; 3],
    /// The edge to the second corner.
    pub u: [f64; 3],
    /// The edge to the last corner.
    pub v: [f64; 3],
}

impl Plate {
    /// The point `corner` + s u + t v.
    pub fn at(&self, s: f64, t: f64) -> [f64; 3] {
        std::array::from_fn(|a| self.corner[a] + s * self.u[a] + t * self.v[a])
    }

    /// Unit normal of the front.
    pub fn normal(&self) -> [f64; 3] {
        let cross: [f64; 3] = std::array::from_fn(|a| {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            self.u[b] * self.v[c] - self.u[c] * self.v[b]
        });
        cross.map(|x| x / dot(cross, cross).sqrt())
    }

    /// Adds it to a mesh.
    pub fn add(&self, mesh: &mut MeshText, paint: Paint) {
        mesh.polygon(paint, &[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(s, t)| self.at(s, t)));
    }

    /// Whether a point lies on it and a unit normal is that of its front.
    pub fn holds(&self, point: [f64; 3], normal: [f64; 3]) -> bool {
        let from_corner: [f64; 3] = std::array::from_fn(|a| point[a] - self.corner[a]);
        let own = self.normal();
        let inside = |edge: [f64; 3]| (-1e-4..=1.0001).contains(&(dot(from_corner, edge) / dot(edge, edge)));
        dot(own, normal) > 0.99 && dot(own, from_corner).abs() < 1e-4 && inside(self.u) && inside(self.v)
    }
}

/// The six walls of a box, fronts inwards: low and high x, y, z.
pub fn inside_of_box(low: [f64; 3], high: [f64; 3]) -> [Plate; 6] {
    let along = |axis: usize| -> [f64; 3] { std::array::from_fn(|a| if a == axis { high[a] - low[a] } else { 0.0 }) };
    std::array::from_fn(|wall| {
        let (b, c) = ((wall / 2 + 1) % 3, (wall / 2 + 2) % 3);
        let corner = |far: bool| std::array::from_fn(|a| if far && a == wall / 2 { high[a] } else { low[a] });
        match wall % 2 {
            0 => Plate { corner: corner(false), u: along(b), v: along(c) },
            _ => Plate { corner: corner(true), u: along(c), v: along(b) },
        }
    })
}

/// The six walls of a box, fronts outwards.
pub fn outside_of_box(low: [f64; 3], high: [f64; 3]) -> [Plate; 6] {
    inside_of_box(low, high).map(|p| Plate { corner: p.corner, u: p.v, v: p.u })
}

/// Which way the front of a sphere looks.
#[derive(Clone, Copy, PartialEq)]
pub enum Facing {
    /// To the middle.
    Inwards,
    /// Away from it.
    Outwards,
}

/// A polyhedron inscribed in a sphere about the origin: `rings` bands from pole to pole, `sectors` faces a band. The
/// first `open` bands below the pole at +z are left out.
pub fn sphere(mesh: &mut MeshText, paint: Paint, radius: f64, [rings, sectors, open]: [usize; 3], facing: Facing) {
    let corner = |ring: usize, sector: usize| {
        let (polar, azimuth) =
            (0.5 * TAU * ring as f64 / rings as f64, TAU * (sector % sectors) as f64 / sectors as f64);
        let level = radius * if ring == rings { 0.0 } else { polar.sin() };
        [level * azimuth.cos(), level * azimuth.sin(), radius * polar.cos()]
    };
    for ring in open..rings {
        for sector in 0..sectors {
            // Counter-clockwise seen from the middle; at a pole two corners are one.
            let mut face = vec![corner(ring, sector), corner(ring, sector + 1)];
            face.extend([corner(ring + 1, sector + 1), corner(ring + 1, sector)]);
            if ring == 0 {
                face.remove(1);
            } else if ring + 1 == rings {
                face.remove(2);
            }
            if facing == Facing::Outwards {
                face.reverse();
            }
            mesh.polygon(paint, &face);
        }
    }
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fronts_look_into_a_box_and_out_of_it() {
        for (plates, side) in
            [(inside_of_box([0.0; 3], [1.0, 2.0, 3.0]), 1.0), (outside_of_box([0.0; 3], [1.0, 2.0, 3.0]), -1.0)]
        {
            for plate in plates {
                let to_middle: [f64; 3] = std::array::from_fn(|a| [0.5, 1.0, 1.5][a] - plate.at(0.5, 0.5)[a]);
                assert!(side * dot(plate.normal(), to_middle) > 0.0, "{plate:?}");
            }
        }
    }
}
