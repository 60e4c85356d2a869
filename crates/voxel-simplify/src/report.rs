//! What happened, for people and tests.

use radfile::Patches;
use serde::Serialize;

use crate::{Adapted, Mode, Params, Resolution, surface::Surface, trial::Trial};

/// A count further from the wanted one is warned about.
const PROMISED: f64 = 0.10;
/// Emitted flux may miss the scene's by this before it is warned about; textures are sampled.
const FLUX_TOLERANCE: f64 = 0.01;

/// Numbers of one run. Areas are in m² and count both sides where both are used.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Edge of a voxel, metres.
    pub voxel: f32,
    /// Cells that hold a piece of the surface.
    pub cells: usize,
    /// Triangles that lie exactly on another; they share its patches.
    pub coincident_triangles: usize,
    /// Triangles without area.
    pub degenerate_triangles: usize,
    /// Clipped and cut pieces, each counted once though it may have two sides.
    pub pieces: usize,
    /// Pieces that were cut because another surface stands on them or passes through.
    pub cut: usize,
    /// Those of them that would have taken more cuts than one piece may have.
    pub capped: usize,
    /// Small sheets that joined a neighbour.
    pub merged: usize,
    /// Patches on the insides of solids that became part of another, to leave room for what people look at.
    pub coarsened: usize,
    /// Small patches that became part of another though they need not touch it, to leave room for large surfaces.
    pub gathered: usize,
    /// Patches kept.
    pub patches: usize,
    /// Patches that were dropped because they see nothing.
    pub dropped: usize,
    /// Visibility rays cast.
    pub rays: u64,
    /// Area of all usable sides of the mesh; what coincides counts once.
    pub scene_area: f64,
    /// Area of the patches.
    pub patch_area: f64,
    /// Area of patches that see nothing.
    pub dropped_area: f64,
    /// Area of slivers too small to be a patch (below a billionth of a voxel's side).
    pub sliver_area: f64,
    /// |patches + dropped + slivers − scene| / scene. Rounding, unless the mode is [`crate::Mode::Faces`].
    pub area_error: f64,
    /// Flux that the emissive surfaces of the scene emit, W, linear RGB, sampled triangle by triangle.
    pub scene_flux: [f64; 3],
    /// Flux that the patches emit, W.
    pub patch_flux: [f64; 3],
    /// Flux of dropped patches, W.
    pub dropped_flux: [f64; 3],
    /// Mean area of a patch.
    pub mean_area: f64,
    /// Smallest area of a patch.
    pub least_area: f64,
    /// Largest area of a patch.
    pub largest_area: f64,
    /// Sizes tried to reach a number of patches, in order; empty if a voxel size was given.
    pub attempts: Vec<Attempt>,
    /// Sizes and expected errors of adaptive patches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adaptive: Option<Adapted>,
    /// What the reader should know.
    pub warnings: Vec<String>,
}

/// One voxel size that was tried.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Attempt {
    /// Edge of a voxel, metres.
    pub voxel: f32,
    /// Layers of cells beyond those needed, along x, y and z.
    pub extra_layers: [u32; 3],
    /// Patches after dropping.
    pub patches: usize,
}

/// Gathers the numbers of a finished trial.
pub fn report(
    surface: &Surface,
    scene_flux: [f64; 3],
    trial: &Trial,
    patches: &Patches,
    attempts: Vec<Attempt>,
    params: &Params,
) -> Report {
    let drafted = &trial.draft.patches;
    let unseen: Vec<usize> = (0..drafted.len()).filter(|&p| trial.owner[p].is_none()).collect();
    let area = |patch: usize| f64::from(patches.area[patch]);
    let areas = || (0..patches.len()).map(area);
    let patch_area: f64 = areas().sum();
    let dropped_area: f64 = unseen.iter().map(|&p| f64::from(drafted.area[p])).sum();
    let (scene_area, sliver_area) = (surface.used_area(), trial.draft.sliver_area);
    let mut report = Report {
        voxel: trial.voxel,
        cells: trial.draft.cells,
        coincident_triangles: surface.coincident,
        degenerate_triangles: surface.degenerate,
        pieces: trial.draft.pieces,
        cut: trial.cuts.cut,
        capped: trial.cuts.capped,
        merged: trial.draft.merged,
        coarsened: trial.coarsened,
        gathered: trial.gathered,
        patches: patches.len(),
        dropped: unseen.len(),
        rays: trial.rays,
        scene_area,
        patch_area,
        dropped_area,
        sliver_area,
        area_error: (patch_area + dropped_area + sliver_area - scene_area).abs() / scene_area,
        scene_flux,
        patch_flux: flux(patches, 0..patches.len()),
        dropped_flux: flux(drafted, unseen),
        mean_area: patch_area / patches.len() as f64,
        least_area: areas().fold(f64::INFINITY, f64::min),
        largest_area: areas().fold(0.0, f64::max),
        attempts,
        adaptive: trial.adapted.clone(),
        warnings: vec![],
    };
    report.warnings = warn_of_count(&report, params).into_iter().chain(warn_of_flux(&report, params)).collect();
    report
}

/// Emitted flux of some patches, W.
fn flux(patches: &Patches, which: impl IntoIterator<Item = usize>) -> [f64; 3] {
    which.into_iter().fold([0.0; 3], |sum, p| {
        std::array::from_fn(|c| sum[c] + f64::from(patches.area[p]) * f64::from(patches.emission[p][c]))
    })
}

fn warn_of_count(report: &Report, params: &Params) -> Vec<String> {
    let Resolution::Patches(wanted) = params.resolution else { return vec![] };
    let mut warnings = Vec::new();
    if report.gathered > 0 {
        warnings.push(format!(
            "{} small patches share one with others of their voxel that face the same way, though they need not touch: \
             they would crowd out the large surfaces among {wanted} patches",
            report.gathered
        ));
    }
    let off = report.patches as f64 / f64::from(wanted) - 1.0;
    if off.abs() > PROMISED {
        let why = if report.adaptive.is_some() && report.patches < wanted as usize {
            "voxels a quarter as large do not make more"
        } else if report.attempts.iter().all(|a| a.patches > wanted as usize) {
            "the scene has that many separate parts and facings at any voxel size"
        } else {
            "the count jumps over the wanted one between two voxel sizes"
        };
        warnings.push(format!(
            "{wanted} patches were asked for, {} is the nearest that was found ({:+.0} %), with voxels of {} m: {why}",
            report.patches,
            100.0 * off,
            report.voxel
        ));
    }
    warnings
}

fn warn_of_flux(report: &Report, params: &Params) -> Vec<String> {
    let [scene, kept, dropped] =
        [report.scene_flux, report.patch_flux, report.dropped_flux].map(|f| f.iter().sum::<f64>());
    let mut warnings = Vec::new();
    if dropped > 0.0 {
        warnings.push(format!(
            "{dropped:.4} W of the {scene:.4} W that the scene emits leave from patches that see nothing and were dropped"
        ));
    }
    if (kept + dropped - scene).abs() > FLUX_TOLERANCE * scene {
        let why = if params.mode == Mode::Faces { ": sides of voxels do not conserve flux" } else { "" };
        warnings.push(format!("the patches emit {:.4} W, the scene {scene:.4} W{why}", kept + dropped));
    }
    warnings
}
