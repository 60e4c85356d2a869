//! Materials and textures of an import: made physical, without duplicates, every texture known to decode.

use std::collections::HashMap;

use radfile::{Material, Materials, Texture, Wrap};

use super::notes::Notes;
use crate::{MAX_REFLECTANCE, texture::Image};

/// A material as a file gives it, unchecked.
#[derive(Clone, Debug)]
pub struct RawMaterial {
    pub name: String,
    pub reflectance: [f64; 3],
    pub reflectance_texture: Option<u32>,
    pub emission: [f64; 3],
    pub emission_texture: Option<u32>,
}

impl RawMaterial {
    /// What stands in for a material that the file does not define.
    pub fn grey(name: &str) -> RawMaterial {
        RawMaterial {
            name: name.into(),
            reflectance: [0.5; 3],
            reflectance_texture: None,
            emission: [0.0; 3],
            emission_texture: None,
        }
    }
}

/// A texture of an image, by how it is wrapped.
type Known = ([Wrap; 2], Option<u32>);

/// Collects the materials and textures that triangles use.
#[derive(Default)]
pub struct Palette {
    materials: Materials,
    /// Textures of every image that was asked for, by wrap; `None` if it cannot be used.
    known: HashMap<String, Vec<Known>>,
    /// Largest linear value of each texture.
    brightest: Vec<[f32; 3]>,
}

impl Palette {
    /// The texture made of the image called `name`; `load` is asked for its bytes the first time. `None`, and a
    /// note, if it is missing or cannot be decoded.
    pub fn texture(
        &mut self,
        name: &str,
        wrap: [Wrap; 2],
        notes: &mut Notes,
        load: impl FnOnce(&mut Notes) -> Option<Vec<u8>>,
    ) -> Option<u32> {
        let known = self.known.get(name).into_iter().flatten().find(|(w, _)| *w == wrap);
        if let Some((_, texture)) = known {
            return *texture;
        }
        let made = match load(notes) {
            None => {
                notes.name("textures are missing, the plain colour of their materials is used", name);
                None
            }
            Some(bytes) => self.decode(name, wrap, bytes, notes),
        };
        self.known.entry(name.to_owned()).or_default().push((wrap, made));
        made
    }

    fn decode(&mut self, name: &str, wrap: [Wrap; 2], bytes: Vec<u8>, notes: &mut Notes) -> Option<u32> {
        match Image::decode(&bytes) {
            Ok(image) => {
                self.brightest.push(image.brightest());
                self.materials.textures.push(Texture { name: name.into(), bytes, wrap });
                Some(self.materials.textures.len() as u32 - 1)
            }
            Err(why) => {
                let what =
                    "textures cannot be decoded (expected PNG or JPEG), the plain colour of their materials is used";
                notes.name(what, &format!("{name} ({why})"));
                None
            }
        }
    }

    /// Adds a material and returns its number. Reflectance is brought into 0..[`MAX_REFLECTANCE`], emission
    /// above 0; what had to be changed is noted by the material's name.
    pub fn add(&mut self, raw: RawMaterial, notes: &mut Notes) -> u32 {
        let name = raw.name.as_str();
        if !raw.reflectance.iter().all(|r| *r >= 0.0) {
            notes.name("reflectance that is negative or no number counts as 0 in materials", name);
        }
        let reflectance = raw.reflectance.map(|r| if r >= 0.0 { r.min(f64::from(f32::MAX)) as f32 } else { 0.0 });
        let texel = raw.reflectance_texture.map_or([1.0; 3], |t| self.brightest[t as usize]);
        // A factor of 1 is usual over a texture and must not darken it; its texels are clamped when sampled.
        let textured = raw.reflectance_texture.is_some();
        let (usual, most) = if textured { (1.0, 1.0f32.next_down()) } else { (MAX_REFLECTANCE, MAX_REFLECTANCE) };
        if reflectance.iter().any(|r| *r > usual) {
            notes.name(&format!("reflectance is clamped to {MAX_REFLECTANCE} in materials"), name);
        } else if (0..3).any(|c| reflectance[c] * texel[c] > MAX_REFLECTANCE) {
            let what = format!("the brightest texels are clamped to a reflectance of {MAX_REFLECTANCE}; materials");
            notes.count(&what, 1);
        }
        let shines = |e: f64| e >= 0.0 && (e as f32).is_finite();
        if !raw.emission.iter().all(|e| shines(*e)) {
            notes.name("emission that is negative or no finite number counts as 0 in materials", name);
        }
        self.materials.materials.push(Material {
            name: raw.name,
            reflectance: reflectance.map(|r| r.min(most)),
            reflectance_texture: raw.reflectance_texture,
            emission: raw.emission.map(|e| if shines(e) { e as f32 } else { 0.0 }),
            emission_texture: raw.emission_texture,
        });
        self.materials.materials.len() as u32 - 1
    }

    /// The finished materials.
    pub fn finish(self) -> Materials {
        self.materials
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn add(reflectance: [f64; 3], emission: [f64; 3]) -> (Material, Vec<String>) {
        let (mut palette, mut notes) = (Palette::default(), Notes::default());
        palette.add(RawMaterial { reflectance, emission, ..RawMaterial::grey("wall") }, &mut notes);
        (palette.finish().materials.remove(0), notes.into_warnings())
    }

    #[test]
    fn a_physical_material_passes_unchanged() {
        let (m, said) = add([0.0, 0.5, 0.99], [0.0, 17.0, 4.0]);
        assert_eq!((m.reflectance, m.emission), ([0.0, 0.5, 0.99], [0.0, 17.0, 4.0]));
        assert!(said.is_empty(), "{said:?}");
    }

    #[test]
    fn reflectance_of_one_or_more_is_clamped_and_the_material_named() {
        let (m, said) = add([1.0, 255.0, 0.2], [0.0; 3]);
        assert_eq!(m.reflectance, [MAX_REFLECTANCE, MAX_REFLECTANCE, 0.2]);
        assert_eq!(said, ["reflectance is clamped to 0.99 in materials: wall"]);
    }

    #[test]
    fn negative_and_undefined_colours_count_as_black() {
        let (m, said) = add([-0.5, f64::NAN, 0.2], [-1.0, f64::NAN, 1e39]);
        assert_eq!((m.reflectance, m.emission), ([0.0, 0.0, 0.2], [0.0; 3]));
        assert_eq!(said.len(), 2);
        assert!(said.iter().all(|s| s.ends_with("in materials: wall")), "{said:?}");
    }

    #[test]
    fn a_white_factor_over_a_texture_stays_white_and_an_image_is_loaded_once() {
        let mut png = Vec::new();
        let grey = image::GrayImage::from_raw(1, 1, vec![128]).unwrap();
        grey.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
        let (mut palette, mut notes) = (Palette::default(), Notes::default());
        let texture = palette.texture("t", [Wrap::Repeat; 2], &mut notes, |_| Some(png));
        assert_eq!(palette.texture("t", [Wrap::Repeat; 2], &mut notes, |_| panic!("loaded twice")), texture);
        let white = RawMaterial { reflectance: [1.0; 3], reflectance_texture: texture, ..RawMaterial::grey("w") };
        palette.add(white, &mut notes);
        let m = palette.finish().materials.remove(0);
        assert!(m.reflectance[0] < 1.0 && m.reflectance[0] > 0.999_999, "{m:?}");
        assert!(notes.into_warnings().is_empty());
    }

    #[test]
    fn missing_and_broken_images_leave_the_plain_colour_and_are_named() {
        let (mut palette, mut notes) = (Palette::default(), Notes::default());
        assert_eq!(palette.texture("gone.png", [Wrap::Repeat; 2], &mut notes, |_| None), None);
        assert_eq!(palette.texture("bad.png", [Wrap::Repeat; 2], &mut notes, |_| Some(b"GIF8".to_vec())), None);
        let said = notes.into_warnings();
        assert!(said[0].ends_with(": gone.png") && said[1].contains(": bad.png ("), "{said:?}");
    }
}
