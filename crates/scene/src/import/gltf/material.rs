//! glTF materials to diffuse ones: base colour and emission, with their textures.

use std::collections::HashMap;

use glam::{DAffine2, DMat2, DVec2};
use radfile::Wrap;

use super::{
    document::Document,
    schema::{Material, Sampler, TextureInfo},
};
use crate::{
    Result,
    import::{
        files::Files,
        notes::Notes,
        palette::{Palette, RawMaterial},
    },
};

/// A material in the palette, and where its textures take their coordinates from.
pub struct MaterialUse {
    pub number: u32,
    pub reflectance: Option<TextureUse>,
    pub emission: Option<TextureUse>,
}

/// Coordinates of a texture.
pub struct TextureUse {
    /// `TEXCOORD_n`.
    pub set: usize,
    /// `KHR_texture_transform`.
    pub transform: DAffine2,
}

/// Materials of a file, made when they are first used.
pub struct MaterialTable<'a> {
    document: &'a Document<'a>,
    files: &'a Files<'a>,
    palette: &'a mut Palette,
    made: HashMap<Option<usize>, MaterialUse>,
}

impl<'a> MaterialTable<'a> {
    pub fn new(document: &'a Document, files: &'a Files, palette: &'a mut Palette) -> MaterialTable<'a> {
        MaterialTable { document, files, palette, made: HashMap::new() }
    }

    /// The material with this number in the file, or what stands in for none.
    pub fn get(&mut self, index: Option<usize>, notes: &mut Notes) -> Result<&MaterialUse> {
        if !self.made.contains_key(&index) {
            let made = match index {
                Some(index) => self.make(index, notes)?,
                None => {
                    notes.say("primitives without a material are grey 0.5");
                    let number = self.palette.add(RawMaterial::grey(""), notes);
                    MaterialUse { number, reflectance: None, emission: None }
                }
            };
            self.made.insert(index, made);
        }
        Ok(&self.made[&index])
    }

    fn make(&mut self, index: usize, notes: &mut Notes) -> Result<MaterialUse> {
        let document = self.document;
        let material = document.get(&document.root.materials, index, "material")?;
        let name = if material.name.is_empty() { format!("material {index}") } else { material.name.clone() };
        note_ignored(material, notes);
        let (factor, texture) = base_colour(material);
        let reflectance = self.texture(texture, notes)?;
        let emission = self.texture(material.emissive_texture.as_ref(), notes)?;
        let strength = material.extensions.emissive_strength.as_ref().and_then(|e| e.emissive_strength).unwrap_or(1.0);
        let [r, g, b, _] = factor;
        let raw = RawMaterial {
            name,
            reflectance: [r, g, b],
            reflectance_texture: reflectance.as_ref().map(|(number, _)| *number),
            emission: material.emissive_factor.unwrap_or([0.0; 3]).map(|e| e * strength),
            emission_texture: emission.as_ref().map(|(number, _)| *number),
        };
        let number = self.palette.add(raw, notes);
        Ok(MaterialUse { number, reflectance: reflectance.map(|r| r.1), emission: emission.map(|e| e.1) })
    }

    /// Number of a texture in the palette and its coordinates; `None` if there is none that can be used.
    fn texture(&mut self, info: Option<&TextureInfo>, notes: &mut Notes) -> Result<Option<(u32, TextureUse)>> {
        let (Some(info), document, files) = (info, self.document, self.files) else { return Ok(None) };
        let texture = document.get(&document.root.textures, info.index, "texture")?;
        let sampler = texture.sampler.map(|s| document.get(&document.root.samplers, s, "sampler")).transpose()?;
        let Some(source) = texture.source else {
            let what = "textures have no PNG or JPEG image, the plain colour of their materials is used";
            notes.name(what, &format!("texture {}", info.index));
            return Ok(None);
        };
        let image = document.get(&document.root.images, source, "image")?;
        let name = match (&image.uri, image.name.as_str()) {
            (_, name) if !name.is_empty() => format!("{name} (image {source})"),
            (Some(uri), _) if !uri.starts_with("data:") => uri.clone(),
            _ => format!("image {source}"),
        };
        let load = |notes: &mut Notes| match (&image.uri, image.buffer_view) {
            (Some(uri), _) => document.load_uri(uri, files, notes).ok(),
            (None, Some(view)) => document.view(view).ok().map(|(bytes, _)| bytes.to_vec()),
            (None, None) => None,
        };
        let number = self.palette.texture(&name, wrap(sampler), notes, load);
        Ok(number.map(|number| (number, texture_use(info))))
    }
}

/// Base colour factor with alpha, and its texture.
fn base_colour(material: &Material) -> ([f64; 4], Option<&TextureInfo>) {
    match (&material.pbr_metallic_roughness, &material.extensions.specular_glossiness) {
        // Where a file has both, the extension is the one that was authored.
        (_, Some(sg)) => (sg.diffuse_factor.unwrap_or([1.0; 4]), sg.diffuse_texture.as_ref()),
        (Some(pbr), None) => (pbr.base_color_factor.unwrap_or([1.0; 4]), pbr.base_color_texture.as_ref()),
        (None, None) => ([1.0; 4], None),
    }
}

fn note_ignored(material: &Material, notes: &mut Notes) {
    let pbr = material.pbr_metallic_roughness.as_ref();
    // Metalness is 1 where a file says nothing of it.
    let metal = pbr.is_some_and(|p| p.metallic_factor.unwrap_or(1.0) > 0.0);
    let see_through = material.alpha_mode.as_deref().is_some_and(|mode| mode != "OPAQUE");
    let kinds = [
        (metal, "metalness is ignored, surfaces are diffuse; materials"),
        (see_through, "alpha is ignored, surfaces are opaque; materials"),
        (material.normal_texture.is_some(), "normal maps are ignored; materials"),
        (material.extensions.unlit.is_some(), "unlit materials are lit like all others; materials"),
    ];
    for (_, what) in kinds.iter().filter(|(is, _)| *is) {
        notes.count(what, 1);
    }
}

fn wrap(sampler: Option<&Sampler>) -> [Wrap; 2] {
    let mode = |code: Option<u32>| match code {
        Some(33071) => Wrap::Clamp,
        Some(33648) => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    sampler.map_or([Wrap::Repeat; 2], |s| [mode(s.wrap_s), mode(s.wrap_t)])
}

/// The extension's own listing turns the other way than its text and all viewers; the text is followed: with v
/// downwards, a positive angle turns coordinates counter-clockwise as seen in the image.
fn texture_use(info: &TextureInfo) -> TextureUse {
    let Some(transform) = &info.extensions.transform else {
        return TextureUse { set: info.tex_coord, transform: DAffine2::IDENTITY };
    };
    let scale = DMat2::from_diagonal(DVec2::from(transform.scale.unwrap_or([1.0; 2])));
    let turn = DMat2::from_angle(-transform.rotation);
    let offset = DVec2::from(transform.offset.unwrap_or([0.0; 2]));
    TextureUse {
        set: transform.tex_coord.unwrap_or(info.tex_coord),
        transform: DAffine2::from_mat2_translation(turn * scale, offset),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moved(json: &str, uv: [f64; 2]) -> [f64; 2] {
        let json = format!(r#"{{"index":0,"texCoord":1,"extensions":{{"KHR_texture_transform":{json}}}}}"#);
        let info: TextureInfo = serde_json::from_str(&json).unwrap();
        let moved = texture_use(&info).transform.transform_point2(uv.into());
        [moved.x, moved.y].map(|c| (c * 1e12).round() / 1e12)
    }

    #[test]
    fn texture_transforms_scale_then_turn_then_move() {
        assert_eq!(moved(r#"{"offset":[0.5,0.25],"scale":[2,3]}"#, [1.0, 1.0]), [2.5, 3.25]);
        let quarter = format!(r#"{{"rotation":{}}}"#, std::f64::consts::FRAC_PI_2);
        assert_eq!(moved(&quarter, [1.0, 0.0]), [0.0, -1.0], "u turns up, against v");
        let all = format!(r#"{{"rotation":{},"scale":[2,3],"offset":[1,1]}}"#, std::f64::consts::FRAC_PI_2);
        assert_eq!(moved(&all, [1.0, 1.0]), [4.0, -1.0]);
    }

    #[test]
    fn the_transform_may_choose_another_set_of_coordinates() {
        let info = |ext: &str| serde_json::from_str::<TextureInfo>(&format!(r#"{{"index":0,"texCoord":1{ext}}}"#));
        assert_eq!(texture_use(&info("").unwrap()).set, 1);
        let ext = r#","extensions":{"KHR_texture_transform":{"texCoord":0}}"#;
        assert_eq!(texture_use(&info(ext).unwrap()).set, 0);
    }
}
