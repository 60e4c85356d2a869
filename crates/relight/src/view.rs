//! Primary rays of a pinhole camera.

use glam::{DVec3, Vec3};
use scene::Camera;

/// A camera over a picture of known size, in local axes.
pub struct View {
    /// The eye.
    pub origin: Vec3,
    forward: DVec3,
    /// From the middle to the right and to the upper border, at distance 1.
    right: DVec3,
    up: DVec3,
    size: [f64; 2],
}

impl View {
    /// Pixels are square; the field of view is that of the width. `mesh_origin` is the local origin.
    pub fn new(camera: &Camera, mesh_origin: [f64; 3], width: usize, height: usize) -> View {
        let (origin, target) = (DVec3::from(camera.origin), DVec3::from(camera.target));
        let forward = (target - origin).normalize_or_zero();
        let right = forward.cross(DVec3::from(camera.up)).normalize_or_zero();
        let size = [width as f64, height as f64];
        let half = (0.5 * camera.fov_x_deg.to_radians()).tan();
        View {
            origin: (origin - DVec3::from(mesh_origin)).as_vec3(),
            forward,
            up: half * size[1] / size[0] * right.cross(forward),
            right: half * right,
            size,
        }
    }

    /// Unit direction through a place of the picture, in pixels from the upper left.
    pub fn direction(&self, x: f64, y: f64) -> Vec3 {
        let (right, up) = (2.0 * x / self.size[0] - 1.0, 1.0 - 2.0 * y / self.size[1]);
        (self.forward + right * self.right + up * self.up).normalize().as_vec3()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_borders_of_the_picture_are_at_half_the_field_of_view() {
        let camera = Camera { origin: [1e6, 2.0, 3.0], target: [1e6, 2.0, -1.0], up: [0.0, 1.0, 0.0], fov_x_deg: 60.0 };
        let view = View::new(&camera, [1e6, 0.0, 0.0], 400, 200);
        assert_eq!(view.origin, Vec3::new(0.0, 2.0, 3.0));
        let angle = |x, y| f64::from(view.direction(x, y).angle_between(Vec3::NEG_Z)).to_degrees();
        assert!(angle(200.0, 100.0) < 1e-3);
        assert!((angle(0.0, 100.0) - 30.0).abs() < 1e-3 && (angle(400.0, 100.0) - 30.0).abs() < 1e-3);
        let half_height = (0.5 * 30f64.to_radians().tan()).atan().to_degrees();
        assert!((angle(200.0, 0.0) - half_height).abs() < 1e-3);
        assert!(view.direction(400.0, 100.0).x > 0.0 && view.direction(200.0, 0.0).y > 0.0, "right is right, up is up");
    }
}
