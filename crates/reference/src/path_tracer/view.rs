//! Rays of a pinhole camera.

use glam::{DVec3, Vec3};
use scene::Camera;

/// A camera over a picture of known size.
pub struct View {
    forward: DVec3,
    /// From one pixel to the next in a row, and from a row to the next, at distance 1.
    across: DVec3,
    down: DVec3,
    size: [f64; 2],
}

impl View {
    /// Pixels are square; the field of view is that of the width.
    pub fn new(camera: &Camera, width: usize, height: usize) -> View {
        let forward = (DVec3::from(camera.target) - DVec3::from(camera.origin)).normalize_or_zero();
        let across = forward.cross(DVec3::from(camera.up)).normalize_or_zero();
        let pixel = 2.0 * (0.5 * camera.fov_x_deg.to_radians()).tan() / width as f64;
        let down = pixel * forward.cross(across);
        View { forward, across: pixel * across, down, size: [width as f64, height as f64] }
    }

    /// Unit direction through a place of the picture, in pixels from the upper left.
    pub fn direction(&self, x: f64, y: f64) -> Vec3 {
        let [width, height] = self.size;
        let through = self.forward + (x - 0.5 * width) * self.across + (y - 0.5 * height) * self.down;
        through.normalize().as_vec3()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_field_of_view_is_that_of_the_width_and_up_is_up() {
        let camera = Camera { origin: [0.0; 3], target: [0.0, 0.0, -5.0], up: [0.0, 1.0, 0.0], fov_x_deg: 90.0 };
        let view = View::new(&camera, 200, 100);
        let close = |d: Vec3, x: f32, y: f32| (d - Vec3::new(x, y, -1.0).normalize()).length() < 1e-6;
        assert!(close(view.direction(100.0, 50.0), 0.0, 0.0));
        assert!(close(view.direction(200.0, 50.0), 1.0, 0.0), "right is right");
        assert!(close(view.direction(0.0, 0.0), -1.0, 0.5), "the first row is above");
    }
}
