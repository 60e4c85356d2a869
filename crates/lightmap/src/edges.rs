//! Edges of a mesh, found by where they are: vertices are split where textures or normals change.

use std::collections::HashMap;

use radfile::Mesh;

/// An edge as one triangle has it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Edge {
    /// Vertices at its ends, welded, the smaller first.
    pub ends: [u32; 2],
    pub triangle: u32,
    /// It runs from this corner to the next.
    pub corner: u8,
    /// Whether the triangle runs from the smaller end to the larger.
    pub forward: bool,
}

/// Vertices of the triangles, with one number for those at the same place: that of the first.
pub fn welded(mesh: &Mesh) -> Vec<[u32; 3]> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(mesh.positions.len());
    let mut weld = |v: u32| *first.entry(mesh.positions[v as usize].map(|x| (x + 0.0).to_bits())).or_insert(v);
    mesh.triangles.iter().map(|t| t.map(&mut weld)).collect()
}

/// The edges of all triangles; those at one place follow each other.
pub fn edges(mesh: &Mesh) -> Vec<Edge> {
    let mut edges = Vec::with_capacity(3 * mesh.triangles.len());
    for (triangle, places) in (0u32..).zip(welded(mesh)) {
        edges.extend((0..3u8).map(|corner| {
            let (a, b) = (places[corner as usize], places[(corner as usize + 1) % 3]);
            Edge { ends: [a.min(b), a.max(b)], triangle, corner, forward: a < b }
        }));
    }
    edges.sort_unstable();
    edges
}

/// Sets of numbers below a count, joined two by two.
pub struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    /// Every number alone.
    pub fn new(count: usize) -> Sets {
        Sets { parent: (0..count as u32).collect() }
    }

    /// The smallest number of a set.
    pub fn root(&mut self, mut at: u32) -> u32 {
        while self.parent[at as usize] != at {
            let up = self.parent[self.parent[at as usize] as usize];
            self.parent[at as usize] = up;
            at = up;
        }
        at
    }

    /// Makes two sets one.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
