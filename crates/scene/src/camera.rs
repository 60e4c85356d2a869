//! The camera file of docs/design.md §4.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{Error, Result};

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

impl Camera {
    /// Reads a camera file.
    ///
    /// # Errors
    ///
    /// [`Error::Json`] for misspelt or missing fields, numbers that are not finite, a target at the origin,
    /// an up vector along the line of sight, a field of view outside 0 to 180 degrees.
    pub fn from_json(text: &str) -> Result<Camera> {
        let refused = |what: String| Error::Json { what: format!("camera file: {what}") };
        let camera: Camera =
            serde_json::from_str(text.trim_start_matches('\u{feff}')).map_err(|e| refused(e.to_string()))?;
        camera.check().map_err(refused)?;
        Ok(camera)
    }

    /// The first rule that the numbers break, in words.
    pub(crate) fn check(&self) -> std::result::Result<(), String> {
        for (name, v) in [("origin", self.origin), ("target", self.target), ("up", self.up)] {
            if !v.iter().all(|x| x.is_finite()) {
                return Err(format!("{name} is {v:?}, expected finite numbers"));
            }
        }
        let forward = DVec3::from(self.target) - DVec3::from(self.origin);
        let Some(forward) = forward.try_normalize() else {
            return Err(format!("target is {:?}, expected another point than origin", self.target));
        };
        match DVec3::from(self.up).try_normalize() {
            Some(up) if up.cross(forward).length() > 1e-7 => {}
            _ => {
                return Err(format!("up is {:?}, expected a vector that is not along the line of sight", self.up));
            }
        }
        match self.fov_x_deg > 0.0 && self.fov_x_deg < 180.0 {
            true => Ok(()),
            false => Err(format!("fov_x_deg is {}, expected more than 0 and less than 180", self.fov_x_deg)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"{"origin":[0,1,3.9],"target":[0,1,0],"up":[0,1,0],"fov_x_deg":39}"#;

    fn message(from: &str, to: &str) -> String {
        assert!(GOOD.contains(from));
        Camera::from_json(&GOOD.replace(from, to)).expect_err(to).to_string()
    }

    #[test]
    fn a_camera_file_is_read() {
        let camera = Camera::from_json(GOOD).unwrap();
        assert_eq!((camera.origin, camera.fov_x_deg), ([0.0, 1.0, 3.9], 39.0));
        assert_eq!(Camera::from_json(&format!("\u{feff}{GOOD}")).unwrap(), camera);
    }

    #[test]
    fn misspelt_and_missing_fields_are_refused() {
        let text = message("fov_x_deg", "fov_deg");
        assert!(text.starts_with("camera file: unknown field `fov_deg`, expected one of `origin`"), "{text}");
        assert!(message(r#","fov_x_deg":39"#, "").contains("missing field `fov_x_deg`"));
        assert!(message("[0,1,0],\"fov", "[0,1],\"fov").starts_with("camera file: invalid length 2"));
    }

    #[test]
    fn a_camera_that_looks_nowhere_is_refused() {
        assert!(message("[0,1,0],\"up", "[0,1,3.9],\"up").contains("expected another point than origin"));
        assert!(message("\"up\":[0,1,0]", "\"up\":[0,0,2]").contains("not along the line of sight"));
        assert!(message("\"up\":[0,1,0]", "\"up\":[0,0,0]").contains("up is [0.0, 0.0, 0.0]"));
        assert!(message("3.9", "1e999").contains("out of range"));
    }

    #[test]
    fn a_field_of_view_outside_its_range_is_refused() {
        for fov in ["0", "-5", "180"] {
            assert!(message("39", fov).contains(&format!("fov_x_deg is {fov}, expected more than 0")), "{fov}");
        }
    }
}
