//! The mesh as the stage sees it: welded, without what coincides, with normals and areas.
//!
//! Scene files repeat vertices along seams of texture coordinates, so vertices are welded where
//! their positions are equal. They also repeat triangles, either by mistake or, with the winding
//! turned, to make both sides visible. Light meets such a triangle once, so its area counts once:
//! one of the triangles carries the patches, the others are entered in the locator as its twins.

use std::collections::HashMap;

use glam::DVec3;
use radfile::{Piece, Side};
use scene::Scene;

use crate::Error;

/// Everything that does not depend on the voxel size.
pub struct Surface<'a> {
    pub scene: &'a Scene,
    /// Triangles that are clipped: they have an area and coincide with none before them.
    pub triangles: Vec<u32>,
    /// For every triangle of the mesh, the one that carries its patches; itself if it is clipped.
    pub carrier: Vec<u32>,
    /// Whether a triangle turns against its carrier.
    pub turned: Vec<bool>,
    /// For every triangle, the twins that it carries, itself not among them.
    pub twins: HashMap<u32, Vec<u32>>,
    /// Vertices with equal positions have equal numbers.
    pub welded: Vec<u32>,
    /// Unit normals of the front sides; zero for triangles without area.
    pub normal: Vec<DVec3>,
    /// Areas, m².
    pub area: Vec<f64>,
    /// Whether the material emits, that of the triangle or of a twin that it carries.
    pub emits: Vec<bool>,
    /// Corners of the bounding box of all clipped triangles.
    pub lower: DVec3,
    pub upper: DVec3,
    /// Sum over triangles of edge lengths and of areas, each in the measure that tells how many cells are crossed.
    pub edges: f64,
    pub faces: f64,
    pub coincident: usize,
    pub degenerate: usize,
}

impl<'a> Surface<'a> {
    /// Prepares a scene.
    ///
    /// # Errors
    ///
    /// A mesh without any area or with vertices that are no points.
    pub fn new(scene: &'a Scene) -> Result<Surface<'a>, Error> {
        let mesh = &scene.mesh;
        if mesh.triangles.is_empty() {
            return Err(Error::EmptyMesh);
        }
        if let Some(vertex) = mesh.positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(Error::NotFinite { vertex, position: mesh.positions[vertex] });
        }
        let count = mesh.triangles.len();
        let mut surface = Surface {
            scene,
            triangles: Vec::with_capacity(count),
            carrier: (0..count as u32).collect(),
            turned: vec![false; count],
            twins: HashMap::new(),
            welded: weld(&mesh.positions),
            normal: Vec::with_capacity(count),
            area: Vec::with_capacity(count),
            emits: mesh.triangle_material.iter().map(|&m| emits(scene, m)).collect(),
            lower: DVec3::INFINITY,
            upper: DVec3::NEG_INFINITY,
            edges: 0.0,
            faces: 0.0,
            coincident: 0,
            degenerate: 0,
        };
        surface.enter_triangles();
        if surface.triangles.is_empty() {
            return Err(Error::NoArea { triangles: count });
        }
        Ok(surface)
    }

    fn enter_triangles(&mut self) {
        let mut first: HashMap<([u32; 3], bool), u32> = HashMap::new();
        let one_sided = self.scene.mesh.one_sided;
        for t in 0..self.scene.mesh.triangles.len() as u32 {
            let [a, b, c] = self.corners(t);
            let cross = (b - a).cross(c - a);
            let welded = self.scene.mesh.triangles[t as usize].map(|v| self.welded[v as usize]);
            self.normal.push(cross.normalize_or_zero());
            self.area.push(0.5 * cross.length());
            if self.normal[t as usize] == DVec3::ZERO {
                self.degenerate += 1;
                continue;
            }
            let (key, odd) = sorted(welded);
            // A one-sided triangle and its turned twin have no side in common.
            let (carrier, carrier_odd) = match first.get(&(key, one_sided && odd)) {
                Some(&carrier) => {
                    (carrier, sorted(self.scene.mesh.triangles[carrier as usize].map(|v| self.welded[v as usize])).1)
                }
                None => (t, odd),
            };
            if carrier != t {
                self.coincident += 1;
                self.carrier[t as usize] = carrier;
                self.turned[t as usize] = odd != carrier_odd;
                self.emits[carrier as usize] |= self.emits[t as usize];
                self.twins.entry(carrier).or_default().push(t);
                continue;
            }
            first.insert((key, one_sided && odd), t);
            self.triangles.push(t);
            for p in [a, b, c] {
                self.lower = self.lower.min(p);
                self.upper = self.upper.max(p);
            }
            self.edges += [b - a, c - b, a - c].iter().map(|e| 0.5 * e.abs().element_sum()).sum::<f64>();
            self.faces += 0.5 * cross.abs().element_sum();
        }
    }

    /// Corners of a triangle of the mesh.
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.scene.mesh.corners(triangle as usize).map(|p| DVec3::from_array(p.map(f64::from)))
    }

    /// Whether this side of a triangle reflects and receives.
    pub fn uses(&self, side: Side) -> bool {
        side == Side::Front || !self.scene.mesh.one_sided
    }

    /// Whether the material of any of these pieces emits, on whichever side.
    pub fn shines(&self, pieces: &[Piece]) -> bool {
        pieces.iter().any(|p| self.emits[p.face as usize / 2])
    }

    /// Area of all sides that are used; what coincides counts once.
    pub fn used_area(&self) -> f64 {
        let sides = if self.scene.mesh.one_sided { 1.0 } else { 2.0 };
        sides * self.triangles.iter().map(|&t| self.area[t as usize]).sum::<f64>()
    }
}

/// The other side.
pub fn opposite(side: Side) -> Side {
    match side {
        Side::Front => Side::Back,
        Side::Back => Side::Front,
    }
}

/// `side`, or the other one if `turned`.
pub fn turn(side: Side, turned: bool) -> Side {
    if turned { opposite(side) } else { side }
}

fn emits(scene: &Scene, material: u32) -> bool {
    scene.materials.materials[material as usize].emission.iter().any(|&e| e > 0.0)
}

/// Equal positions get the number of the first of them.
fn weld(positions: &[[f32; 3]]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(positions.len());
    // Adding zero makes −0 and 0 the same bits.
    positions.iter().zip(0..).map(|(p, v)| *first.entry(p.map(|x| (x + 0.0).to_bits())).or_insert(v)).collect()
}

/// Three numbers in increasing order, and whether that was an odd permutation.
fn sorted([a, b, c]: [u32; 3]) -> ([u32; 3], bool) {
    let mut key = [a, b, c];
    key.sort_unstable();
    let even = [[a, b, c], [b, c, a], [c, a, b]].contains(&key);
    (key, !even)
}
