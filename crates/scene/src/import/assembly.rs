//! Triangles of an import, gathered in double precision and then brought into a [`Mesh`].
//!
//! Dropped, with a count: triangles with a corner that is no number or too far away, triangles without area,
//! and exact repetitions (same corners, same winding, same material). A repetition adds no surface, but every
//! later stage would count its area twice and let rays choose between the two by chance. Coincident triangles
//! that differ in winding or material are kept and reported, because dropping one would lose a colour or a lamp.

use std::{
    collections::{HashMap, HashSet, hash_map::Entry},
    hash::{DefaultHasher, Hash, Hasher},
};

use glam::DVec3;
use radfile::Mesh;

use super::{ImportOptions, notes::Notes};
use crate::{Error, Result};

/// Coordinates beyond this are taken for damage.
const MAX_COORDINATE: f64 = 1e15;
/// Largest extent of a scene: squares of areas must stay finite in single precision.
const MAX_EXTENT: f64 = 1e9;
/// The origin moves when a coordinate is this many times larger than the scene: about three bits are lost until then.
const FAR_AWAY: f64 = 8.0;
/// More triangles than this are refused before memory is asked for them.
const MAX_TRIANGLES: usize = 1 << 25;
/// Doubled area relative to the longest edge squared below which the rounding of f32 corners decides the normal.
const THINNEST: f64 = 1e-7;
/// Doubled area in m² whose square is no longer a normal number in single precision.
const SMALLEST: f64 = 1e-18;

/// A vertex in the scene file's axes.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// Metres.
    pub position: [f64; 3],
    /// Coordinates in the reflectance texture and in the emission texture, row 0 first.
    pub uv: [[f32; 2]; 2],
    /// Coordinates in a lightmap of the scene file, row 0 first.
    pub lightmap_uv: Option<[f32; 2]>,
}

/// Triangles on their way to a [`Mesh`].
pub struct Assembly<'a> {
    name: &'a str,
    vertices: Vec<Vertex>,
    triangles: Vec<[u32; 3]>,
    material: Vec<u32>,
}

impl<'a> Assembly<'a> {
    /// Nothing yet; `name` is the scene file's, for messages.
    pub fn new(name: &'a str) -> Assembly<'a> {
        Assembly { name, vertices: vec![], triangles: vec![], material: vec![] }
    }

    /// Name of the scene file.
    pub fn name(&self) -> &'a str {
        self.name
    }

    /// Says whether `triangles` more still fit.
    pub fn room_for(&self, triangles: usize) -> Result<()> {
        let total = self.triangles.len().saturating_add(triangles);
        match total <= MAX_TRIANGLES {
            true => Ok(()),
            false => Err(self.malformed(format!(
                "it has {total} triangles or more once instances are counted, expected at most {MAX_TRIANGLES}; simplify it"
            ))),
        }
    }

    /// Adds vertices and triangles that count from the first of them.
    pub fn add(&mut self, vertices: impl Iterator<Item = Vertex>, triangles: &[[u32; 3]], material: u32) -> Result<()> {
        self.room_for(triangles.len())?;
        let first = self.vertices.len() as u32;
        self.vertices.extend(vertices);
        self.triangles.extend(triangles.iter().map(|t| t.map(|i| first + i)));
        self.material.extend(std::iter::repeat_n(material, triangles.len()));
        Ok(())
    }

    /// How many triangles were added.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// The mesh, which may be empty; without texture coordinates unless it is `textured`.
    pub fn finish(mut self, options: ImportOptions, textured: bool, notes: &mut Notes) -> Result<Mesh> {
        let sound = |v: &Vertex| v.position.iter().all(|x| x.abs() <= MAX_COORDINATE);
        let out_of_range = self.keep_triangles(|a, t| a.triangles[t].iter().all(|&i| sound(&a.vertices[i as usize])));
        notes.count("triangles with a corner that is no number or beyond 1e15 are dropped", out_of_range);
        self.compact();
        let origin = self.origin()?;
        if origin != [0.0; 3] {
            notes.say("coordinates are large, positions are kept relative to the middle of the scene");
        }
        let positions = self.positions_about(origin);
        let thin = self.keep_triangles(|a, t| has_area(a.triangles[t].map(|i| positions[i as usize])));
        notes.count("triangles without area are dropped", thin);
        self.drop_repetitions(&positions, notes);
        self.compact();
        let mut mesh = Mesh { origin, one_sided: options.one_sided, ..Mesh::default() };
        mesh.positions = self.positions_about(origin);
        (mesh.triangles, mesh.triangle_material) = (self.triangles, self.material);
        if textured {
            mesh.uv = self.vertices.iter().map(|v| v.uv[0]).collect();
        }
        if textured && self.vertices.iter().any(|v| v.uv[0] != v.uv[1]) {
            mesh.emission_uv = self.vertices.iter().map(|v| v.uv[1]).collect();
        }
        if self.vertices.iter().any(|v| v.lightmap_uv.is_some()) {
            mesh.lightmap_uv = self.vertices.iter().map(|v| v.lightmap_uv.unwrap_or_default()).collect();
        }
        Ok(mesh)
    }

    /// Positions in single precision; -0 becomes 0, so that equal positions have equal bits.
    fn positions_about(&self, origin: [f64; 3]) -> Vec<[f32; 3]> {
        let local = |v: &Vertex| std::array::from_fn(|k| (v.position[k] - origin[k]) as f32 + 0.0);
        self.vertices.iter().map(local).collect()
    }

    /// Keeps the triangles that pass; returns how many did not.
    fn keep_triangles(&mut self, passes: impl Fn(&Self, usize) -> bool) -> usize {
        let kept: Vec<usize> = (0..self.triangles.len()).filter(|&t| passes(self, t)).collect();
        let dropped = self.triangles.len() - kept.len();
        if dropped > 0 {
            self.triangles = kept.iter().map(|&t| self.triangles[t]).collect();
            self.material = kept.iter().map(|&t| self.material[t]).collect();
        }
        dropped
    }

    /// Forgets vertices that no triangle has.
    fn compact(&mut self) {
        let mut number = vec![u32::MAX; self.vertices.len()];
        self.triangles.iter().flatten().for_each(|&i| number[i as usize] = 0);
        let mut used = 0;
        for n in number.iter_mut().filter(|n| **n == 0) {
            (*n, used) = (used, used + 1);
        }
        let mut at = number.iter();
        self.vertices.retain(|_| at.next() != Some(&u32::MAX));
        self.triangles.iter_mut().flatten().for_each(|i| *i = number[*i as usize]);
    }

    /// Middle of the bounding box if single precision about (0, 0, 0) would be too coarse, otherwise (0, 0, 0).
    fn origin(&self) -> Result<[f64; 3]> {
        let positions = || self.vertices.iter().map(|v| DVec3::from(v.position));
        let Some((low, high)) = positions().map(|p| (p, p)).reduce(|(l, h), (p, _)| (l.min(p), h.max(p))) else {
            return Ok([0.0; 3]);
        };
        let extent = (high - low).max_element();
        if extent > MAX_EXTENT {
            return Err(self.malformed(format!(
                "the scene is {extent:e} units across, from {low} to {high}, expected at most {MAX_EXTENT:e}; remove the vertex that is far away"
            )));
        }
        let farthest = low.abs().max(high.abs()).max_element();
        Ok(if farthest > FAR_AWAY * extent { (0.5 * (low + high)).to_array() } else { [0.0; 3] })
    }

    fn drop_repetitions(&mut self, positions: &[[f32; 3]], notes: &mut Notes) {
        let key = |t: usize| (oriented(self.triangles[t].map(|i| bits(positions[i as usize]))), self.material[t]);
        let mut first: HashMap<u64, u32> = HashMap::with_capacity(self.triangles.len());
        let mut places: HashSet<u64> = HashSet::with_capacity(self.triangles.len());
        let (mut keep, mut coincident) = (Vec::with_capacity(self.triangles.len()), 0);
        for t in 0..self.triangles.len() {
            let key_t = key(t);
            // Different triangles with the same hash are both kept: only a proven repetition is dropped.
            keep.push(match first.entry(hash(&key_t)) {
                Entry::Vacant(entry) => {
                    entry.insert(t as u32);
                    true
                }
                Entry::Occupied(entry) => key(*entry.get() as usize) != key_t,
            });
            let mut corners = key_t.0;
            corners.sort_unstable();
            coincident += usize::from(keep[t] && !places.insert(hash(&corners)));
        }
        let dropped = self.keep_triangles(|_, t| keep[t]);
        notes.count("exact repetitions of a triangle are dropped", dropped);
        let what = "triangles lie exactly on another with a different winding or material and are kept";
        notes.count(what, coincident);
    }

    fn malformed(&self, what: String) -> Error {
        Error::Malformed { name: self.name.into(), what }
    }
}

/// Whether a triangle has a normal that single precision can hold.
fn has_area(corners: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = corners.map(|p| glam::Vec3::from(p).as_dvec3());
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    let doubled = (b - a).cross(c - a).length();
    doubled > SMALLEST && doubled > THINNEST * longest
}

fn bits(p: [f32; 3]) -> [u32; 3] {
    p.map(f32::to_bits)
}

/// The corners, rotated so that the smallest comes first; the winding stays.
fn oriented(mut corners: [[u32; 3]; 3]) -> [[u32; 3]; 3] {
    let first = (0..3).min_by_key(|&i| corners[i]).unwrap_or(0);
    corners.rotate_left(first);
    corners
}

fn hash(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finish(corners: &[[f64; 3]], triangles: &[[u32; 3]]) -> (Result<Mesh>, Vec<String>) {
        let (mut assembly, mut notes) = (Assembly::new("test.obj"), Notes::default());
        let vertices = corners.iter().map(|&position| Vertex { position, uv: [[0.0; 2]; 2], lightmap_uv: None });
        assembly.add(vertices, triangles, 0).unwrap();
        let mesh = assembly.finish(ImportOptions::default(), false, &mut notes);
        (mesh, notes.into_warnings())
    }

    const CORNER: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0]];

    #[test]
    fn repetitions_are_dropped_and_the_other_winding_is_kept() {
        let (mesh, said) = finish(&CORNER, &[[0, 1, 2], [1, 2, 0], [0, 2, 1]]);
        assert_eq!(mesh.unwrap().triangles, [[0, 1, 2], [0, 2, 1]]);
        assert_eq!(said[0], "exact repetitions of a triangle are dropped: 1");
        assert!(said[1].ends_with("different winding or material and are kept: 1"), "{said:?}");
    }

    #[test]
    fn triangles_without_area_are_dropped_and_their_vertices_forgotten() {
        let (mesh, said) = finish(&CORNER, &[[0, 1, 2], [0, 1, 3], [1, 1, 2]]);
        let mesh = mesh.unwrap();
        assert_eq!((mesh.triangles, mesh.positions.len()), (vec![[0, 1, 2]], 3));
        assert_eq!(said, ["triangles without area are dropped: 2"]);
    }

    #[test]
    fn corners_that_are_no_numbers_cost_their_triangle_only() {
        let mut corners = CORNER.to_vec();
        corners.extend([[f64::NAN, 0.0, 0.0], [1e39, 0.0, 0.0], [f64::NEG_INFINITY, 0.0, 0.0]]);
        let (mesh, said) = finish(&corners, &[[0, 1, 2], [0, 4, 2], [5, 1, 2], [0, 1, 6]]);
        let mesh = mesh.unwrap();
        assert_eq!((mesh.triangles.len(), mesh.positions.len()), (1, 3));
        assert_eq!(said, ["triangles with a corner that is no number or beyond 1e15 are dropped: 3"]);
    }

    #[test]
    fn a_scene_far_away_keeps_its_shape_about_its_middle() {
        let shift = [5e8, 2e4, 4.6e9];
        let moved = CORNER.map(|p| std::array::from_fn(|k| p[k] * 8.0 + shift[k]));
        let (mesh, said) = finish(&moved, &[[0, 1, 2]]);
        let mesh = mesh.unwrap();
        assert_eq!(mesh.origin, [5e8 + 4.0, 2e4 + 4.0, 4.6e9]);
        assert_eq!(mesh.positions, [[-4.0, -4.0, 0.0], [4.0, -4.0, 0.0], [-4.0, 4.0, 0.0]]);
        assert!(said[0].starts_with("coordinates are large"), "{said:?}");
        assert_eq!(finish(&CORNER, &[[0, 1, 2]]).0.unwrap().origin, [0.0; 3], "a near scene stays where it is");
    }

    #[test]
    fn a_scene_with_a_stray_vertex_is_refused() {
        let error = finish(&[[0.0; 3], [1e12, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]).0.unwrap_err().to_string();
        assert!(error.starts_with("test.obj: the scene is 1e12 units across, from"), "{error}");
    }

    #[test]
    fn too_many_triangles_are_refused_before_they_are_made() {
        let error = Assembly::new("big.glb").room_for(usize::MAX).unwrap_err().to_string();
        assert!(error.starts_with("big.glb: it has ") && error.contains("expected at most 33554432"), "{error}");
    }
}
