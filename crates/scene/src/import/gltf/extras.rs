//! Lights and cameras of nodes, in the scene file's axes and radiometric units.
//!
//! `KHR_lights_punctual` is photometric: candela for point and spot lights, lux for directional ones. They are
//! divided by 683 lm/W, the luminous efficacy that defines the candela, as glTF exporters multiply by it.

use glam::DVec3;

use super::{
    document::Document,
    nodes::Placed,
    schema::{self, Perspective},
};
use crate::{Camera, Extras, Light, Result, import::notes::Notes};

/// Lumens per watt.
const EFFICACY: f64 = 683.0;

/// Adds the light and the camera of a node, if it has them.
pub fn add(document: &Document, placed: &Placed, extras: &mut Extras, notes: &mut Notes) -> Result<()> {
    let first_of = |names: [&str; 2], kind: &str, index: usize| {
        let given = names.into_iter().find(|n| !n.is_empty());
        given.map_or_else(|| format!("{kind} {index}"), str::to_owned)
    };
    if let Some(reference) = &placed.node.extensions.light {
        let index = reference.light;
        let source = document.get(&document.root.extensions.lights.lights, index, "light")?;
        let name = first_of([&source.name, &placed.node.name], "light", index);
        if source.range.is_some() {
            notes.count("the range of lights is ignored, light falls with the square of the distance; lights", 1);
        }
        match light(source, placed) {
            Some(light) if light.check().is_ok() => extras.lights.push((name, light)),
            _ => notes.name("lights of an unknown type or with impossible numbers are ignored", &name),
        }
    }
    if let Some(index) = placed.node.camera {
        let source = document.get(&document.root.cameras, index, "camera")?;
        let name = first_of([&source.name, &placed.node.name], "camera", index);
        match source.perspective.as_ref().map(|p| camera(p, placed)) {
            Some(camera) if camera.check().is_ok() => extras.cameras.push((name, camera)),
            _ => notes.name("cameras without perspective or with impossible numbers are ignored", &name),
        }
    }
    Ok(())
}

fn light(source: &schema::Light, placed: &Placed) -> Option<Light> {
    let strength = source.intensity.unwrap_or(1.0) / EFFICACY;
    let colour = source.color.unwrap_or([1.0; 3]).map(|c| (c * strength) as f32);
    let position = placed.transform.transform_point3(DVec3::ZERO).to_array();
    let direction = placed.transform.transform_vector3(DVec3::NEG_Z).normalize_or_zero().as_vec3().to_array();
    match source.kind.as_str() {
        "point" => Some(Light::Point { position, intensity: colour }),
        "directional" => Some(Light::Directional { direction, irradiance: colour }),
        "spot" => {
            let outer = source.spot.outer_cone_angle.unwrap_or(std::f64::consts::FRAC_PI_4);
            let (half, soft) = (outer.to_degrees(), (outer - source.spot.inner_cone_angle).to_degrees());
            let (half_angle_deg, penumbra_deg) = (half as f32, soft as f32);
            Some(Light::Spot { position, direction, intensity: colour, half_angle_deg, penumbra_deg })
        }
        _ => None,
    }
}

/// A camera looks along -Z with Y up. Where the file leaves the picture's shape open, it is square.
fn camera(perspective: &Perspective, placed: &Placed) -> Camera {
    let origin = placed.transform.transform_point3(DVec3::ZERO);
    let forward = placed.transform.transform_vector3(DVec3::NEG_Z).normalize_or_zero();
    let half_width = (0.5 * perspective.yfov).tan() * perspective.aspect_ratio.unwrap_or(1.0);
    Camera {
        origin: origin.to_array(),
        target: (origin + forward).to_array(),
        up: placed.transform.transform_vector3(DVec3::Y).normalize_or_zero().to_array(),
        fov_x_deg: 2.0 * half_width.atan().to_degrees(),
    }
}
