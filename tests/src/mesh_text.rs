//! A mesh of coloured polygons and its text as OBJ and MTL.

use std::{collections::HashMap, fmt::Write};

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
