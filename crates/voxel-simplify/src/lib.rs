//! Scene to patches: triangles clipped to voxels and grouped.
//!
//! Every triangle is clipped to the cells of a voxel grid (`grid`, `clip`) and cut where others stand on
//! it or pass through it (`cut`). Within a cell, pieces that touch and face the same way make one sheet (`contact`, `group`); sheets too small to matter join
//! a neighbour that they touch (`merge`). Each side of a sheet is a patch (`assemble`), unless it
//! sees nothing (`visibility`). `search` finds the voxel size for a number of patches; where parts
//! that touch nothing would use them up, such parts share patches, and the insides of solids get
//! coarser ones (`gather`, `inside`, `air`). What patches look like is sampled from the scene's textures (`attributes`).
//!
//! With a coarse bake as a [`Pilot`], [`adaptive()`] makes patches that are small where light changes and large where
//! it does not (`adaptive`).
//!
//! [`Mode::Faces`] is the variant of A. Shcherbakov and V. Frolov, Matrix transformations for
//! efficient implementation of the radiosity algorithm on GPUs, Light & Engineering 27(2), 2019:
//! axis-aligned sides of occupied voxels (`faces`). It is here to be compared with.

mod adaptive;
mod air;
mod assemble;
mod attributes;
mod boxes;
mod cells;
mod clip;
mod contact;
mod cut;
mod draft;
mod error;
mod faces;
mod field;
mod gather;
mod grid;
mod group;
mod inside;
mod lamps;
mod merge;
mod near;
mod pilot;
mod regions;
mod report;
mod rim;
mod search;
mod sets;
mod simplify;
mod surface;
mod tree;
mod trial;
mod visibility;
mod wall;
mod ward;

pub use adaptive::{Adapted, Expected, Level};
pub use error::Error;
pub use pilot::Pilot;
pub use report::{Attempt, Report};
pub use simplify::{adaptive, run, voxel_simplify};

/// How fine the patches are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resolution {
    /// Edge of a voxel, metres.
    Voxel(f32),
    /// Number of patches, met within 10 % where the scene allows it.
    Patches(u32),
}

/// What a patch is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Connected pieces of the surface that face the same way.
    #[default]
    Clusters,
    /// Sides of voxels, as in the paper. They lie off the surface by up to a voxel and their area is
    /// that of the voxel's side, so neither area nor flux is conserved: for comparison only.
    Faces,
}

/// What to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// How fine.
    pub resolution: Resolution,
    /// What a patch is made of.
    pub mode: Mode,
    /// Rays a patch that must all escape before it is dropped; 0 keeps every patch.
    pub visibility_rays: u32,
    /// Seed of every random choice.
    pub seed: u32,
}

impl Default for Params {
    fn default() -> Params {
        Params { resolution: Resolution::Patches(2500), mode: Mode::Clusters, visibility_rays: 128, seed: 1 }
    }
}
