//! Triangles with their materials on the way to a glTF file.

use std::collections::{BTreeMap, HashMap};

use anyhow::bail;
use radfile::{Material, Materials, Texture, Wrap};
use scene::Scene;
use serde_json::{Map, Value, json};

use super::glb::Glb;

/// Largest file that the format can hold.
const MOST_BYTES: u64 = u32::MAX as u64;

/// A corner of a triangle.
#[derive(Clone, Copy, Default)]
pub struct Corner {
    /// Metres, local axes.
    pub position: [f32; 3],
    /// Sets of texture coordinates, those of the surface.
    pub uv: [[f32; 2]; 3],
    /// Colour, if the surface has one.
    pub colour: [f32; 4],
}

/// Which set of texture coordinates is for what.
#[derive(Clone, Copy, Default)]
pub struct Sets {
    /// Number of sets.
    pub count: usize,
    /// That of the base colour.
    pub base: usize,
    /// That of emission.
    pub emission: usize,
}

/// Triangles of a scene's materials, their corners joined where they are the same.
#[derive(Default)]
pub struct Surface {
    corners: Vec<Corner>,
    numbers: HashMap<[u32; 13], u32>,
    triangles: BTreeMap<u32, Vec<u32>>,
}

impl Surface {
    /// Adds a triangle of a material.
    pub fn add(&mut self, material: u32, corners: [Corner; 3]) {
        let numbers = corners.map(|corner| self.number(corner));
        self.triangles.entry(material).or_default().extend(numbers);
    }

    fn number(&mut self, corner: Corner) -> u32 {
        let values = corner.position.iter().chain(corner.uv.as_flattened()).chain(&corner.colour);
        let mut key = [0; 13];
        key.iter_mut().zip(values).for_each(|(bits, value)| *bits = value.to_bits());
        *self.numbers.entry(key).or_insert_with(|| {
            self.corners.push(corner);
            self.corners.len() as u32 - 1
        })
    }

    /// Vertices and triangles.
    pub fn size(&self) -> [usize; 2] {
        [self.corners.len(), self.triangles.values().map(|t| t.len() / 3).sum()]
    }

    /// The file. `coloured` surfaces are shown as they are, base colour times colour of the corners; others are lit by who
    /// shows them. `extras` are those of the document.
    pub fn to_glb(&self, scene: &Scene, sets: Sets, coloured: bool, extras: Value) -> anyhow::Result<Vec<u8>> {
        let textures: u64 = scene.materials.textures.iter().map(|t| t.bytes.len() as u64).sum();
        let bytes = self.corners.len() as u64 * 52 + self.triangles.values().map(|t| 4 * t.len() as u64).sum::<u64>();
        if bytes + textures > MOST_BYTES / 2 {
            bail!("the scene takes {} bytes as glTF, a .glb file holds 4 GiB; export a smaller one", bytes + textures);
        }
        let mut glb = Glb::default();
        let mut attributes = Map::new();
        let mut add = |name: String, accessor: usize| attributes.insert(name, accessor.into());
        add("POSITION".into(), glb.vertices(&self.values(|c| c.position)));
        for set in 0..sets.count {
            add(format!("TEXCOORD_{set}"), glb.vertices(&self.values(|c| c.uv[set])));
        }
        if coloured {
            add("COLOR_0".into(), glb.vertices(&self.values(|c| c.colour)));
        }
        let (mut primitives, mut materials) = (Vec::new(), Vec::new());
        for (number, (material, indices)) in self.triangles.iter().enumerate() {
            let indices = glb.indices(indices);
            primitives.push(json!({ "attributes": &attributes, "indices": indices, "material": number }));
            let material = &scene.materials.materials[*material as usize];
            // Coloured triangles are there once a side.
            let two_sided = !scene.mesh.one_sided && !coloured;
            materials.push(if coloured { shown(material, sets) } else { lit(material, sets, two_sided) });
        }
        let mut document = Map::new();
        let mut put = |key: &str, value: Value| document.insert(key.into(), value);
        put("asset", json!({ "version": "2.0", "generator": "allbounce" }));
        let extensions: &[&str] =
            if coloured { &["KHR_materials_unlit"] } else { &["KHR_materials_emissive_strength"] };
        put("extensionsUsed", json!(extensions));
        put("scene", json!(0));
        put("scenes", json!([{ "nodes": [0] }]));
        put("nodes", json!([{ "mesh": 0, "translation": scene.mesh.origin }]));
        put("meshes", json!([{ "primitives": primitives }]));
        put("materials", json!(materials));
        embed(&scene.materials, &mut glb, &mut put);
        put("extras", extras);
        Ok(glb.finish(document))
    }

    fn values<T>(&self, value: impl Fn(&Corner) -> T) -> Vec<T> {
        self.corners.iter().map(value).collect()
    }
}

/// A diffuse material.
fn lit(material: &Material, sets: Sets, two_sided: bool) -> Value {
    let mut value =
        json!({ "name": material.name, "pbrMetallicRoughness": base(material, sets), "doubleSided": two_sided });
    let strength = material.emission.iter().fold(0.0f32, |m, e| m.max(*e));
    if strength > 0.0 {
        value["emissiveFactor"] = json!(material.emission.map(|e| e / strength));
        value["extensions"] = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": strength } });
        if let Some(texture) = material.emission_texture {
            value["emissiveTexture"] = json!({ "index": texture, "texCoord": sets.emission });
        }
    }
    value
}

/// A material that is shown as it is.
fn shown(material: &Material, sets: Sets) -> Value {
    json!({ "name": material.name, "pbrMetallicRoughness": base(material, sets), "extensions": { "KHR_materials_unlit": {} } })
}

fn base(material: &Material, sets: Sets) -> Value {
    let [r, g, b] = material.reflectance;
    let mut value = json!({ "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0 });
    if let Some(texture) = material.reflectance_texture {
        value["baseColorTexture"] = json!({ "index": texture, "texCoord": sets.base });
    }
    value
}

/// Textures, as the scene file had them.
fn embed(materials: &Materials, glb: &mut Glb, put: &mut impl FnMut(&str, Value) -> Option<Value>) {
    let (mut textures, mut images, mut samplers) = (Vec::new(), Vec::new(), Vec::new());
    for (number, Texture { name, bytes, wrap }) in materials.textures.iter().enumerate() {
        let kind = if bytes.starts_with(b"\x89PNG") { "image/png" } else { "image/jpeg" };
        images.push(json!({ "name": name, "bufferView": glb.view(bytes, None), "mimeType": kind }));
        let code = |wrap: Wrap| match wrap {
            Wrap::Repeat => 10497,
            Wrap::Mirror => 33648,
            Wrap::Clamp => 33071,
        };
        samplers.push(json!({ "wrapS": code(wrap[0]), "wrapT": code(wrap[1]) }));
        textures.push(json!({ "source": number, "sampler": number }));
    }
    put("textures", textures.into());
    put("images", images.into());
    put("samplers", samplers.into());
}
