//! Everything that knows what a scene is: import, surfaces, lights, cameras, rays and sampling.
//!
//! - [`import`]: OBJ + MTL and glTF 2.0 to a [`Scene`] and an [`ImportReport`] of what was ignored.
//! - [`Surfaces`]: reflectance and emission at a point of a triangle, textures decoded.
//! - [`Rays`]: watertight closest-hit and visibility queries; [`land`]: the patch that a ray meets.
//! - [`Sobol`], [`cosine_direction`], [`PatchSampler`]: points and directions, deterministic.
//! - [`Air`]: where lamps could hang that nobody has hung yet.
//! - [`LightRig`], [`Light`], [`Camera`]: the JSON files of docs/design.md §4.
//!
//! Files are read through the [`Folder`] that the caller hands in; nothing here touches the disk.

mod air;
mod camera;
mod element_points;
mod error;
mod import;
mod landing;
mod lights;
mod one_place;
mod patch_sampler;
mod rays;
mod sampling;
mod scene;
mod stored_extras;
mod surfaces;
mod texture;
mod triangle_test;
mod wide_bvh;

pub use air::Air;
pub use camera::Camera;
pub use element_points::ElementPoints;
pub use error::{Error, Result};
pub use import::{Folder, ImportOptions, ImportReport, import};
pub use landing::{Landing, land};
pub use lights::{Light, LightRig};
pub use patch_sampler::{PatchSampler, SurfacePoint};
pub use rays::{Hit, NO_TRIANGLE, Rays};
pub use sampling::{Sobol, basis, cosine_direction, hash, square_to_triangle};
pub use scene::{Extras, Scene};
pub use surfaces::{MAX_REFLECTANCE, Surfaces};
