//! A loaded scene, and the part of it that a container keeps.

use radfile::{Builder, Container, Materials, Mesh, Record};
use serde::{Deserialize, Serialize};

use crate::{Camera, Light, Result, stored_extras::StoredExtras};

/// What a scene file holds, in metres about the mesh's local origin.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Triangles.
    pub mesh: Mesh,
    /// Materials and encoded textures.
    pub materials: Materials,
    /// Lights and cameras.
    pub extras: Extras,
}

/// Lights and cameras that the scene file defines, in the scene file's axes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extras {
    /// Named lights (`KHR_lights_punctual`), radiometric.
    pub lights: Vec<(String, Light)>,
    /// Named cameras.
    pub cameras: Vec<(String, Camera)>,
}

const EXTRAS: &str = "scene.extras";

impl Scene {
    /// Reads mesh, materials and extras of a container.
    ///
    /// # Errors
    ///
    /// The first broken rule, for instance a triangle whose material is not there.
    pub fn read(container: &Container) -> Result<Scene> {
        let (mesh, materials) = (Mesh::read(container)?, Materials::read(container)?);
        let count = materials.materials.len();
        if let Some(t) = mesh.triangle_material.iter().position(|&m| m as usize >= count) {
            let what = format!("triangle {t} has material {}, there are {count}", mesh.triangle_material[t]);
            return Err(radfile::Error::invariant("mesh", what).into());
        }
        let extras =
            if container.has(EXTRAS) { container.meta::<StoredExtras>(EXTRAS)?.into() } else { Extras::default() };
        Ok(Scene { mesh, materials, extras })
    }

    /// Adds the sections of the scene to a container being built.
    pub fn write<'b>(&'b self, builder: &mut Builder<'b>) {
        self.mesh.write(builder);
        self.materials.write(builder);
        builder.meta(EXTRAS, 0, &StoredExtras::from(&self.extras));
    }
}
