//! Which patch each place of a picture shows.

use glam::Vec3;
use radfile::PatchLocator;
use rayon::prelude::*;
use scene::{Camera, NO_TRIANGLE, Rays, Scene, land};

use crate::view::View;

/// A patch in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenPatch {
    /// Its number.
    pub patch: u32,
    /// Cosine between its surface's normal and the way to the eye.
    pub facing: f32,
}

/// What a camera sees in the middle of each cell of a grid of `width` × `height` over its picture, rows from the top;
/// `None` where it sees no patch.
pub fn seen_patches(
    scene: &Scene,
    rays: &Rays,
    locator: &PatchLocator,
    camera: &Camera,
    [width, height]: [usize; 2],
) -> Vec<Option<SeenPatch>> {
    let view = View::new(camera, scene.mesh.origin, width, height);
    let see = |place: usize| {
        let (x, y) = ((place % width) as f64 + 0.5, (place / width) as f64 + 0.5);
        let direction = view.direction(x, y);
        let landing = land(rays, locator, view.origin, direction, NO_TRIANGLE)?;
        let [a, b, c] = scene.mesh.corners(landing.face as usize / 2).map(Vec3::from);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        landing.patch.map(|patch| SeenPatch { patch, facing: normal.dot(direction).abs() })
    };
    (0..width * height).into_par_iter().map(see).collect()
}
