//! Operator to block-compressed textures and outliers.
//!
//! A frame multiplies by the operator K, so K should be small and a GPU should decode it for
//! nothing. Its few largest entries are kept apart, the others are mapped to codes in 0..1 (by a
//! logarithm, as A. Shcherbakov and V. Frolov do, or by a square root, which loses less) and stored
//! as a texture: the whole matrix in BC1, as they do, or half of its luma in BC4 and its colour as a basis of low
//! rank. What the packing costs is measured as what a viewer sees of it: the error of indirect irradiance under
//! probe lights.
//!
//! Source: A. Shcherbakov, V. Frolov, Matrix transformations for efficient implementation of the
//! radiosity algorithm on GPUs, Light & Engineering 27(2), 2019. How bytes become values again is
//! defined by [`radfile::PackedOperator`].
//!
//! - [`pack`] works on values, [`run`] on containers, [`dds`] and [`ktx2()`] export the texture.
//! - [`Params::PRESETS`] are the combinations that have names.

mod bc1;
mod bc4;
mod blocks;
mod choose;
mod colour;
mod dds;
mod error;
mod ktx2;
mod luma;
mod measure;
mod pack;
mod params;
mod quantile;
mod report;
mod small;
mod split;
mod stage;

pub use dds::dds;
pub use error::{Error, Result};
pub use ktx2::ktx2;
pub use measure::measure;
pub use pack::{memory_needed, pack};
pub use params::{MapKind, Outliers, Params};
pub use probes::{Errors, probe_lights};
pub use report::Report;
pub use stage::run;
