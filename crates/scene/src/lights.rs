//! The lights file of docs/design.md §4: radiometric SI, linear RGB, the scene file's axes.

use serde::{Deserialize, Serialize};

use crate::{Error, Result};

/// A lights file: what shines this frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightRig {
    /// Free text.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub units: String,
    /// Free text.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
    /// Whether emissive materials shine; their first arrival counts as direct light.
    #[serde(default)]
    pub use_scene_emission: bool,
    /// The lights.
    pub lights: Vec<Light>,
}

/// One light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
pub enum Light {
    /// Shines equally in all directions.
    Point {
        /// Position, metres.
        position: [f64; 3],
        /// Radiant intensity, W/sr.
        intensity: [f32; 3],
    },
    /// A cone of light.
    Spot {
        /// Apex, metres.
        position: [f64; 3],
        /// Axis, any length.
        direction: [f32; 3],
        /// Radiant intensity inside the cone, W/sr.
        intensity: [f32; 3],
        /// Half of the opening angle, degrees.
        half_angle_deg: f32,
        /// The last degrees inside the cone over which the light fades out.
        #[serde(default)]
        penumbra_deg: f32,
    },
    /// Parallel light.
    Directional {
        /// The way the light travels, any length.
        direction: [f32; 3],
        /// Irradiance of a surface that faces the light, W/m².
        irradiance: [f32; 3],
    },
    /// A parallelogram that emits along edge_u × edge_v and does not occlude.
    Quad {
        /// One corner, metres.
        corner: [f64; 3],
        /// From the corner to the next.
        edge_u: [f32; 3],
        /// From the corner to the one before.
        edge_v: [f32; 3],
        /// Radiance, W/(m² sr).
        radiance: [f32; 3],
    },
    /// Radiance from every direction that leaves the scene.
    Sky {
        /// Radiance, W/(m² sr).
        radiance: [f32; 3],
    },
}

impl LightRig {
    /// Reads a lights file.
    ///
    /// # Errors
    ///
    /// [`Error::Json`] for anything that is not exactly the contract: unknown types, misspelt or missing
    /// fields, numbers that are not finite, negative intensities, directions without length, angles out of range.
    ///
    /// # Example
    ///
    /// ```
    /// let rig = scene::LightRig::from_json(r#"{"lights": [{"type": "sky", "radiance": [1, 1, 2]}]}"#)?;
    /// assert_eq!(rig.lights, [scene::Light::Sky { radiance: [1.0, 1.0, 2.0] }]);
    /// # Ok::<(), scene::Error>(())
    /// ```
    pub fn from_json(text: &str) -> Result<LightRig> {
        let text = text.trim_start_matches('\u{feff}');
        let rig: LightRig = serde_json::from_str(text)
            .map_err(|error| refused(misread_light(text).unwrap_or_else(|| format!("lights file: {error}"))))?;
        for (i, light) in rig.lights.iter().enumerate() {
            light.check().map_err(|what| refused(format!("lights file: light {i} ({}): {what}", light.kind())))?;
        }
        Ok(rig)
    }
}

fn refused(what: String) -> Error {
    Error::Json { what }
}

/// Says which light of a file that cannot be read is the first wrong one; `None` if it is none of them.
fn misread_light(text: &str) -> Option<String> {
    let file: serde_json::Value = serde_json::from_str(text).ok()?;
    file.get("lights")?.as_array()?.iter().enumerate().find_map(|(i, light)| {
        let error = Light::deserialize(light).err()?;
        let kind = light.get("type").and_then(|t| t.as_str()).map(|t| format!(" ({t})")).unwrap_or_default();
        Some(format!("lights file: light {i}{kind}: {error}"))
    })
}

impl Light {
    /// Name of the type in a lights file.
    pub fn kind(&self) -> &'static str {
        match self {
            Light::Point { .. } => "point",
            Light::Spot { .. } => "spot",
            Light::Directional { .. } => "directional",
            Light::Quad { .. } => "quad",
            Light::Sky { .. } => "sky",
        }
    }

    /// The first rule that the numbers break, in words.
    pub(crate) fn check(&self) -> std::result::Result<(), String> {
        match self {
            Light::Point { position, intensity } => {
                finite("position", position)?;
                bright("intensity", intensity)
            }
            Light::Spot { position, direction, intensity, half_angle_deg, penumbra_deg } => {
                finite("position", position)?;
                long("direction", direction)?;
                bright("intensity", intensity)?;
                if !(*half_angle_deg > 0.0 && *half_angle_deg <= 180.0) {
                    return Err(format!("half_angle_deg is {half_angle_deg}, expected more than 0 and at most 180"));
                }
                if !(0.0..=*half_angle_deg).contains(penumbra_deg) {
                    return Err(format!(
                        "penumbra_deg is {penumbra_deg}, expected 0 to half_angle_deg, which is {half_angle_deg}"
                    ));
                }
                Ok(())
            }
            Light::Directional { direction, irradiance } => {
                long("direction", direction)?;
                bright("irradiance", irradiance)
            }
            Light::Quad { corner, edge_u, edge_v, radiance } => {
                finite("corner", corner)?;
                long("edge_u", edge_u)?;
                long("edge_v", edge_v)?;
                if parallel(edge_u, edge_v) {
                    return Err(format!("edge_u {edge_u:?} and edge_v {edge_v:?} are parallel, the quad has no area"));
                }
                bright("radiance", radiance)
            }
            Light::Sky { radiance } => bright("radiance", radiance),
        }
    }
}

fn finite(name: &str, v: &[f64; 3]) -> std::result::Result<(), String> {
    match v.iter().all(|x| x.is_finite()) {
        true => Ok(()),
        false => Err(format!("{name} is {v:?}, expected finite numbers")),
    }
}

fn bright(name: &str, rgb: &[f32; 3]) -> std::result::Result<(), String> {
    match rgb.iter().all(|x| x.is_finite() && *x >= 0.0) {
        true => Ok(()),
        false => Err(format!("{name} is {rgb:?}, expected finite numbers that are not negative")),
    }
}

fn long(name: &str, v: &[f32; 3]) -> std::result::Result<(), String> {
    // The square must neither vanish nor overflow in single precision, in which lights are evaluated.
    let square: f32 = v.iter().map(|x| x * x).sum();
    match square.is_normal() {
        true => Ok(()),
        false => Err(format!("{name} is {v:?}, expected finite numbers and a length above 0")),
    }
}

fn parallel(a: &[f32; 3], b: &[f32; 3]) -> bool {
    let (a, b) = (glam::Vec3::from(*a).as_dvec3(), glam::Vec3::from(*b).as_dvec3());
    a.cross(b).length() <= 1e-7 * a.length() * b.length()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(light: &str) -> String {
        LightRig::from_json(&format!(r#"{{"lights":[{{"type":"sky","radiance":[0,0,0]}},{light}]}}"#))
            .expect_err(light)
            .to_string()
    }

    #[test]
    fn every_type_of_light_is_read_and_written_back() {
        let text = r#"{ "units": "SI", "note": "n", "use_scene_emission": true, "lights": [
            {"type":"point","position":[1,2,3],"intensity":[1,2,3]},
            {"type":"spot","position":[1,2,3],"direction":[0,0,-2],"intensity":[1,2,3],"half_angle_deg":30},
            {"type":"spot","position":[1,2,3],"direction":[0,0,-2],"intensity":[1,2,3],"half_angle_deg":180,"penumbra_deg":180},
            {"type":"directional","direction":[0,-1,0],"irradiance":[1,2,3]},
            {"type":"quad","corner":[0,0,0],"edge_u":[1,0,0],"edge_v":[0,1,0],"radiance":[1,2,3]},
            {"type":"sky","radiance":[1,2,3]}]}"#;
        let rig = LightRig::from_json(text).unwrap();
        assert_eq!(rig.lights.len(), 6);
        assert!(matches!(rig.lights[1], Light::Spot { penumbra_deg: 0.0, half_angle_deg: 30.0, .. }));
        assert_eq!(LightRig::from_json(&serde_json::to_string(&rig).unwrap()).unwrap(), rig);
    }

    #[test]
    fn a_misspelt_field_inside_a_light_is_refused_and_the_light_is_named() {
        let text = message(r#"{"type":"point","position":[1,2,3],"intensity":[1,1,1],"intensty":[1,2,3]}"#);
        assert!(
            text.starts_with("lights file: light 1 (point): unknown field `intensty`, expected `position` or"),
            "{text}"
        );
        let text = message(r#"{"type":"sky","radiance":[1,1,1],"penumbra_deg":3}"#);
        assert!(text.contains("light 1 (sky): unknown field `penumbra_deg`"), "{text}");
    }

    #[test]
    fn a_missing_field_or_type_is_refused() {
        let text = message(r#"{"type":"spot","position":[1,2,3],"direction":[0,0,1],"intensity":[1,2,3]}"#);
        assert_eq!(text, "lights file: light 1 (spot): missing field `half_angle_deg`");
        assert_eq!(message(r#"{"position":[1,2,3]}"#), "lights file: light 1: missing field `type`");
    }

    #[test]
    fn an_unknown_type_is_refused_with_the_known_ones() {
        let text = message(r#"{"type":"laser","position":[1,2,3]}"#);
        assert!(text.contains("light 1 (laser): unknown variant `laser`, expected one of `point`, `spot`"), "{text}");
    }

    #[test]
    fn vectors_of_the_wrong_length_are_refused() {
        for radiance in ["[1,2]", "[1,2,3,4]", "1", "[1,2,null]", "[1,2,\"3\"]"] {
            let text = message(&format!(r#"{{"type":"sky","radiance":{radiance}}}"#));
            assert!(text.starts_with("lights file: light 1 (sky): "), "{radiance}: {text}");
        }
    }

    #[test]
    fn a_field_given_twice_is_refused() {
        let text = message(r#"{"type":"sky","radiance":[1,2,3],"radiance":[1,2,3]}"#);
        assert!(text.contains("duplicate field"), "{text}");
    }

    #[test]
    fn misspelt_or_missing_fields_of_the_file_itself_are_refused() {
        let text = LightRig::from_json(r#"{"lights":[],"use_scene_emision":true}"#).unwrap_err().to_string();
        assert!(text.starts_with("lights file: unknown field `use_scene_emision`, expected one of"), "{text}");
        let text = LightRig::from_json(r#"{"note":"no lights"}"#).unwrap_err().to_string();
        assert!(text.contains("missing field `lights`"), "{text}");
        for broken in ["", "[]", "{", "nonsense", "{\"lights\":[]}x"] {
            assert!(LightRig::from_json(broken).is_err(), "{broken:?}");
        }
    }

    #[test]
    fn numbers_that_are_not_finite_are_refused() {
        let text = message(r#"{"type":"sky","radiance":[1,1,1e39]}"#);
        assert!(text.contains("light 1 (sky): radiance is [1.0, 1.0, inf], expected finite"), "{text}");
        assert!(message(r#"{"type":"point","position":[1e999,0,0],"intensity":[1,1,1]}"#).contains("out of range"));
    }

    #[test]
    fn negative_light_is_refused_for_every_type() {
        for light in [
            r#"{"type":"point","position":[0,0,0],"intensity":[0,-1,0]}"#,
            r#"{"type":"spot","position":[0,0,0],"direction":[0,0,1],"intensity":[0,-1,0],"half_angle_deg":9}"#,
            r#"{"type":"directional","direction":[0,0,1],"irradiance":[0,-1,0]}"#,
            r#"{"type":"quad","corner":[0,0,0],"edge_u":[1,0,0],"edge_v":[0,1,0],"radiance":[0,-1,0]}"#,
            r#"{"type":"sky","radiance":[0,-1,0]}"#,
        ] {
            assert!(message(light).contains("[0.0, -1.0, 0.0], expected finite numbers that are not negative"));
        }
    }

    #[test]
    fn directions_and_edges_without_length_are_refused() {
        let text = message(r#"{"type":"directional","direction":[0,0,0],"irradiance":[1,1,1]}"#);
        assert!(text.contains("direction is [0.0, 0.0, 0.0], expected finite numbers and a length above 0"), "{text}");
        let quad = r#"{"type":"quad","corner":[0,0,0],"edge_u":[1,0,0],"edge_v":[-2,0,0],"radiance":[1,1,1]}"#;
        assert!(message(quad).contains("are parallel, the quad has no area"));
        assert!(message(&quad.replace("[-2,0,0]", "[0,0,0]")).contains("edge_v is [0.0, 0.0, 0.0]"));
        assert!(message(&quad.replace("[1,0,0]", "[1e30,0,0]")).contains("edge_u is"));
    }

    #[test]
    fn angles_out_of_range_are_refused() {
        let spot = |half: f32, penumbra: f32| {
            message(&format!(
                r#"{{"type":"spot","position":[0,0,0],"direction":[0,0,1],"intensity":[1,1,1],
                    "half_angle_deg":{half},"penumbra_deg":{penumbra}}}"#
            ))
        };
        assert!(spot(0.0, 0.0).contains("half_angle_deg is 0, expected more than 0 and at most 180"));
        assert!(spot(180.5, 0.0).contains("half_angle_deg is 180.5"));
        assert!(spot(30.0, 30.5).contains("penumbra_deg is 30.5, expected 0 to half_angle_deg, which is 30"));
        assert!(spot(30.0, -1.0).contains("penumbra_deg is -1"));
    }
}
