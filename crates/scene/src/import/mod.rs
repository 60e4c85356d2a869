//! Scene files to [`Scene`]: OBJ + MTL and glTF 2.0, with a report of what was ignored.
//!
//! Both readers fill the same two things: `assembly` (triangles in f64) and `palette` (materials and
//! textures). What both do with sound input, such as dropping triangles without area or moving the origin, is
//! done there; `notes` collects the sentences of the report; `files` finds what a scene names.

mod assembly;
mod files;
mod gltf;
mod notes;
mod obj;
mod palette;

use serde::Serialize;

use self::{assembly::Assembly, files::Files, notes::Notes, palette::Palette};
use crate::{Error, Result, Scene};

/// Where a scene file and the files it names are read from.
pub trait Folder {
    /// Bytes of a file; `name` is relative to the folder of the scene file, with `/` between parts.
    fn read(&self, name: &str) -> std::io::Result<Vec<u8>>;
    /// Names in a sub-folder (`""` for the folder itself), for names in the wrong case.
    fn list(&self, folder: &str) -> Vec<String>;
}

/// How to import.
#[derive(Clone, Copy, Debug, Default)]
pub struct ImportOptions {
    /// Back sides neither reflect nor receive.
    pub one_sided: bool,
}

/// What was found, dropped and ignored.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ImportReport {
    /// Triangles that the file describes, those that were dropped as unusable or repeated included.
    pub found: usize,
    /// Triangles that were kept.
    pub triangles: usize,
    /// Materials of these triangles.
    pub materials: usize,
    /// Textures of these materials.
    pub textures: usize,
    /// One sentence for each kind of thing that was dropped, ignored, clamped or repaired, with its count.
    pub warnings: Vec<String>,
}

/// Imports the scene file `name`; the ending decides the format.
///
/// Triangles keep the order of the file; in glTF that is primitive by primitive of the nodes, depth first.
/// Positions are stored in single precision about `mesh.origin`, which is the centre of the bounding box if a
/// coordinate is more than 8 times larger than the box, otherwise (0, 0, 0). Reflectances are clamped to
/// [`crate::MAX_REFLECTANCE`]; only the factor of a textured material may be larger, as its texels are clamped
/// when they are sampled.
///
/// # Errors
///
/// What cannot be read or is refused, in one sentence. Files may hold anything: nothing panics.
pub fn import(name: &str, folder: &dyn Folder, options: ImportOptions) -> Result<(Scene, ImportReport)> {
    let read = || folder.read(name).map_err(|source| Error::Read { name: name.into(), source });
    let files = Files::new(folder);
    let (mut assembly, mut notes, mut palette) = (Assembly::new(name), Notes::default(), Palette::default());
    let ending = name.rsplit_once('.').map(|(_, ending)| ending.to_ascii_lowercase()).unwrap_or_default();
    let extras = match ending.as_str() {
        "obj" => {
            obj::import(&read()?, &files, &mut assembly, &mut palette, &mut notes)?;
            Default::default()
        }
        "gltf" | "glb" => gltf::import(name, &read()?, &files, &mut assembly, &mut palette, &mut notes)?,
        _ => {
            let what = "the ending is unknown, expected .obj, .gltf or .glb".into();
            return Err(Error::Malformed { name: name.into(), what });
        }
    };
    let (found, materials) = (assembly.len(), palette.finish());
    let mesh = assembly.finish(options, !materials.textures.is_empty(), &mut notes)?;
    let report = ImportReport {
        found,
        triangles: mesh.triangles.len(),
        materials: materials.materials.len(),
        textures: materials.textures.len(),
        warnings: notes.into_warnings(),
    };
    if mesh.triangles.is_empty() {
        let detail = match report.warnings.is_empty() {
            true => "it has no faces".into(),
            false => report.warnings.join("; "),
        };
        return Err(Error::Empty { name: name.into(), detail });
    }
    Ok((Scene { mesh, materials, extras }, report))
}
