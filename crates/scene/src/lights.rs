//! The lights file of DESIGN §4: radiometric SI, linear RGB, the scene file's axes.

use serde::{Deserialize, Serialize};

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
