//! Lightmaps: where texels lie on a mesh, where exactly light is gathered for each, and how the picture is filled.
//!
//! 1. An [`Atlas`] lays the triangles out flat: [`Atlas::from_mesh`] takes the coordinates that the scene file brings,
//!    [`unwrap`] makes some.
//! 2. [`texels`] places a receiver in each texel that the mesh touches: on the mesh, in open air, on the side that is
//!    looked at. Texels that lie behind or inside other geometry have none and show one nearby.
//! 3. [`radfile::Lightmap::fill`] makes a picture of values at the receivers that bilinear filters can read.
//!
//! A lightmap has one side of each triangle. Sheets that are lit from both sides must be modelled with two.

mod atlas;
mod coverage;
mod edges;
mod error;
mod flat;
mod own;
mod place;
mod sides;
mod size;
mod spread;
mod texels;
mod unwrap;
mod view;

pub use atlas::{Atlas, NO_CHART};
pub use error::{Error, Result};
pub use size::Size;
pub use texels::{Report, texels};
pub use unwrap::{UnwrapParams, unwrap};

use glam::{DVec3, Vec3};
use radfile::Mesh;

/// Bytes that [`unwrap`] and [`texels`] take at most beside their input, for a mesh of so many triangles and about so
/// many texels in use.
pub fn memory_needed(triangles: u64, texels: u64) -> u64 {
    // Measured on scenes of 32 to 331 000 triangles, rounded up.
    const TRIANGLE: u64 = 800;
    const TEXEL: u64 = 256;
    triangles.saturating_mul(TRIANGLE).saturating_add(texels.saturating_mul(TEXEL))
}

/// Twice the area of a triangle as a vector along the normal of its front.
fn cross(mesh: &Mesh, triangle: u32) -> DVec3 {
    let [a, b, c] = mesh.corners(triangle as usize).map(|p| Vec3::from(p).as_dvec3());
    (b - a).cross(c - a)
}

/// Area of a triangle, m².
fn area(mesh: &Mesh, triangle: u32) -> f64 {
    0.5 * cross(mesh, triangle).length()
}
