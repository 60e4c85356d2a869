//! glTF 2.0, `.gltf` and `.glb`.
//!
//! `glb` takes the container apart, `schema` is the JSON that matters, `document` holds both with the buffers,
//! `accessor` reads numbers with every bound checked, `nodes` walks the scene, `primitive` makes triangles,
//! `material` and `extras` what belongs to them. A schema of our own, because the `gltf` crate reads node
//! transforms in single precision, which tears scenes with map coordinates apart, and knows no instancing
//! (`docs/decisions/0005-gltf.md`); it is the second opinion in the tests.
//! Source: Khronos Group, glTF 2.0 Specification, version 2.0.1.

mod accessor;
mod data_uri;
mod document;
mod extras;
mod glb;
mod material;
mod nodes;
mod primitive;
mod schema;

use std::collections::HashMap;

use glam::DMat4;

use self::{document::Document, material::MaterialTable, nodes::Placed, primitive::Primitive};
use super::{
    assembly::{Assembly, Vertex},
    files::Files,
    notes::Notes,
    palette::Palette,
};
use crate::{Extras, Result};

/// Reads a glTF file into `assembly` and `palette`; returns its lights and cameras.
pub fn import(
    name: &str,
    bytes: &[u8],
    files: &Files,
    assembly: &mut Assembly,
    palette: &mut Palette,
    notes: &mut Notes,
) -> Result<Extras> {
    let document = Document::open(name, bytes, files, notes)?;
    document.note_ignored(notes);
    let mut reader = SceneReader {
        document: &document,
        materials: MaterialTable::new(&document, files, palette),
        meshes: HashMap::new(),
        assembly,
        notes,
    };
    let mut extras = Extras::default();
    for placed in nodes::walk(&document)? {
        reader.add_mesh(&placed)?;
        extras::add(&document, &placed, &mut extras, reader.notes)?;
    }
    Ok(extras)
}

/// Puts the meshes of nodes into the assembly.
struct SceneReader<'a, 's, 'n> {
    document: &'a Document<'a>,
    materials: MaterialTable<'a>,
    /// Meshes that were read, because nodes share them.
    meshes: HashMap<usize, Vec<Primitive>>,
    assembly: &'a mut Assembly<'s>,
    notes: &'n mut Notes,
}

impl SceneReader<'_, '_, '_> {
    fn add_mesh(&mut self, placed: &Placed) -> Result<()> {
        let Some(mesh) = placed.node.mesh else { return Ok(()) };
        if placed.node.skin.is_some() {
            self.notes.count("skins are ignored, skinned meshes stand where their node is", 1);
        }
        if !self.meshes.contains_key(&mesh) {
            let read = primitive::read_mesh(self.document, mesh, &mut self.materials, self.assembly, self.notes)?;
            self.meshes.insert(mesh, read);
        }
        let (instances, primitives) = (nodes::instances(self.document, placed)?, &self.meshes[&mesh]);
        let triangles: usize = primitives.iter().map(|p| p.triangles.len()).sum();
        if triangles == 0 {
            return Ok(());
        }
        self.assembly.room_for(triangles.saturating_mul(instances.len()))?;
        for i in 0..instances.len() {
            let transform = instances.get(i);
            for primitive in primitives {
                add_primitive(self.assembly, primitive, &transform)?;
            }
        }
        Ok(())
    }
}

fn add_primitive(assembly: &mut Assembly, primitive: &Primitive, transform: &DMat4) -> Result<()> {
    let moved = |v: &Vertex| Vertex { position: transform.transform_point3(v.position.into()).into(), ..*v };
    let vertices = primitive.vertices.iter().map(moved);
    // A mirroring transform would turn the front sides to the back.
    if transform.determinant() < 0.0 {
        let turned: Vec<[u32; 3]> = primitive.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        assembly.add(vertices, &turned, primitive.material)
    } else {
        assembly.add(vertices, &primitive.triangles, primitive.material)
    }
}
