//! A glTF file taken apart: JSON, buffers, and the refusal of what it must not be read without.

use super::{
    data_uri::data_uri,
    glb,
    schema::{Head, Root},
};
use crate::{
    Error, Result,
    import::{files::Files, notes::Notes},
};

/// Extensions whose effect is applied.
const APPLIED: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Extensions that change what is ignored by contract, so that a file that requires them can be read.
const HARMLESS: &[&str] = &[
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_xmp_json_ld",
];

const DRACO: &str = "KHR_draco_mesh_compression";
const MESHOPT: &str = "EXT_meshopt_compression";

/// What to do about an extension that is not supported.
fn remedy(extension: &str) -> &'static str {
    match extension {
        DRACO | MESHOPT | "KHR_meshopt_compression" | "MESHOPT_compression" => {
            "export the scene again with mesh compression switched off, or decompress the file first"
        }
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" | "MSFT_texture_dds" => {
            "export the scene again with PNG or JPEG textures"
        }
        _ => "export the scene again without it",
    }
}

/// A glTF file with its buffers.
pub struct Document<'a> {
    name: &'a str,
    pub root: Root,
    /// Bytes of each buffer; `None` where a buffer has none, as the fallback of compressed meshes.
    buffers: Vec<Option<Vec<u8>>>,
}

impl<'a> Document<'a> {
    /// Takes the file apart and loads its buffers.
    pub fn open(name: &'a str, bytes: &[u8], files: &Files, notes: &mut Notes) -> Result<Document<'a>> {
        let malformed = |what: String| Error::Malformed { name: name.into(), what };
        // The first bytes decide, not the ending: files of either kind are found under both.
        let (json, binary) = match bytes.starts_with(b"glTF") || name.to_ascii_lowercase().ends_with(".glb") {
            true => glb::split(bytes).map_err(malformed)?,
            false => (bytes, None),
        };
        let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
        let no_json = |e: serde_json::Error| malformed(format!("its JSON cannot be read: {e}; export it again"));
        let head: Head = serde_json::from_slice(json).map_err(no_json)?;
        if !head.asset.version.starts_with("2.") {
            let version = &head.asset.version;
            return Err(malformed(format!("it is glTF version {version:?}, expected 2.x; export it as glTF 2.0")));
        }
        let known = |e: &String| APPLIED.contains(&e.as_str()) || HARMLESS.contains(&e.as_str());
        if let Some(extension) = head.extensions_required.iter().find(|e| !known(e)) {
            return Err(unsupported(name, extension));
        }
        let root: Root = serde_json::from_slice(json).map_err(no_json)?;
        let mut document = Document { name, root, buffers: vec![] };
        for i in 0..document.root.buffers.len() {
            let bytes = document.load_buffer(i, binary, files, notes)?;
            document.buffers.push(bytes);
        }
        Ok(document)
    }

    fn load_buffer(
        &self,
        i: usize,
        binary: Option<&[u8]>,
        files: &Files,
        notes: &mut Notes,
    ) -> Result<Option<Vec<u8>>> {
        let buffer = &self.root.buffers[i];
        let mut bytes = match (&buffer.uri, binary) {
            (Some(uri), _) => self.load_uri(uri, files, notes)?,
            (None, Some(binary)) if i == 0 => binary.to_vec(),
            (None, _) => return Ok(None),
        };
        match usize::try_from(buffer.byte_length).ok().filter(|&l| l <= bytes.len()) {
            Some(length) => {
                bytes.truncate(length);
                Ok(Some(bytes))
            }
            None => Err(self.malformed(format!(
                "buffer {i} should have {} bytes, {} are there; the file or its .bin was cut short",
                buffer.byte_length,
                bytes.len()
            ))),
        }
    }

    /// Bytes behind a URI: inside the JSON, or in a file beside the scene.
    pub fn load_uri(&self, uri: &str, files: &Files, notes: &mut Notes) -> Result<Vec<u8>> {
        match data_uri(uri) {
            Some(decoded) => decoded.map_err(|what| self.malformed(what)),
            None => {
                let path = percent_decoded(uri);
                files.find("", &path, notes).map_err(|source| Error::Read { name: path, source })
            }
        }
    }

    /// Bytes of a buffer view, and its stride.
    pub fn view(&self, index: usize) -> Result<(&[u8], Option<u64>)> {
        let view = self.get(&self.root.buffer_views, index, "buffer view")?;
        let Some(bytes) = self.get(&self.buffers, view.buffer, "buffer")? else {
            return Err(match view.extensions.meshopt {
                Some(_) => unsupported(self.name, MESHOPT),
                None => self.malformed(format!("buffer {} has no bytes: no uri, no binary chunk", view.buffer)),
            });
        };
        let range = view.byte_offset.checked_add(view.byte_length).map(|end| view.byte_offset as usize..end as usize);
        match range.and_then(|range| bytes.get(range)) {
            Some(bytes) => Ok((bytes, view.byte_stride)),
            None => Err(self.malformed(format!(
                "buffer view {index} takes {} bytes from byte {} of buffer {}, which has {}; export it again",
                view.byte_length,
                view.byte_offset,
                view.buffer,
                bytes.len()
            ))),
        }
    }

    /// Entry `index` of one of the file's lists.
    pub fn get<'l, T>(&self, list: &'l [T], index: usize, kind: &str) -> Result<&'l T> {
        list.get(index).ok_or_else(|| {
            self.malformed(format!("{kind} {index} is named, there are {}; export it again", list.len()))
        })
    }

    pub fn malformed(&self, what: String) -> Error {
        Error::Malformed { name: self.name.into(), what }
    }

    /// The refusal of a mesh that is stored by an extension only.
    pub fn draco(&self) -> Error {
        unsupported(self.name, DRACO)
    }

    /// Notes what the file has as a whole that is ignored.
    pub fn note_ignored(&self, notes: &mut Notes) {
        let unlit = "KHR_materials_unlit"; // noted with its materials
        let known = |e: &&String| APPLIED.contains(&e.as_str()) || e.as_str() == unlit;
        for extension in self.root.extensions_used.iter().filter(|e| !known(e)) {
            notes.name("extensions are ignored", extension);
        }
        notes.count("animations are ignored, everything stands as in the file", self.root.animations.len());
    }
}

fn unsupported(name: &str, extension: &str) -> Error {
    Error::Extension { name: name.into(), extension: extension.into(), remedy: remedy(extension) }
}

/// `%20` and its like as the bytes they stand for (RFC 3986, section 2.1).
fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, after @ ..] = rest {
        let code = (*first == b'%').then(|| after.get(..2)).flatten();
        let byte = code.and_then(|c| std::str::from_utf8(c).ok()).and_then(|c| u8::from_str_radix(c, 16).ok());
        bytes.push(byte.unwrap_or(*first));
        rest = if byte.is_some() { &after[2..] } else { after };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_signs_are_decoded_and_stray_ones_kept() {
        assert_eq!(percent_decoded("a%20b%C3%A4.png"), "a bä.png");
        assert_eq!(percent_decoded("100%.png%2"), "100%.png%2");
    }
}
