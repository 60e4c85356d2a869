//! Which patch a ray lands on, where rounding alone cannot tell.
//!
//! A wall may stand on a face whose patches lie on both sides of it. Where a ray lands near the wall's foot, its
//! place is known only to rounding, and may be looked up on the side that the ray could not reach: light would pass below
//! the wall. So a place within rounding of another patch is not trusted. Rays from the same origin that land next to
//! it, far enough from the border, tell which of the patches the origin sees: they meet the wall as any ray does,
//! whatever it looks like. It takes them for about one ray in a thousand.

use glam::Vec3;
use radfile::{PatchLocator, face_id};

use crate::{Hit, NO_TRIANGLE, Rays, basis};

/// The error of a landing, in gaps of [`Rays::off_surface`]. The triangle test moves corners by up to 6 epsilon of the largest
/// coordinate and `origin + t * direction` adds 3; along a surface that is eight times as much at a cosine of 1/8.
/// A gap is 16 epsilon.
const ERROR: f32 = 4.0;
/// How far off neighbours are aimed, in errors.
const ASIDE: f32 = 4.0;

/// Where a ray landed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Position, local axes, metres.
    pub position: Vec3,
    /// The face of the mesh.
    pub face: u32,
    /// The patch of the face, if it has any.
    pub patch: Option<u32>,
}

/// The first face along a ray, as [`Rays::closest`] finds it, and the patch there; `None` if the ray leaves the scene.
///
/// Where patches border on each other, it is one that is seen from `origin`.
pub fn land(rays: &Rays, locator: &PatchLocator, origin: Vec3, direction: Vec3, ignore: u32) -> Option<Landing> {
    let hit = rays.closest(origin, direction, f32::INFINITY, ignore)?;
    let (position, face) = place(&hit, origin, direction);
    let found = locator.find(face, position.to_array(), ERROR * rays.gap());
    let patch = found.map(|found| match found.at_border {
        true => seen(rays, locator, [origin, position], face, found.patch),
        false => found.patch,
    });
    Some(Landing { position, face, patch })
}

fn place(hit: &Hit, origin: Vec3, direction: Vec3) -> (Vec3, u32) {
    (origin + hit.t * direction, face_id(hit.triangle, hit.side))
}

/// Of the patches that border on each other at a place of a face the one that rays next to it meet; the one that is
/// `expected` if any does. No triangle is ignored: these rays may point below the surface that they leave.
#[cold]
fn seen(rays: &Rays, locator: &PatchLocator, [origin, target]: [Vec3; 2], face: u32, expected: u32) -> u32 {
    let error = ERROR * rays.gap();
    let (a, b) = basis((target - origin).normalize_or_zero());
    let mut other = None;
    for aside in [a, b, -a, -b] {
        let direction = target + ASIDE * error * aside - origin;
        let Some(hit) = rays.closest(origin, direction, f32::INFINITY, NO_TRIANGLE) else { continue };
        let (position, met) = place(&hit, origin, direction);
        match locator.find(met, position.to_array(), error) {
            Some(found) if found.at_border => {}
            Some(found) if found.patch == expected => return expected,
            Some(found) if met == face => other = other.or(Some(found.patch)),
            _ => {}
        }
    }
    other.unwrap_or(expected)
}
