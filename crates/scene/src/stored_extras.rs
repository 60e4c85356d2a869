//! Lights and cameras as a container keeps them, section `scene.extras` (`formats/rad.md` §5).
//!
//! A lights file names the kind of each light; metadata numbers it, because its encoding describes
//! nothing and cannot be searched for a name. The order of the kinds is part of the file format.

use serde::{Deserialize, Serialize};

use crate::{Camera, Extras, Light};

#[derive(Serialize, Deserialize)]
pub struct StoredExtras {
    lights: Vec<(String, Stored)>,
    cameras: Vec<(String, Camera)>,
}

#[derive(Serialize, Deserialize)]
struct Stored(#[serde(with = "StoredLight")] Light);

/// [`Light`] without its tag.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Light")]
enum StoredLight {
    Point { position: [f64; 3], intensity: [f32; 3] },
    Spot { position: [f64; 3], direction: [f32; 3], intensity: [f32; 3], half_angle_deg: f32, penumbra_deg: f32 },
    Directional { direction: [f32; 3], irradiance: [f32; 3] },
    Quad { corner: [f64; 3], edge_u: [f32; 3], edge_v: [f32; 3], radiance: [f32; 3] },
    Sky { radiance: [f32; 3] },
}

impl From<&Extras> for StoredExtras {
    fn from(extras: &Extras) -> StoredExtras {
        let lights = extras.lights.iter().map(|(name, light)| (name.clone(), Stored(*light))).collect();
        StoredExtras { lights, cameras: extras.cameras.clone() }
    }
}

impl From<StoredExtras> for Extras {
    fn from(stored: StoredExtras) -> Extras {
        let lights = stored.lights.into_iter().map(|(name, Stored(light))| (name, light)).collect();
        Extras { lights, cameras: stored.cameras }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    /// Every kind of light and a camera come out of a container as they went in.
    #[test]
    fn a_container_gives_back_the_lights_that_it_was_given() {
        let lights = vec![
            Light::Point { position: [1.0, 2.0, 3.0], intensity: [4.0; 3] },
            Light::Spot {
                position: [0.1, 0.2, 0.3],
                direction: [0.0, -1.0, 0.0],
                intensity: [5.0; 3],
                half_angle_deg: 30.0,
                penumbra_deg: 2.0,
            },
            Light::Directional { direction: [0.0, 0.0, -1.0], irradiance: [6.0; 3] },
            Light::Quad { corner: [0.0; 3], edge_u: [1.0, 0.0, 0.0], edge_v: [0.0, 1.0, 0.0], radiance: [7.0; 3] },
            Light::Sky { radiance: [8.0; 3] },
        ];
        let camera = Camera { origin: [0.0; 3], target: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0], fov_x_deg: 39.0 };
        let extras = Extras {
            lights: lights.into_iter().enumerate().map(|(i, light)| (format!("light {i}"), light)).collect(),
            cameras: vec![("eye".into(), camera)],
        };
        let mut scene = Scene { extras: extras.clone(), ..Scene::default() };
        scene.mesh.positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        scene.mesh.triangles = vec![[0, 1, 2]];
        scene.mesh.triangle_material = vec![0];
        scene.materials.materials.push(radfile::Material {
            name: "grey".into(),
            reflectance: [0.5; 3],
            reflectance_texture: None,
            emission: [0.0; 3],
            emission_texture: None,
        });
        let mut builder = radfile::Builder::new();
        scene.write(&mut builder);
        let read = Scene::read(&builder.finish().expect("sections fit")).expect("it was just written");
        assert_eq!(read.extras, extras);
    }
}
