//! Wavefront OBJ with MTL, tolerant: what is sound is loaded, the rest is counted.
//!
//! `clean` makes the text sound, tobj reads it in double precision, `polygon` cuts faces into triangles,
//! `mtl` reads the material libraries. Source of the format: Wavefront, Object Files (.obj), appendix B1 of the
//! Advanced Visualizer manual.

mod clean;
mod mtl;
mod polygon;

use std::collections::HashMap;

use radfile::Wrap;
use tobj::LoadOptions;

use self::mtl::{Map, MtlMaterial};
use super::{
    assembly::{Assembly, Vertex},
    files::{Files, folder_of},
    notes::Notes,
    palette::{Palette, RawMaterial},
};
use crate::{Error, Result};

/// Reads an OBJ file into `assembly` and `palette`.
pub fn import(
    bytes: &[u8],
    files: &Files,
    assembly: &mut Assembly,
    palette: &mut Palette,
    notes: &mut Notes,
) -> Result<()> {
    let text = String::from_utf8_lossy(bytes);
    let clean = clean::clean(&text, notes);
    let library = Library::load(&clean.libraries, files, notes);
    let options = LoadOptions { single_index: true, ..LoadOptions::default() };
    // The clean text names no library; materials are found by the number that each model has for a name.
    let read = tobj::load_obj_buf(&mut clean.text.as_bytes(), &options, |_| Err(tobj::LoadError::OpenFileFailed));
    let (models, _) = read.map_err(|error| Error::Malformed {
        name: assembly.name().into(),
        what: format!("the OBJ text cannot be read ({error}); export it again"),
    })?;
    let mut numbers: HashMap<usize, u32> = HashMap::new();
    for model in &models {
        let Some(used) = model.name.parse::<usize>().ok().filter(|_| !model.mesh.indices.is_empty()) else { continue };
        let name = clean.materials[used].as_str();
        let material = *numbers.entry(used).or_insert_with(|| library.material(name, files, palette, notes));
        let triangles = triangles(&model.mesh, notes);
        assembly.add(vertices(&model.mesh), &triangles, material)?;
    }
    Ok(())
}

/// Positions and coordinates; OBJ counts v from the bottom row.
fn vertices(mesh: &tobj::Mesh) -> impl Iterator<Item = Vertex> {
    let positions = mesh.positions.as_chunks::<3>().0;
    let coordinates = mesh.texcoords.as_chunks::<2>().0;
    positions.iter().zip(coordinates).map(|(&position, &[u, v])| {
        let uv = [u as f32, (1.0 - v) as f32].map(|c| if c.is_finite() { c } else { 0.0 });
        Vertex { position, uv: [uv; 2], lightmap_uv: None }
    })
}

fn triangles(mesh: &tobj::Mesh, notes: &mut Notes) -> Vec<[u32; 3]> {
    if mesh.face_arities.is_empty() {
        return mesh.indices.as_chunks().0.to_vec();
    }
    let positions = mesh.positions.as_chunks::<3>().0;
    let (mut triangles, mut rest) = (vec![], &mesh.indices[..]);
    for &arity in &mesh.face_arities {
        let (face, after) = rest.split_at(arity as usize);
        rest = after;
        let corners: Vec<[f64; 3]> = face.iter().map(|&i| positions[i as usize]).collect();
        let (cut, simple) = polygon::triangulate(&corners);
        notes.count("polygons that cross themselves are cut as well as can be", usize::from(!simple));
        triangles.extend(cut.iter().map(|t| t.map(|k| face[k])));
    }
    triangles
}

/// The materials of all libraries that an OBJ file names.
struct Library(HashMap<String, (MtlMaterial, String)>);

impl Library {
    fn load(lines: &[String], files: &Files, notes: &mut Notes) -> Library {
        let mut library = Library(HashMap::new());
        for line in lines {
            // A line names one file, which may have spaces, or several.
            let whole = vec![(line.as_str(), files.find("", line, notes).ok())];
            let parts = match &whole[0].1 {
                None if line.contains(char::is_whitespace) => {
                    line.split_whitespace().map(|part| (part, files.find("", part, notes).ok())).collect()
                }
                _ => whole,
            };
            for (name, bytes) in parts {
                match bytes {
                    Some(bytes) => library.add(&String::from_utf8_lossy(&bytes), folder_of(name), notes),
                    None => notes.name("material libraries are missing", name),
                }
            }
        }
        library
    }

    fn add(&mut self, text: &str, folder: &str, notes: &mut Notes) {
        let folder = folder.trim_start_matches("./").replace('\\', "/");
        for material in mtl::parse(text, notes) {
            self.0.insert(material.name.clone(), (material, folder.clone()));
        }
    }

    /// Number of the material called `name`, with its textures loaded.
    fn material(&self, name: &str, files: &Files, palette: &mut Palette, notes: &mut Notes) -> u32 {
        let Some((mtl, folder)) = self.0.get(name) else {
            match name.is_empty() {
                true => notes.say("faces without a material are grey 0.5"),
                false => notes.name("materials are not defined and are grey 0.5", name),
            }
            return palette.add(RawMaterial::grey(name), notes);
        };
        mtl.note_ignored(notes);
        let mut texture = |map: &Option<Map>, notes: &mut Notes| {
            let map = map.as_ref()?;
            let wrap = if map.clamp { Wrap::Clamp } else { Wrap::Repeat };
            palette.texture(&map.file, [wrap; 2], notes, |notes| files.find(folder, &map.file, notes).ok())
        };
        // A map without a colour beside it is the whole colour.
        let reflectance_texture = texture(&mtl.reflectance_map, notes);
        let emission_texture = texture(&mtl.emission_map, notes);
        let missing = if reflectance_texture.is_some() { [1.0; 3] } else { [0.5; 3] };
        if mtl.reflectance.is_none() && reflectance_texture.is_none() {
            notes.name("materials without Kd are grey 0.5", name);
        }
        let raw = RawMaterial {
            name: name.into(),
            reflectance: mtl.reflectance.unwrap_or(missing),
            reflectance_texture,
            emission: mtl.emission.unwrap_or(if emission_texture.is_some() { [1.0; 3] } else { [0.0; 3] }),
            emission_texture,
        };
        palette.add(raw, notes)
    }
}
