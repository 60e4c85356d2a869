//! The run time on a GPU: shadow maps, patch light, packed product, transfer, shading.
//!
//! A frame is a handful of passes in one submission (docs/design.md §3): for every lamp a shadow map and the light
//! it brings to points (samples of patches, points of a list, pixels); the mean over each patch; the packed
//! operator times what the patches send, which is all further bounces; the gather at receivers; the shading
//! of a picture. The CPU does the same in `relight`, which is the twin that this crate is judged by.
//!
//! The operator is [`Packed`] as block-compressed textures or as hierarchical blocks in storage buffers.
//! [`LastGather`] brings what patches or their elements send to many receivers by packed rows.
//!
//! Start at [`Gpu::new`] and [`GpuRuntime::new`]. Kernels are in `shaders/`, one a file; this is the only
//! crate that knows wgpu.
//!
//! Lights and cameras come in the scene file's axes, points in local axes: the scene's minus `mesh.origin`.

mod buffers;
mod colour;
mod emitters;
mod error;
mod frame;
mod gather;
mod gpu;
mod hierarchical;
mod kernels;
mod lamp;
mod last_gather;
mod operator;
mod packed;
mod patch_tables;
mod picture;
mod probe;
mod runtime;
mod shadows;
mod textures;
mod timing;
mod view;

pub use error::{Error, Result};
pub use gpu::{Adapter, Gpu};
pub use last_gather::LastGather;
pub use operator::Decode;
pub use packed::Packed;
pub use picture::Parts;
pub use runtime::{Bake, GpuRuntime, Params, PointLight, Relit, Report};
pub use timing::{Clock, Timing};
