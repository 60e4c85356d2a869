//! The stage: from a scene to its patches, and to a container.

use radfile::{Builder, Patches, Progress, Record, Sink, Step};
use scene::{Rays, Scene, Surfaces};

use crate::{
    Attempt, Error, Mode, Params, Pilot, Report, Resolution,
    adaptive::adapt,
    attributes::emitted_flux,
    draft::compose,
    report::report,
    search::{Outcome, search},
    surface::Surface,
    trial::{Bench, Trial},
};

/// Edge of the largest voxel, in lengths of the scene: beyond one, all are alike but for rounding.
pub const MOST_EXTENTS: f32 = 100.0;

/// Turns the surface of a scene into patches.
///
/// | returns | meaning | unit |
/// |---|---|---|
/// | `.0` | patches that see another, in the order of voxels, with their locator | m, m², W/m² |
/// | `.1` | what was found, dropped and conserved | m² and W |
///
/// # Errors
///
/// A mesh without area, a voxel size that is no length, too small or too large, a texture that cannot be
/// decoded, or a scene in which no patch sees another.
///
/// # Panics
///
/// If a triangle names a vertex or a material that is not there: [`Scene::read`] and the importers
/// make sure of both.
pub fn voxel_simplify(scene: &Scene, params: &Params, progress: &dyn Progress) -> Result<(Patches, Report), Error> {
    let surface = Surface::new(scene)?;
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials)?;
    let bench = Bench { surface: &surface, rays: Rays::new(&scene.mesh), params, progress };
    let (mut trial, attempts) = match params.resolution {
        Resolution::Voxel(voxel) => {
            check_proportion(voxel, &surface)?;
            (bench.attempt(voxel, [0; 3])?, vec![])
        }
        Resolution::Patches(0) => return Err(Error::NoPatchesWanted),
        Resolution::Patches(wanted) => find_size(&bench, wanted)?,
    };
    bench.colour(&mut trial, &surfaces);
    let patches = compose(&trial.draft.patches, &trial.owner);
    let report = report(&surface, emitted_flux(&surface, &surfaces), &trial, &patches, attempts, params);
    Ok((patches, report))
}

/// Turns the surface of a scene into patches that are small where light changes and large where it does not.
///
/// `pilot` is a coarse bake of the same scene, which says where that is. `params` must ask for a number of patches.
///
/// # Errors
///
/// Those of [`voxel_simplify`], or a pilot of another scene.
///
/// # Panics
///
/// As [`voxel_simplify`].
pub fn adaptive(
    scene: &Scene,
    params: &Params,
    pilot: &Pilot,
    progress: &dyn Progress,
) -> Result<(Patches, Report), Error> {
    let (Resolution::Patches(wanted), Mode::Clusters) = (params.resolution, params.mode) else {
        return Err(Error::NotAdaptive);
    };
    if wanted == 0 {
        return Err(Error::NoPatchesWanted);
    }
    pilot.check(scene)?;
    let surface = Surface::new(scene)?;
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials)?;
    let bench = Bench { surface: &surface, rays: Rays::new(&scene.mesh), params, progress };
    let trial = adapt(&bench, &surfaces, pilot, wanted as usize)?;
    let patches = compose(&trial.draft.patches, &trial.owner);
    let report = report(&surface, emitted_flux(&surface, &surfaces), &trial, &patches, vec![], params);
    Ok((patches, report))
}

/// Refuses voxels that could only be a mistake.
fn check_proportion(voxel: f32, surface: &Surface) -> Result<(), Error> {
    let extent = (surface.upper - surface.lower).max_element() as f32;
    match voxel.is_finite() && voxel > MOST_EXTENTS * extent {
        true => Err(Error::VoxelTooLarge { voxel, extent }),
        false => Ok(()),
    }
}

/// The voxel size that comes nearest to `wanted` patches. Once small patches crowd out the others they are gathered.
fn find_size(bench: &Bench, wanted: u32) -> Result<(Trial, Vec<Attempt>), Error> {
    // In a closed room one side of every triangle is seen.
    let start = (0.5 * bench.surface.used_area() / f64::from(wanted)).sqrt() as f32;
    // A little more, so that the slack of the grid does not cut the scene in two.
    let whole = 1.05 * (bench.surface.upper - bench.surface.lower).max_element() as f32;
    let mut gather = false;
    search(wanted, start, whole, |voxel, extra_layers| {
        let mut trial = bench.attempt(voxel, extra_layers)?;
        let gathers = bench.economise(&mut trial, gather);
        let changed = gathers && !gather;
        gather |= gathers;
        Ok(Outcome { patches: trial.count(), value: trial, changed })
    })
}

/// Runs the stage: the scene and its patches go to `sink` as a container, with `step` as its provenance.
///
/// # Errors
///
/// Those of [`voxel_simplify`] or, with a pilot, of [`adaptive`], and what `sink` says.
pub fn run(
    scene: &Scene,
    params: &Params,
    pilot: Option<&Pilot>,
    step: Step,
    progress: &dyn Progress,
    sink: &mut Sink,
) -> Result<Report, Error> {
    let (patches, report) = match pilot {
        None => voxel_simplify(scene, params, progress)?,
        Some(pilot) => adaptive(scene, params, pilot, progress)?,
    };
    let mut builder = Builder::new();
    scene.write(&mut builder);
    patches.write(&mut builder);
    builder.provenance(None, step)?;
    sink(&builder)?;
    Ok(report)
}
