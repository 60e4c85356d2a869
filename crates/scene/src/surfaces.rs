//! Reflectance and emission at points of triangles.

use radfile::{Materials, Mesh};

use crate::Result;

/// Materials with decoded textures.
pub struct Surfaces<'a> {
    mesh: &'a Mesh,
    materials: &'a Materials,
}

impl<'a> Surfaces<'a> {
    /// Decodes the textures.
    ///
    /// # Errors
    ///
    /// A texture that cannot be decoded or is too large.
    pub fn new(mesh: &'a Mesh, materials: &'a Materials) -> Result<Surfaces<'a>> {
        Ok(Surfaces { mesh, materials })
    }

    /// Linear reflectance, 0 ≤ ρ < 1, at barycentric weights `(u, v)` of the second and third corner.
    pub fn reflectance(&self, triangle: u32, _u: f32, _v: f32) -> [f32; 3] {
        self.materials.materials[self.mesh.triangle_material[triangle as usize] as usize].reflectance
    }

    /// Emitted radiance of the front side, W/(m² sr), at barycentric weights `(u, v)`.
    pub fn emission(&self, triangle: u32, _u: f32, _v: f32) -> [f32; 3] {
        self.materials.materials[self.mesh.triangle_material[triangle as usize] as usize].emission
    }

    /// Triangles whose material emits.
    pub fn emitters(&self) -> Vec<u32> {
        let emits = |&t: &u32| {
            let material = self.mesh.triangle_material[t as usize];
            self.materials.materials[material as usize].emission.iter().any(|&e| e > 0.0)
        };
        (0..self.mesh.triangles.len() as u32).filter(emits).collect()
    }
}
