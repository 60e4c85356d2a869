//! Reflectance and emission at points of triangles.

use glam::Vec3;
use radfile::{Materials, Mesh};
use rayon::prelude::*;

use crate::{Error, Result, texture::Image};

/// The largest reflectance that a surface may have; brighter materials and texels are clamped to it.
/// At 0.99 light in a closed room still needs 688 bounces to fall to a thousandth; at 1 it never does.
pub const MAX_REFLECTANCE: f32 = 0.99;

/// Materials with decoded textures.
pub struct Surfaces<'a> {
    mesh: &'a Mesh,
    materials: &'a Materials,
    images: Vec<Image>,
}

impl<'a> Surfaces<'a> {
    /// Decodes the textures.
    ///
    /// # Errors
    ///
    /// [`Error::Malformed`] for a texture that cannot be decoded or is too large.
    pub fn new(mesh: &'a Mesh, materials: &'a Materials) -> Result<Surfaces<'a>> {
        let decode = |texture: &radfile::Texture| {
            Image::decode(&texture.bytes).map_err(|what| Error::Malformed {
                name: texture.name.clone(),
                what: format!("the texture cannot be decoded, expected PNG or JPEG: {what}"),
            })
        };
        let images = materials.textures.par_iter().map(decode).collect::<Result<_>>()?;
        Ok(Surfaces { mesh, materials, images })
    }

    /// Linear reflectance, 0 ≤ ρ ≤ [`MAX_REFLECTANCE`], at barycentric weights `(u, v)` of the second and
    /// third corner.
    pub fn reflectance(&self, triangle: u32, u: f32, v: f32) -> [f32; 3] {
        let material = self.material(triangle);
        let texel = self.texel(material.reflectance_texture, &self.mesh.uv, triangle, u, v);
        std::array::from_fn(|c| (material.reflectance[c] * texel[c]).min(MAX_REFLECTANCE))
    }

    /// Emitted radiance of the front side, W/(m² sr), at barycentric weights `(u, v)`.
    pub fn emission(&self, triangle: u32, u: f32, v: f32) -> [f32; 3] {
        let material = self.material(triangle);
        let own = &self.mesh.emission_uv;
        let coordinates = if own.is_empty() { &self.mesh.uv } else { own };
        let texel = self.texel(material.emission_texture, coordinates, triangle, u, v);
        std::array::from_fn(|c| material.emission[c] * texel[c])
    }

    /// Barycentric weights of the second and third corner of a triangle at the point of it that is nearest to `point`, or
    /// near that: what rounding put outside is moved back.
    pub fn weights_at(&self, triangle: u32, point: Vec3) -> (f32, f32) {
        let [a, b, c] = self.mesh.corners(triangle as usize).map(|p| Vec3::from(p).as_dvec3());
        let (normal, point) = ((b - a).cross(c - a), point.as_dvec3());
        let square = normal.length_squared();
        if square == 0.0 {
            return (0.0, 0.0);
        }
        let u = ((point - a).cross(c - a).dot(normal) / square).clamp(0.0, 1.0);
        let v = ((b - a).cross(point - a).dot(normal) / square).clamp(0.0, 1.0);
        let excess = (u + v).max(1.0);
        ((u / excess) as f32, (v / excess) as f32)
    }

    /// Triangles whose material emits.
    pub fn emitters(&self) -> Vec<u32> {
        let emits = |&t: &u32| self.material(t).emission.iter().any(|&e| e > 0.0);
        (0..self.mesh.triangles.len() as u32).filter(emits).collect()
    }

    fn material(&self, triangle: u32) -> &radfile::Material {
        &self.materials.materials[self.mesh.triangle_material[triangle as usize] as usize]
    }

    /// What the factor is multiplied by: 1 without a texture.
    fn texel(&self, texture: Option<u32>, coordinates: &[[f32; 2]], triangle: u32, u: f32, v: f32) -> [f32; 3] {
        let Some(texture) = texture else { return [1.0; 3] };
        let at = match coordinates.is_empty() {
            true => [0.0; 2],
            false => {
                let [a, b, c] = self.mesh.triangles[triangle as usize].map(|i| coordinates[i as usize]);
                std::array::from_fn(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]))
            }
        };
        self.images[texture as usize].sample(at, self.materials.textures[texture as usize].wrap)
    }
}

#[cfg(test)]
mod tests {
    use radfile::{Material, Texture, Wrap};

    use super::*;

    fn material(reflectance: f32, emission: f32, texture: Option<u32>) -> Material {
        Material {
            name: "m".into(),
            reflectance: [reflectance; 3],
            reflectance_texture: texture,
            emission: [emission; 3],
            emission_texture: texture,
        }
    }

    /// Two triangles; the first has a texture that is black on the left and white on the right.
    fn scene() -> (Mesh, Materials) {
        let mut bytes = Vec::new();
        let image = image::GrayImage::from_raw(2, 1, vec![0, 255]).unwrap();
        image.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).unwrap();
        let mesh = Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]; 2],
            triangle_material: vec![0, 1],
            uv: vec![[0.25, 0.5], [0.75, 0.5], [0.25, 0.5]],
            ..Mesh::default()
        };
        let materials = Materials {
            materials: vec![material(0.5, 3.0, Some(0)), material(0.5, 0.0, None)],
            textures: vec![Texture { name: "t.png".into(), bytes, wrap: [Wrap::Clamp; 2] }],
        };
        (mesh, materials)
    }

    #[test]
    fn texels_are_multiplied_by_the_factor_where_the_point_is() {
        let (mesh, materials) = scene();
        let surfaces = Surfaces::new(&mesh, &materials).unwrap();
        assert_eq!(surfaces.reflectance(0, 0.0, 0.0), [0.0; 3]);
        assert_eq!(surfaces.reflectance(0, 1.0, 0.0), [0.5; 3]);
        assert_eq!(surfaces.reflectance(0, 0.5, 0.5), [0.25; 3]);
        assert_eq!(surfaces.emission(0, 1.0, 0.0), [3.0; 3]);
        assert_eq!(surfaces.reflectance(1, 0.3, 0.3), [0.5; 3], "a plain material is its factor");
    }

    #[test]
    fn the_emission_texture_has_coordinates_of_its_own() {
        let (mut mesh, materials) = scene();
        mesh.emission_uv = vec![[0.75, 0.5]; 3];
        let surfaces = Surfaces::new(&mesh, &materials).unwrap();
        assert_eq!((surfaces.reflectance(0, 0.0, 0.0), surfaces.emission(0, 0.0, 0.0)), ([0.0; 3], [3.0; 3]));
    }

    #[test]
    fn no_texel_reflects_all_light() {
        let (mesh, mut materials) = scene();
        materials.materials[0].reflectance = [0.999_999_9; 3];
        let surfaces = Surfaces::new(&mesh, &materials).unwrap();
        assert_eq!(surfaces.reflectance(0, 1.0, 0.0), [MAX_REFLECTANCE; 3]);
    }

    #[test]
    fn triangles_of_emitting_materials_are_the_emitters() {
        let (mesh, materials) = scene();
        assert_eq!(Surfaces::new(&mesh, &materials).unwrap().emitters(), [0]);
    }

    #[test]
    fn a_texture_that_cannot_be_decoded_is_named() {
        let (mesh, mut materials) = scene();
        materials.textures[0].bytes.truncate(20);
        let text = Surfaces::new(&mesh, &materials).err().expect("a cut texture").to_string();
        assert!(text.starts_with("t.png: the texture cannot be decoded, expected PNG or JPEG: "), "{text}");
    }
}
