//! Diffuse materials and their textures, still encoded as the scene file had them.

use serde::{Deserialize, Serialize};

use crate::{Builder, Container, Error, FLAG_REQUIRED, Record, Result};

/// One diffuse material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Name in the scene file, for messages.
    pub name: String,
    /// Linear RGB factor, 0 ≤ ρ < 1; multiplied by the texture if there is one.
    pub reflectance: [f32; 3],
    /// Index into [`Materials::textures`]; its texels are sRGB.
    pub reflectance_texture: Option<u32>,
    /// Radiance of the front side, W/(m² sr), linear RGB; multiplied by the texture if there is one.
    pub emission: [f32; 3],
    /// Index into [`Materials::textures`]; its texels are sRGB.
    pub emission_texture: Option<u32>,
}

/// How a texture goes on beyond 0..1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Wrap {
    /// Tiles.
    Repeat,
    /// Tiles, every other one mirrored.
    Mirror,
    /// The border goes on.
    Clamp,
}

/// An encoded image.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Name or path in the scene file, for messages.
    pub name: String,
    /// PNG or JPEG bytes.
    pub bytes: Vec<u8>,
    /// Horizontal and vertical continuation.
    pub wrap: [Wrap; 2],
}

/// All materials of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Materials {
    /// The materials that `mesh.material` counts.
    pub materials: Vec<Material>,
    /// The textures that materials count.
    pub textures: Vec<Texture>,
}

#[derive(Serialize, Deserialize)]
struct Meta {
    materials: Vec<Material>,
    /// Name, length in `materials.textures`, wrap.
    textures: Vec<(String, u64, [Wrap; 2])>,
}

const META: &str = "materials.meta";

impl Materials {
    /// Whether every reflectance is grey, so that one channel of the operator serves all three.
    /// Textures count as coloured.
    pub fn is_grey(&self) -> bool {
        self.materials.iter().all(|m| {
            let [r, g, b] = m.reflectance;
            m.reflectance_texture.is_none() && r == g && g == b
        })
    }

    fn check(&self) -> Result<()> {
        let broken = |what: String| Err(Error::invariant("materials", what));
        for m in &self.materials {
            if !m.reflectance.iter().all(|r| (0.0..1.0).contains(r)) {
                return broken(format!(
                    "material {:?} has reflectance {:?}, expected 0 ≤ ρ < 1",
                    m.name, m.reflectance
                ));
            }
            if !m.emission.iter().all(|e| e.is_finite() && *e >= 0.0) {
                return broken(format!("material {:?} has emission {:?}, expected numbers ≥ 0", m.name, m.emission));
            }
            let textures = [m.reflectance_texture, m.emission_texture];
            if textures.iter().flatten().any(|&t| t as usize >= self.textures.len()) {
                return broken(format!("material {:?} names a texture that is not there", m.name));
            }
        }
        Ok(())
    }
}

/// Number of materials in a container, `None` if it has none.
pub(crate) fn count(c: &Container) -> Result<Option<usize>> {
    Ok(if c.has(META) { Some(c.meta::<Meta>(META)?.materials.len()) } else { None })
}

impl<'a> Record<'a> for Materials {
    const PREFIX: &'static str = "materials.";

    fn read(c: &'a Container) -> Result<Materials> {
        let meta: Meta = c.meta(META)?;
        let mut bytes = c.array_of::<u8>("materials.textures", &[None])?;
        let mut textures = Vec::with_capacity(meta.textures.len());
        for (name, length, wrap) in meta.textures {
            let Some((image, rest)) = usize::try_from(length).ok().and_then(|l| bytes.split_at_checked(l)) else {
                return Err(Error::invariant("materials", format!("texture {name:?} of {length} bytes is cut short")));
            };
            textures.push(Texture { name, bytes: image.to_vec(), wrap });
            bytes = rest;
        }
        if !bytes.is_empty() {
            return Err(Error::invariant("materials", format!("{} bytes of textures belong to none", bytes.len())));
        }
        let materials = Materials { materials: meta.materials, textures };
        materials.check()?;
        Ok(materials)
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        let textures = self.textures.iter().map(|t| (t.name.clone(), t.bytes.len() as u64, t.wrap)).collect();
        b.meta(META, FLAG_REQUIRED, &Meta { materials: self.materials.clone(), textures });
        let bytes: Vec<u8> = self.textures.iter().flat_map(|t| t.bytes.iter().copied()).collect();
        b.array("materials.textures", FLAG_REQUIRED, &[bytes.len()], bytes);
    }
}
