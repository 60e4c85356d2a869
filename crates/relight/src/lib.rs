//! The run time on a CPU: direct light, packed product, transfer, pictures.
//!
//! A frame (docs/design.md §3) is direct irradiance of the patches, one product with the packed operator and
//! a transfer to what is looked at. Start at [`Relighter`], which ties a bake together:
//!
//! - [`DirectLight`]: irradiance of all lights of a rig at any point, with shadow rays.
//! - [`element_irradiance`]: the same, averaged over elements of patches.
//! - [`Operator`]: the packed operator of a bake and its product; [`Bounces`]: all bounces of a frame at once.
//! - [`bounces`]: the first k bounces, where the form factors are still there.
//! - [`Receivers`]: the receivers of a bake, ready for frames.
//! - [`light_at_points`], [`render`], [`tone_map`]: what is made of it.
//! - [`View`], [`seen_patches`]: where a camera looks, and which patches it sees.
//!
//! This is the definition that the GPU's answers are held against. Every function gives the same
//! bits for any number of threads.

mod bounces;
mod crowd;
mod direct;
mod emitters;
mod error;
mod operator;
mod patch_light;
mod points;
mod polygon;
mod product;
mod receivers;
mod relighter;
mod render;
mod seen_patches;
mod textures;
mod tone_map;
mod view;

pub use bounces::bounces;
pub use direct::{DirectLight, Samples};
pub use error::{Error, Result};
pub use operator::{Operator, Workspace};
pub use patch_light::{PatchSamples, element_irradiance};
pub use points::{PointLight, light_at_points, radiosity, surface_points};
pub use product::{Bounces, indirect};
pub use receivers::Receivers;
pub use relighter::{Frame, Relighter};
pub use render::{Image, Look, Parts, Shown, render};
pub use seen_patches::{SeenPatch, seen_patches};
pub use textures::{TextureProduct, Workspace as TextureWorkspace};
pub use tone_map::{Exposure, tone_map};
pub use view::View;
