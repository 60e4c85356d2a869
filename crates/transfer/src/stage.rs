//! From container to container.

use radfile::{
    Accuracy, Builder, Container, Elements, Lightmap, Mesh, Patches, Progress, Record, Sink, Step, Transfer, Volume,
};
use scene::{Rays, Scene, Surfaces};

use crate::{
    Error, Mode, Params, Report, Result, Senders, gather_memory_needed, lightmap, subdivide, tessellate, transfer,
    usual_edge, volume,
};

/// The stage: reads the scene and its patches, adds `transfer.*`, for a gather `elements.*`, and `lightmap.*` and
/// `volume.*` if asked for. What an earlier run of the stage made is dropped, and what was measured of it (`accuracy.*`).
///
/// # Errors
///
/// What [`transfer`], [`lightmap()`] and [`volume()`] refuse, [`Error::CutOperator`], [`Error::NotGathered`], or a
/// container that cannot be read or written.
pub fn run(input: &Container, params: &Params, step: Step, progress: &dyn Progress, sink: &mut Sink) -> Result<Report> {
    if let (Mode::Gather, Some(bounces)) = (params.mode, radfile::bounces_held(input)?) {
        return Err(Error::CutOperator { bounces });
    }
    for (what, wanted) in [("a lightmap", params.lightmap.is_some()), ("an irradiance volume", params.volume.is_some())]
    {
        if wanted && params.mode != Mode::Gather {
            return Err(Error::NotGathered { what });
        }
    }
    let (patches, scene) = (Patches::read(input)?, Scene::read(input)?);
    let mesh = &scene.mesh;
    let rays = Rays::new(mesh);
    let elements = match params.mode {
        Mode::Interpolate => Elements::whole(&patches),
        Mode::Gather => subdivide(&patches, &Surfaces::new(mesh, &scene.materials)?, &rays, progress),
    };
    let senders = Senders { patches: &patches, elements: &elements, rays: &rays };
    let (transfer, mut report) = transfer(mesh, &senders, params, progress)?;
    let lightmap = params.lightmap.map(|size| lightmap(mesh, &senders, &size, params, progress)).transpose()?;
    let volume = params.volume.map(|wanted| volume(mesh, &senders, &wanted, params, progress)).transpose()?;
    let stale = [Transfer::PREFIX, Elements::PREFIX, Lightmap::PREFIX, Volume::PREFIX, Accuracy::PREFIX];
    let outlasts = |name: &str| !stale.iter().any(|prefix| name.starts_with(prefix));
    let mut builder = Builder::from_input(input, |s| outlasts(&s.name));
    transfer.write(&mut builder);
    if params.mode == Mode::Gather {
        elements.write(&mut builder);
    }
    if let Some((texels, gathered, numbers)) = &lightmap {
        texels.write(&mut builder);
        gathered.write(&mut builder, Lightmap::PREFIX, 0);
        report.lightmap = Some(numbers.clone());
    }
    if let Some((probes, gathered, numbers)) = &volume {
        probes.write(&mut builder);
        gathered.write(&mut builder, Volume::PREFIX, 0);
        report.volume = Some(numbers.clone());
    }
    builder.provenance(Some(input), step)?;
    sink(&builder)?;
    Ok(report)
}

/// Bytes that [`run`] takes at most, about.
///
/// # Errors
///
/// A container without mesh or patches; an irradiance volume of too many cells.
pub fn memory_needed(input: &Container, params: &Params) -> Result<u64> {
    if params.mode == Mode::Interpolate {
        return Ok(0); // a tessellation that is out of proportion is refused by itself
    }
    let (mesh, patches) = (Mesh::read(input)?, Patches::read(input)?);
    let edge = params.edge.unwrap_or_else(|| usual_edge(&patches));
    // A fine triangle has half a vertex, and a vertex about two receivers, one a side.
    let receivers = tessellate::estimate(&mesh, edge).min(params.max_triangles as f64) as usize;
    let senders = SENDERS_A_PATCH * patches.len();
    let gather = |receivers: usize| {
        let packing = hmatrix::rows_memory_needed(receivers, senders, &hmatrix::Params::error(params.gather_error));
        gather_memory_needed(receivers, senders, &params.gather) + packing
    };
    let texels = params.lightmap.map_or(0, |size| size.texels);
    let placing = if texels > 0 { lightmap::memory_needed(mesh.triangles.len() as u64, texels.into()) } else { 0 };
    let of_volume = match params.volume {
        Some(wanted) => Volume::NORMALS.len() * volume::cells(&mesh, &wanted)?.cells(),
        None => 0,
    };
    // One set of receivers after the other.
    Ok(gather(receivers).max(gather(texels as usize) + placing).max(gather(of_volume)))
}

/// The patch and its elements, more than [`subdivide`] makes.
const SENDERS_A_PATCH: usize = 6;
