//! The binary form of glTF: a document and one buffer in a file.
//!
//! Source: Khronos glTF 2.0 specification, §3.6 (buffers and accessors), §4 (GLB).

use serde_json::{Map, Value, json};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The buffer of a file, with what lies where.
#[derive(Default)]
pub struct Glb {
    buffer: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Glb {
    /// Adds values of vertices; returns the number of their accessor.
    pub fn vertices<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ARRAY_BUFFER));
        let bound = |f: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..N).map(|k| values.iter().map(|v| v[k]).reduce(f).unwrap_or(0.0)).collect()
        };
        let (min, max) = (bound(f32::min), bound(f32::max));
        let kind = format!("VEC{N}");
        self.accessors.push(json!({ "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": kind,
            "min": min, "max": max }));
        self.accessors.len() - 1
    }

    /// Adds vertices of triangles; returns the number of their accessor.
    pub fn indices(&mut self, indices: &[u32]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        self.accessors.push(
            json!({ "bufferView": view, "componentType": UNSIGNED_INT, "count": indices.len(), "type": "SCALAR" }),
        );
        self.accessors.len() - 1
    }

    /// Adds bytes, from a multiple of four on; returns the number of their view.
    pub fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.buffer.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    /// The file: `document` has everything but the buffer and what lies where. Empty lists, which glTF forbids, are left out.
    pub fn finish(mut self, document: Map<String, Value>) -> Vec<u8> {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let mut document = document;
        document.insert("buffers".into(), json!([{ "byteLength": self.buffer.len() }]));
        document.insert("bufferViews".into(), self.views.into());
        document.insert("accessors".into(), self.accessors.into());
        document.retain(|_, value| value.as_array().is_none_or(|list| !list.is_empty()));
        let mut text = Value::Object(document).to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let total = 12 + 8 + text.len() + 8 + self.buffer.len();
        let mut file = Vec::with_capacity(total);
        file.extend(b"glTF");
        file.extend([2, total as u32].iter().flat_map(|v| v.to_le_bytes()));
        for (kind, bytes) in [(b"JSON", &text), (b"BIN\0", &self.buffer)] {
            file.extend((bytes.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(bytes);
        }
        file
    }
}
