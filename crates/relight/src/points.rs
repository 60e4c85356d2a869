//! Light at given points: direct by rays, indirect by rows of weights over the patches.

use glam::{DVec3, Vec3};
use radfile::{Mesh, Patches, PointRows, Progress};
use rayon::prelude::*;
use scene::SurfacePoint;

use crate::{DirectLight, Frame, Samples, direct::loose_point};

/// Irradiance at points, W/m².
#[derive(Clone, Debug, PartialEq)]
pub struct PointLight {
    /// Without any bounce.
    pub direct: Vec<[f32; 3]>,
    /// After one and more bounces.
    pub indirect: Vec<[f32; 3]>,
}

/// Points in the axes of the scene file (metres, f64) as points of the mesh.
///
/// # Panics
///
/// If there are not as many normals as positions: a bug in the caller.
pub fn surface_points(mesh: &Mesh, position: &[[f64; 3]], normal: &[[f32; 3]]) -> Vec<SurfacePoint> {
    assert_eq!(position.len(), normal.len(), "one normal a point");
    let origin = DVec3::from(mesh.origin);
    let local = |p: &[f64; 3]| (DVec3::from(*p) - origin).as_vec3();
    position.iter().zip(normal).map(|(p, n)| loose_point(local(p), Vec3::from(*n).normalize_or_zero())).collect()
}

/// Radiosity ρ (H⁰ + H) of patches without emission, W/m²: what the last gather collects. Emitters are direct light.
///
/// # Panics
///
/// If the frame is of another number of patches: a bug in the caller.
pub fn radiosity(patches: &Patches, frame: &Frame) -> Vec<[f32; 3]> {
    assert!(frame.direct.len() == patches.len() && frame.indirect.len() == patches.len(), "one value a patch");
    let arriving = frame.direct.iter().zip(&frame.indirect);
    patches
        .reflectance
        .iter()
        .zip(arriving)
        .map(|(rho, (d, i))| std::array::from_fn(|c| rho[c] * (d[c] + i[c])))
        .collect()
}

/// Light at every point, by `rows` from the light of the patches.
///
/// Interpolated rows take the irradiance of the frame: as many bounces as it holds. Gathered ones add a bounce to it.
///
/// # Panics
///
/// If there are not as many rows as points, or the frame is of other patches: a bug in the caller.
pub fn light_at_points(
    direct: &DirectLight,
    points: &[SurfacePoint],
    rows: &PointRows,
    patches: &Patches,
    frame: &Frame,
    samples: &Samples,
    progress: &dyn Progress,
) -> PointLight {
    assert_eq!(rows.rows().len(), points.len(), "one row a point");
    progress.begin("direct light of points", points.len() as u64);
    let direct = points
        .par_iter()
        .enumerate()
        .map(|(i, point)| {
            let light = direct.irradiance(point, samples, i as u32);
            progress.advance(1);
            light.map(|e| e as f32)
        })
        .collect();
    let indirect = match rows {
        PointRows::Interpolated(rows) => rows.gather(&frame.indirect),
        PointRows::Gathered { rows, .. } => rows.gather(&radiosity(patches, frame)),
    };
    PointLight { direct, indirect }
}
