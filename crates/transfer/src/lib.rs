//! Patch light to vertices and points: normalised, visibility-aware weights.
//!
//! Patches are coarse and carry one irradiance each; what is looked at is fine. This stage
//! tessellates the mesh to about the voxel size (`tessellate.rs`), decides which sides of which
//! fine vertices receive light (`receivers.rs`), and gives each receiver a short row of weights
//! over the patches near it, on its side, that it can see (`senders.rs`, `fit.rs`, `sight.rs`).
//! A row sums to 1, so a flat floor under uniform light stays flat; every weight stands for a path
//! through open air that was tested by rays, so no light passes a wall however thin it is.
//!
//! [`transfer`] makes the record of a bake, [`rows_for_points`] the rows of any other points. Where it may take
//! some thousand rays a point, [`gather_for_points`] is several times more accurate: form factors from the point to
//! all that it sees (`gather.rs`).

mod error;
mod fit;
mod gather;
mod points;
mod receivers;
mod senders;
mod sight;
mod tessellate;
mod triangle;

pub use error::{Error, Result};
pub use gather::{GatherParams, gather_for_points, gather_memory_needed};
pub use points::rows_for_points;

use radfile::{Builder, Container, Mesh, Patches, Progress, Record, Sink, Step, Transfer};
use rayon::prelude::*;
use scene::Rays;
use serde::Serialize;

use crate::{
    receivers::Receiver,
    senders::{Row, Senders},
};

/// How fine the receivers are and how far they look.
#[derive(Clone, Debug)]
pub struct Params {
    /// Longest edge of the fine mesh, metres; `None` is the voxel size.
    pub edge: Option<f32>,
    /// Search radius for patches, voxels; grows where it finds none.
    pub radius: f32,
    /// Largest number of fine triangles that is accepted.
    pub max_triangles: u64,
}

impl Default for Params {
    fn default() -> Params {
        Params { edge: None, radius: 1.5, max_triangles: 4_000_000 }
    }
}

/// What was made, for people.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Longest edge that was left whole, metres.
    pub edge: f32,
    /// Vertices of the fine mesh.
    pub fine_vertices: usize,
    /// Triangles of the fine mesh.
    pub fine_triangles: usize,
    /// Sides of fine vertices that receive light.
    pub receivers: usize,
    /// Weights in all rows.
    pub entries: usize,
    /// Weights in a row, on average.
    pub mean_row: f64,
    /// Weights in the longest row.
    pub longest_row: usize,
    /// Rows without a weight.
    pub empty_rows: usize,
    /// Rows that found no patch in sight and take the patch that they lie on.
    pub fallback_rows: usize,
    /// Rows that found patches only beyond the first radius.
    pub widened_rows: usize,
}

/// Tessellates the mesh and finds the weights of its receivers.
///
/// | argument | meaning |
/// |---|---|
/// | `mesh`, `patches` | of the same bake; the patches' locator must count the faces of the mesh |
/// | `rays` | over all triangles of `mesh` |
///
/// # Errors
///
/// [`Error::Edge`] if the edge is no positive length, [`Error::TooFine`] if the tessellation would
/// exceed [`Params::max_triangles`].
///
/// # Panics
///
/// If `patches` belong to another mesh: a bug in the caller, a container is checked when it is read.
pub fn transfer(
    mesh: &Mesh,
    patches: &Patches,
    rays: &Rays,
    params: &Params,
    progress: &dyn Progress,
) -> Result<(Transfer, Report)> {
    let faces = patches.locator.face_start.len().saturating_sub(1);
    assert_eq!(faces, mesh.face_count(), "the patches must belong to the mesh");
    let edge = params.edge.unwrap_or(patches.locator.cell_size);
    let mut fine = tessellate::tessellate(mesh, edge, params.max_triangles)?;
    let senders = Senders::new(patches, rays, params.radius);
    progress.begin("receivers", fine.vertex.len() as u64);
    let receivers = receivers::find(mesh, patches, &senders.sight, &mut fine, progress);
    progress.begin("weights", receivers.len() as u64);
    let rows: Vec<Row> = receivers
        .par_iter()
        .map(|r| {
            let row = senders.row(r.position, r.normal, || patches.locator.patch_at(r.face, r.position.to_array()));
            progress.advance(1);
            row
        })
        .collect();
    let report = report(edge, fine.vertex.len(), fine.triangle.len(), &rows);
    let vectors = |f: fn(&Receiver) -> [f32; 3]| receivers.iter().map(f).collect();
    let transfer = Transfer {
        position: vectors(|r| r.position.to_array()),
        normal: vectors(|r| r.normal.to_array()),
        rows: senders::join(rows),
        fine,
    };
    Ok((transfer, report))
}

/// The stage: reads mesh and patches, adds `transfer.*`.
///
/// # Errors
///
/// What [`transfer`] refuses, or a container that cannot be read or written.
pub fn run(input: &Container, params: &Params, step: Step, progress: &dyn Progress, sink: &mut Sink) -> Result<Report> {
    let (mesh, patches) = (Mesh::read(input)?, Patches::read(input)?);
    let rays = Rays::new(&mesh);
    let (transfer, report) = transfer(&mesh, &patches, &rays, params, progress)?;
    let mut builder = Builder::from_input(input, |s| !s.name.starts_with(Transfer::PREFIX));
    transfer.write(&mut builder);
    builder.provenance(Some(input), step)?;
    sink(&builder)?;
    Ok(report)
}

fn report(edge: f32, fine_vertices: usize, fine_triangles: usize, rows: &[Row]) -> Report {
    let count = |f: fn(&Row) -> bool| rows.iter().filter(|r| f(r)).count();
    let entries = rows.iter().map(|r| r.entries.len()).sum();
    Report {
        edge,
        fine_vertices,
        fine_triangles,
        receivers: rows.len(),
        entries,
        mean_row: entries as f64 / rows.len().max(1) as f64,
        longest_row: rows.iter().map(|r| r.entries.len()).max().unwrap_or(0),
        empty_rows: count(|r| r.entries.is_empty()),
        fallback_rows: count(|r| r.fallback),
        widened_rows: count(|r| r.widened),
    }
}
