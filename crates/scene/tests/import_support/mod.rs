//! What the import tests share: folders in memory and on disk, small images and glTF files made on the spot.
#![allow(dead_code)] // each test program uses its part

#[path = "../disk/mod.rs"]
mod disk;

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use disk::Disk;
use scene::{Folder, ImportOptions, ImportReport, Scene, import};
use serde_json::{Value, json};

/// Files in memory.
#[derive(Default)]
pub struct Memory(Vec<(String, Vec<u8>)>);

impl Memory {
    pub fn with(mut self, name: &str, bytes: impl Into<Vec<u8>>) -> Memory {
        self.0.push((name.into(), bytes.into()));
        self
    }

    pub fn import(&self, name: &str) -> scene::Result<(Scene, ImportReport)> {
        import(name, self, ImportOptions::default())
    }
}

impl Folder for Memory {
    fn read(&self, name: &str) -> std::io::Result<Vec<u8>> {
        let found = self.0.iter().find(|(n, _)| n == name);
        found.map(|(_, bytes)| bytes.clone()).ok_or(std::io::ErrorKind::NotFound.into())
    }

    fn list(&self, folder: &str) -> Vec<String> {
        let prefix = if folder.is_empty() { String::new() } else { format!("{folder}/") };
        let inside = self.0.iter().filter_map(|(n, _)| n.strip_prefix(prefix.as_str()));
        inside.filter_map(|n| n.split('/').next()).map(str::to_owned).collect()
    }
}

/// The folder of shared test data, if it is there.
pub fn shared(part: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared").join(part);
    if !path.is_dir() {
        // Not println!, whose lines are swallowed when a test passes.
        writeln!(std::io::stderr(), "skipped: the reference data {part} is not beside this checkout")
            .expect("standard error");
        return None;
    }
    Some(path)
}

/// Imports `folder/name` below the shared scenes.
pub fn import_shared(scenes: &Path, path: &str) -> scene::Result<(Scene, ImportReport)> {
    let (folder, name) = path.split_once('/').expect("a folder and a file");
    import(name, &Disk(scenes.join(folder)), ImportOptions::default())
}

/// A PNG image one texel high.
pub fn png(texels: &[[u8; 3]]) -> Vec<u8> {
    let image = image::RgbImage::from_raw(texels.len() as u32, 1, texels.concat()).expect("as many texels as bytes");
    let mut bytes = vec![];
    image.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).expect("memory takes any image");
    bytes
}

/// A glTF file being made: JSON, and a binary chunk that grows by one buffer view after the other.
pub struct Gltf {
    pub json: Value,
    pub binary: Vec<u8>,
}

impl Gltf {
    pub fn new() -> Gltf {
        let json = json!({"asset": {"version": "2.0"}, "bufferViews": [], "accessors": [], "materials": []});
        Gltf { json, binary: vec![] }
    }

    /// Adds an entry to a list of the JSON and returns its number.
    pub fn push(&mut self, list: &str, entry: Value) -> usize {
        let list = self.json.as_object_mut().expect("an object").entry(list).or_insert(json!([]));
        let list = list.as_array_mut().expect("a list");
        list.push(entry);
        list.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.binary.len();
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    pub fn floats<const N: usize>(&mut self, elements: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = elements.as_flattened().iter().flat_map(|f| f.to_le_bytes()).collect();
        let (view, kind) = (self.view(&bytes), ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1]);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": 5126, "count": elements.len(), "type": kind}),
        )
    }

    pub fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": 5123, "count": indices.len(), "type": "SCALAR"}),
        )
    }

    /// A mesh of one primitive.
    pub fn mesh(&mut self, primitive: Value) -> usize {
        self.push("meshes", json!({"primitives": [primitive]}))
    }

    /// The bytes of a `.glb`.
    pub fn glb(mut self) -> Vec<u8> {
        self.json["buffers"] = json!([{"byteLength": self.binary.len()}]);
        let mut json = self.json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + json.len() + 8 + self.binary.len();
        let mut bytes = [b"glTF".as_slice(), &2u32.to_le_bytes(), &(length as u32).to_le_bytes()].concat();
        for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &self.binary)] {
            bytes.extend((chunk.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(chunk);
        }
        bytes
    }

    pub fn import(self) -> scene::Result<(Scene, ImportReport)> {
        Memory::default().with("s.glb", self.glb()).import("s.glb")
    }
}

/// A square of two triangles in z = 0, seen from +z, with one mesh and one node.
pub fn square() -> Gltf {
    let mut g = Gltf::new();
    let positions = g.floats(&[[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    let indices = g.indices(&[0, 1, 2, 0, 2, 3]);
    g.mesh(json!({"attributes": {"POSITION": positions}, "indices": indices, "material": 0}));
    g.push(
        "materials",
        json!({"name": "m", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.4, 0.3, 1], "metallicFactor": 0}}),
    );
    g.push("nodes", json!({"mesh": 0}));
    g
}

/// Corners of every triangle in the scene file's axes.
pub fn corners(scene: &Scene) -> Vec<[[f64; 3]; 3]> {
    let world = |p: [f32; 3]| std::array::from_fn(|k| f64::from(p[k]) + scene.mesh.origin[k]);
    (0..scene.mesh.triangles.len()).map(|t| scene.mesh.corners(t).map(world)).collect()
}

/// Area of all triangles.
pub fn area(scene: &Scene) -> f64 {
    let one = |t: [[f64; 3]; 3]| {
        let [a, b, c] = t.map(glam::DVec3::from);
        0.5 * (b - a).cross(c - a).length()
    };
    corners(scene).into_iter().map(one).sum()
}
