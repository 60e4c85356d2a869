//! A mesh of coloured polygons and its text as OBJ and MTL, or as glTF.

use std::{collections::HashMap, fmt::Write};

use serde_json::json;

/// A diffuse material.
#[derive(Clone, Copy, Debug)]
pub struct Paint {
    pub name: &'static str,
    /// Linear reflectance.
    pub reflectance: [f64; 3],
    /// Radiance of the front, W/(m² sr).
    pub emission: [f64; 3],
}

impl Paint {
    /// A paint that only reflects.
    pub const fn matt(name: &'static str, reflectance: [f64; 3]) -> Paint {
        Paint { name, reflectance, emission: [0.0; 3] }
    }
}

/// Polygons, counter-clockwise seen from the front, vertices shared by position.
#[derive(Default)]
pub struct MeshText {
    vertices: Vec<[f64; 3]>,
    /// Vertices are shared when they agree to a micrometre.
    index: HashMap<[i64; 3], usize>,
    polygons: Vec<(usize, Vec<usize>)>,
    paints: Vec<Paint>,
}

impl MeshText {
    /// Adds a polygon.
    pub fn polygon(&mut self, paint: Paint, corners: &[[f64; 3]]) {
        let paint = match self.paints.iter().position(|p| p.name == paint.name) {
            Some(at) => at,
            None => {
                self.paints.push(paint);
                self.paints.len() - 1
            }
        };
        let corners = corners.iter().map(|&c| self.vertex(c)).collect();
        self.polygons.push((paint, corners));
    }

    fn vertex(&mut self, position: [f64; 3]) -> usize {
        let key = position.map(|x| (x * 1e6).round() as i64);
        *self.index.entry(key).or_insert_with(|| {
            self.vertices.push(position);
            self.vertices.len() - 1
        })
    }

    /// Corners of the polygons.
    pub fn faces(&self) -> impl Iterator<Item = Vec<[f64; 3]>> + '_ {
        self.polygons.iter().map(|(_, corners)| corners.iter().map(|&c| self.vertices[c]).collect())
    }

    /// The glTF file and its buffer: the first paint only, and at every vertex the mean normal of the polygons that meet
    /// there, as of a mesh that is smooth across its edges.
    pub fn smooth_gltf(&self, buffer_file: &str) -> (String, Vec<u8>) {
        let mut normals = vec![[0.0; 3]; self.vertices.len()];
        let mut indices: Vec<u32> = Vec::new();
        for (_, corners) in &self.polygons {
            let [a, b, c] = [0, 1, 2].map(|k| self.vertices[corners[k]]);
            let [u, v] = [b, c].map(|p| [0, 1, 2].map(|i| p[i] - a[i]));
            let normal = [0, 1, 2].map(|i| u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
            let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            corners.iter().for_each(|&corner| (0..3).for_each(|i| normals[corner][i] += normal[i] / length));
            indices
                .extend((2..corners.len()).flat_map(|k| [corners[0] as u32, corners[k - 1] as u32, corners[k] as u32]));
        }
        normals.iter_mut().for_each(|n| {
            let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
            *n = if length > 0.0 { n.map(|x| x / length) } else { [0.0, 1.0, 0.0] };
        });
        let bytes = |vectors: &[[f64; 3]]| -> Vec<u8> {
            vectors.as_flattened().iter().flat_map(|x| (*x as f32).to_le_bytes()).collect()
        };
        let (position, normal) = (bytes(&self.vertices), bytes(&normals));
        let index: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        let bound = |of: fn(f64, f64) -> f64| {
            [0, 1, 2].map(|i| self.vertices.iter().map(|p| p[i] as f32 as f64).reduce(of).unwrap_or(0.0))
        };
        let [red, green, blue] = self.paints[0].reflectance;
        let (n, all) = (position.len(), 2 * position.len() + index.len());
        let vectors =
            |view: usize| json!({ "bufferView": view, "componentType": 5126, "count": normals.len(), "type": "VEC3" });
        let mut positions = vectors(0);
        (positions["min"], positions["max"]) = (json!(bound(f64::min)), json!(bound(f64::max)));
        let gltf = json!({
            "asset": { "version": "2.0" },
            "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0 }] }],
            "materials": [{ "pbrMetallicRoughness": { "baseColorFactor": [red, green, blue, 1.0], "metallicFactor": 0.0 } }],
            "buffers": [{ "uri": buffer_file, "byteLength": all }],
            "bufferViews": [
                { "buffer": 0, "byteOffset": 0, "byteLength": n },
                { "buffer": 0, "byteOffset": n, "byteLength": n },
                { "buffer": 0, "byteOffset": 2 * n, "byteLength": index.len() },
            ],
            "accessors": [
                positions,
                vectors(1),
                { "bufferView": 2, "componentType": 5125, "count": indices.len(), "type": "SCALAR" },
            ],
        });
        (gltf.to_string(), [position, normal, index].concat())
    }

    /// The OBJ file.
    pub fn obj(&self, material_file: &str) -> String {
        let mut text = format!(
            "# made by `cargo run --release -p allbounce-tests --example make_assets`; metres, +Y up\nmtllib {material_file}\n"
        );
        for [x, y, z] in &self.vertices {
            writeln!(text, "v {} {} {}", metres(*x), metres(*y), metres(*z)).expect("writing to a string");
        }
        for (number, paint) in self.paints.iter().enumerate() {
            writeln!(text, "usemtl {}", paint.name).expect("writing to a string");
            for (_, corners) in self.polygons.iter().filter(|(p, _)| *p == number) {
                let corners: Vec<String> = corners.iter().map(|c| (c + 1).to_string()).collect();
                writeln!(text, "f {}", corners.join(" ")).expect("writing to a string");
            }
        }
        text
    }

    /// The MTL file.
    pub fn mtl(&self) -> String {
        let rgb = |[r, g, b]: [f64; 3]| format!("{r} {g} {b}");
        let mut text = String::new();
        for paint in &self.paints {
            writeln!(text, "newmtl {}\nKd {}", paint.name, rgb(paint.reflectance)).expect("writing to a string");
            if paint.emission != [0.0; 3] {
                writeln!(text, "Ke {}", rgb(paint.emission)).expect("writing to a string");
            }
        }
        text
    }
}

/// A coordinate in micrometre steps, without a tail of digits.
fn metres(x: f64) -> f64 {
    (x * 1e6).round() / 1e6 + 0.0
}
