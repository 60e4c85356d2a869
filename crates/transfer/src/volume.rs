//! The probes of an irradiance volume, and what they gather.
//!
//! The bounding box of the scene is cut into equal cells with a probe in the middle of each. A probe inside or behind
//! geometry would be dark, and a filter would carry its darkness into the open; it is left out (`open_air.rs`), and its
//! cell shows a probe nearby (`spread.rs`).

use glam::Vec3;
use radfile::{Gathered, LARGEST_VOLUME, Mesh, Progress, Volume};
use scene::{NO_TRIANGLE, Rays, SurfacePoint};

use crate::{
    Error, Params, Result, Senders,
    gather::pack,
    open_air::open_air,
    report,
    spread::{NONE, spread},
};

/// How fine an irradiance volume is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeParams {
    /// Longest edge of a cell, metres; edges are shortened so that whole cells fill the box.
    pub spacing: f32,
    /// Largest number of cells that is accepted.
    pub max_cells: u64,
}

impl Default for VolumeParams {
    fn default() -> VolumeParams {
        VolumeParams { spacing: 1.0, max_cells: 1 << 17 }
    }
}

/// Walls like to stand in the middle between others, where a probe would lie on them: probes are moved off the middle
/// of their cells by this share of the edges.
const ASIDE: Vec3 = Vec3::new(0.011, 0.017, 0.013);

/// Cells that cover the scene; no probe is in them yet.
///
/// # Errors
///
/// [`Error::Spacing`] if the spacing is no length, [`Error::TooManyCells`].
pub fn cells(mesh: &Mesh, wanted: &VolumeParams) -> Result<Volume> {
    if !(wanted.spacing > 0.0 && wanted.spacing.is_finite()) {
        return Err(Error::Spacing { found: wanted.spacing });
    }
    let corners = || mesh.triangles.iter().flatten().map(|&v| Vec3::from(mesh.positions[v as usize]));
    let (low, high) =
        (corners().reduce(Vec3::min).unwrap_or_default(), corners().reduce(Vec3::max).unwrap_or_default());
    let count = |spacing: f32| (high - low).to_array().map(|e| (f64::from(e / spacing) - 1e-3).ceil().max(1.0));
    let fits = |spacing: f32| {
        let count = count(spacing);
        count.iter().product::<f64>() <= wanted.max_cells.max(1) as f64
            && count.iter().all(|&n| n <= LARGEST_VOLUME.into())
    };
    if !fits(wanted.spacing) {
        let longer = |spacing: &f32| Some(spacing * 1.1);
        let remedy = std::iter::successors(Some(wanted.spacing), longer).find(|&s| fits(s)).unwrap_or(f32::MAX);
        let limit = wanted.max_cells;
        return Err(Error::TooManyCells { spacing: wanted.spacing, found: count(wanted.spacing), limit, remedy });
    }
    let count = count(wanted.spacing).map(|n| n as u32);
    // What is flatter than a cell lies in the middle of it.
    let box_of = |a: usize| if count[a] == 1 { wanted.spacing } else { high[a] - low[a] };
    let origin = |a: usize| 0.5 * (low[a] + high[a]) - 0.5 * box_of(a);
    Ok(Volume {
        origin: std::array::from_fn(origin),
        spacing: std::array::from_fn(|a| box_of(a) / count[a] as f32),
        count,
        ..Volume::default()
    })
}

/// Places the probes of an irradiance volume and packs their form factors.
///
/// # Errors
///
/// [`Error::Spacing`], [`Error::TooManyCells`], [`Error::NoProbe`], [`Error::Packing`].
pub fn volume(
    mesh: &Mesh,
    senders: &Senders,
    wanted: &VolumeParams,
    params: &Params,
    progress: &dyn Progress,
) -> Result<(Volume, Gathered, report::Volume)> {
    let mut volume = cells(mesh, wanted)?;
    let places: Vec<Vec3> = (0..volume.cells()).map(|cell| place(&volume, cell)).collect();
    let open = open_air(volume.count, &places, senders, params.gather.seed);
    volume.cell = (0..volume.cells()).filter(|&cell| open[cell]).map(|cell| cell as u32).collect();
    if volume.cell.is_empty() {
        return Err(Error::NoProbe { cells: volume.cells() });
    }
    volume.position = volume.cell.iter().map(|&cell| places[cell as usize].to_array()).collect();
    volume.probe = shown(&volume, senders.rays, &places);
    let (gathered, numbers) = pack(senders, &probe_receivers(&volume), &params.gather, params.gather_error, progress)?;
    let report = report::Volume {
        count: volume.count,
        spacing: volume.spacing,
        probes: volume.probes(),
        filled: volume.cells() - volume.probes(),
        gathered: numbers,
    };
    Ok((volume, gathered, report))
}

fn place(volume: &Volume, cell: usize) -> Vec3 {
    Vec3::from(volume.middle(cell)) + ASIDE * Vec3::from(volume.spacing)
}

/// The six receivers of every probe, as [`Volume::NORMALS`] has them.
pub fn probe_receivers(volume: &Volume) -> Vec<SurfacePoint> {
    let six = |position: &[f32; 3]| {
        let position = Vec3::from(*position);
        Volume::NORMALS.map(|normal| SurfacePoint { position, normal: normal.into(), triangle: NO_TRIANGLE })
    };
    volume.position.iter().flat_map(six).collect()
}

/// For every cell the probe whose light it shows: its own; one whose light leaves the solid that the place lies in by
/// the straight way; or any. Of those the one that is the fewest cells away.
fn shown(volume: &Volume, rays: &Rays, places: &[Vec3]) -> Vec<u32> {
    let mut probe = vec![NONE; volume.cells()];
    for (number, &cell) in volume.cell.iter().enumerate() {
        probe[cell as usize] = number as u32;
    }
    let of = |probe: u32| Vec3::from(volume.position[probe as usize]);
    spread(volume.count, &mut probe, |cell, _, probe| one_surface_at_most(rays, of(probe), places[cell]));
    spread(volume.count, &mut probe, |_, _, _| true);
    probe
}

fn one_surface_at_most(rays: &Rays, from: Vec3, to: Vec3) -> bool {
    let way = to - from;
    rays.closest(from, way, 1.0, NO_TRIANGLE).is_none_or(|hit| {
        let beyond = rays.off_surface(from + hit.t * way, way.normalize_or_zero());
        rays.visible(beyond, to, hit.triangle)
    })
}
