//! The camera file of DESIGN §4.

use serde::{Deserialize, Serialize};

/// A pinhole camera, in the scene file's axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Eye, metres.
    pub origin: [f64; 3],
    /// A point in the middle of the picture, metres.
    pub target: [f64; 3],
    /// The direction that is up in the picture.
    pub up: [f64; 3],
    /// Horizontal field of view, degrees.
    pub fov_x_deg: f64,
}
