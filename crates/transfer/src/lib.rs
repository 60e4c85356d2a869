//! How light gets from patches to vertices and points.
//!
//! Patches are coarse and carry one irradiance each; what is looked at is fine. This stage tessellates the mesh to
//! about the voxel size (`tessellate.rs`), decides which sides of which fine vertices receive light (`receivers.rs`,
//! `sight.rs`), and says how light comes to each. Two ways lead there:
//!
//! - [`Mode::Gather`]: form factors from the receiver to all that it sees (`gather.rs`), packed by the crate `hmatrix`.
//!   What it sees are the elements of patches (`elements.rs`).
//! - [`Mode::Interpolate`]: a short row of weights over the patches near it, on its side, that it can see
//!   (`neighbours.rs`, `fit.rs`). A row sums to 1, so a flat floor under uniform light stays flat. Cheaper, and several
//!   times less accurate.
//!
//! Every weight stands for a path through open air that was tested by rays, so no light passes a wall however thin it
//! is.
//!
//! [`transfer`] makes the record of a bake, [`lightmap()`] that of a lightmap, [`volume()`] that of an irradiance
//! volume, [`gather_for_points`] and [`interpolate_for_points`] the rows of any other points.

mod elements;
mod error;
mod fit;
mod gather;
mod neighbours;
mod open_air;
mod points;
mod receivers;
mod report;
mod rows;
mod sight;
mod spread;
mod stage;
mod tessellate;
mod texels;
mod triangle;
mod volume;

pub use elements::subdivide;
pub use error::{Error, Result};
pub use gather::{GatherParams, Senders, gather_for_points, gather_memory_needed, pack};
pub use points::rows_for_points as interpolate_for_points;
pub use report::{Gathered, Interpolated, Report};
pub use stage::{memory_needed, run};
pub use texels::{LightmapParams, lightmap};
pub use volume::{VolumeParams, probe_receivers, volume};

use radfile::{Mesh, Patches, Progress, Transfer, Weights};
use rayon::prelude::*;
use scene::{NO_TRIANGLE, Rays, SurfacePoint};

use crate::{neighbours::Neighbours, receivers::Receiver, rows::Row, sight::Sight};

/// How light comes to receivers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// From all that they see.
    #[default]
    Gather,
    /// From patches around them.
    Interpolate,
}

/// What receives, how fine it is and how light comes to it.
#[derive(Clone, Debug)]
pub struct Params {
    /// How light comes to them.
    pub mode: Mode,
    /// Longest edge of the fine mesh, metres; `None` is the voxel size or, if that is longer, the extent of a mean
    /// patch.
    pub edge: Option<f32>,
    /// Interpolation: search radius for patches, voxels; grows where it finds none.
    pub radius: f32,
    /// Largest number of fine triangles that is accepted.
    pub max_triangles: u64,
    /// The gather's rays.
    pub gather: GatherParams,
    /// Error of the receivers' light that packing the gather may cause: L2, mean over probe lights; 0.01 is 1 %.
    pub gather_error: f64,
    /// A lightmap to make as well; it is gathered.
    pub lightmap: Option<LightmapParams>,
    /// An irradiance volume to make as well; it is gathered.
    pub volume: Option<VolumeParams>,
}

impl Default for Params {
    fn default() -> Params {
        Params {
            mode: Mode::default(),
            edge: None,
            radius: 1.5,
            max_triangles: 4_000_000,
            gather: GatherParams { rays: 1024, ..GatherParams::default() },
            gather_error: 0.01,
            lightmap: None,
            volume: None,
        }
    }
}

/// Tessellates the mesh, finds its receivers and how light comes to them.
///
/// `senders` are of the bake that `mesh` is of; interpolation does not look at their elements.
///
/// # Errors
///
/// [`Error::Edge`] if the edge is no positive length, [`Error::TooFine`] if the tessellation would
/// exceed [`Params::max_triangles`], [`Error::Packing`].
///
/// # Panics
///
/// If the patches belong to another mesh: a bug in the caller, a container is checked when it is read.
pub fn transfer(
    mesh: &Mesh,
    senders: &Senders,
    params: &Params,
    progress: &dyn Progress,
) -> Result<(Transfer, Report)> {
    let (patches, rays) = (senders.patches, senders.rays);
    let faces = patches.locator.face_start.len().saturating_sub(1);
    assert_eq!(faces, mesh.face_count(), "the patches must belong to the mesh");
    let edge = params.edge.unwrap_or_else(|| usual_edge(patches));
    let mut fine = tessellate::tessellate(mesh, edge, params.max_triangles)?;
    progress.begin("receivers", fine.vertex.len() as u64);
    let sight = Sight::new(rays, patches.locator.cell_size);
    let receivers = receivers::find(mesh, patches, &sight, &mut fine, progress);
    let mut report = Report {
        edge,
        fine_vertices: fine.vertex.len(),
        fine_triangles: fine.triangle.len(),
        receivers: receivers.len(),
        ..Report::default()
    };
    let weights = match params.mode {
        Mode::Interpolate => {
            let rows = interpolate(patches, rays, &receivers, params, progress);
            report.interpolated = Some(Interpolated::of(&rows));
            Weights::Interpolated(rows::join(rows))
        }
        Mode::Gather => {
            // Its normal is the mean of several triangles; a ray below its own must not pass through that.
            let point = |r: &Receiver| SurfacePoint { position: r.position, normal: r.normal, triangle: NO_TRIANGLE };
            let points: Vec<SurfacePoint> = receivers.iter().map(point).collect();
            let (gathered, numbers) = pack(senders, &points, &params.gather, params.gather_error, progress)?;
            // Between a floor's vertex under a box and one beside it, light does not fade: only the latter counts.
            fine.drop_receivers(&numbers.buried);
            report.gathered = Some(numbers);
            Weights::Gathered(gathered)
        }
    };
    let vectors = |f: fn(&Receiver) -> [f32; 3]| receivers.iter().map(f).collect();
    let [position, normal] = [vectors(|r| r.position.to_array()), vectors(|r| r.normal.to_array())];
    Ok((Transfer { position, normal, weights, fine }, report))
}

/// The voxel size or, where patches were joined over several voxels, their extent.
fn usual_edge(patches: &Patches) -> f32 {
    let area: f64 = patches.area.iter().map(|&a| f64::from(a)).sum();
    patches.locator.cell_size.max((area / patches.len().max(1) as f64).sqrt() as f32)
}

fn interpolate(
    patches: &Patches,
    rays: &Rays,
    receivers: &[Receiver],
    params: &Params,
    progress: &dyn Progress,
) -> Vec<Row> {
    let neighbours = Neighbours::new(patches, rays, params.radius);
    progress.begin("weights", receivers.len() as u64);
    let row = |r: &Receiver| {
        let own = || patches.locator.patch_at(r.face, r.position.to_array());
        let row = neighbours.row(r.position, r.normal, own);
        progress.advance(1);
        row
    };
    receivers.par_iter().map(row).collect()
}
