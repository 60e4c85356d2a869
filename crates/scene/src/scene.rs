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
        for (name, light) in &extras.lights {
            light.check().map_err(|what| radfile::Error::invariant(EXTRAS, format!("light {name:?}: {what}")))?;
        }
        for (name, camera) in &extras.cameras {
            camera.check().map_err(|what| radfile::Error::invariant(EXTRAS, format!("camera {name:?}: {what}")))?;
        }
        Ok(Scene { mesh, materials, extras })
    }

    /// Adds the sections of the scene to a container being built.
    pub fn write<'b>(&'b self, builder: &mut Builder<'b>) {
        self.mesh.write(builder);
        self.materials.write(builder);
        builder.meta(EXTRAS, 0, &StoredExtras::from(&self.extras));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(change: impl FnOnce(&mut Scene)) -> String {
        let mut scene = Scene::default();
        scene.mesh.positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        (scene.mesh.triangles, scene.mesh.triangle_material) = (vec![[0, 1, 2]], vec![0]);
        scene.materials.materials.push(radfile::Material {
            name: "grey".into(),
            reflectance: [0.5; 3],
            reflectance_texture: None,
            emission: [0.0; 3],
            emission_texture: None,
        });
        change(&mut scene);
        let mut builder = Builder::new();
        scene.write(&mut builder);
        Scene::read(&builder.finish().expect("sections fit")).expect_err("a broken scene").to_string()
    }

    #[test]
    fn a_triangle_of_no_material_is_refused() {
        let text = refused(|scene| scene.mesh.triangle_material[0] = 5);
        assert_eq!(text, "mesh: triangle 0 has material 5, there are 1");
    }

    #[test]
    fn lights_and_cameras_with_impossible_numbers_are_refused() {
        let text = refused(|scene| scene.extras.lights = vec![("sun".into(), Light::Sky { radiance: [-1.0; 3] })]);
        assert!(text.starts_with("scene.extras: light \"sun\": radiance is [-1.0, -1.0, -1.0], expected"), "{text}");
        let camera = Camera { origin: [0.0; 3], target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_x_deg: 39.0 };
        let text = refused(|scene| scene.extras.cameras = vec![("eye".into(), camera)]);
        assert!(text.starts_with("scene.extras: camera \"eye\": target is"), "{text}");
    }
}
