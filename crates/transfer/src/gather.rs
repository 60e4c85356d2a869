//! The last gather: form factors from points to the patches that they see, docs/theory.md (11.3).
//!
//! Patches are coarse, and light changes within them and from one to the next, most of all in corners. What a
//! point receives from far patches hardly feels that. So the last bounce is not interpolated between the
//! irradiances of patches nearby but gathered from the radiosities of all patches in view: rays leave the point
//! with density cos θ / π and are counted where they land. No wall, however thin, lets light through.
//!
//! Source: M. F. Cohen, J. R. Wallace, Radiosity and Realistic Image Synthesis, 1993, §8.4 (the final gather);
//! the rays are those of the form factors of patches.

use radfile::{Patches, PointRows, Progress, face_id};
use rayon::prelude::*;
use scene::{Rays, Sobol, SurfacePoint, cosine_direction, hash};

use crate::senders::{Row, join};

/// How the last gather is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GatherParams {
    /// Rays a point; powers of two are stratified best.
    pub rays: u32,
    /// Scrambles the rays.
    pub seed: u32,
}

impl Default for GatherParams {
    fn default() -> GatherParams {
        GatherParams { rays: 8192, seed: 1 }
    }
}

/// Bytes that [`gather_for_points`] takes at most.
pub fn gather_memory_needed(points: usize, patches: usize, params: &GatherParams) -> u64 {
    // A row as it is counted and, when all are joined, once more.
    let row = (patches as u64).min(u64::from(params.rays)) * 2 * 8 + 64;
    row.saturating_mul(points as u64)
}

/// Form factors of points on surfaces. The points' triangles need not be known ([`scene::NO_TRIANGLE`]).
pub fn gather_for_points(
    patches: &Patches,
    rays: &Rays,
    points: &[SurfacePoint],
    params: &GatherParams,
    progress: &dyn Progress,
) -> PointRows {
    progress.begin("last gather", points.len() as u64);
    let gather = |counts: &mut Vec<u32>, (number, point): (usize, &SurfacePoint)| {
        let sobol = Sobol::new(hash(params.seed, number as u32));
        let seen = look(patches, rays, point, &sobol, params.rays, counts);
        progress.advance(1);
        seen
    };
    let seen = points.par_iter().enumerate().map_init(|| vec![0; patches.len()], gather);
    let (rows, sky): (Vec<Row>, Vec<f32>) = seen.unzip();
    PointRows::Gathered { rows: join(rows), sky }
}

/// Sends the rays of one point; `counts` is zero before and after.
fn look(
    patches: &Patches,
    rays: &Rays,
    point: &SurfacePoint,
    sobol: &Sobol,
    count: u32,
    counts: &mut [u32],
) -> (Row, f32) {
    let origin = rays.off_surface(point.position, point.normal);
    let (mut met, mut escaped) = (Vec::new(), 0);
    for k in 0..count {
        let [u, v, ..] = sobol.sample(k);
        let direction = cosine_direction(point.normal, u, v);
        let Some(hit) = rays.closest(origin, direction, f32::INFINITY, point.triangle) else {
            escaped += 1;
            continue;
        };
        let place = (origin + hit.t * direction).to_array();
        let Some(patch) = patches.locator.patch_at(face_id(hit.triangle, hit.side), place) else { continue };
        if counts[patch as usize] == 0 {
            met.push(patch);
        }
        counts[patch as usize] += 1;
    }
    met.sort_unstable();
    let share = |hits: u32| hits as f32 / count.max(1) as f32;
    let entries = met.into_iter().map(|p| (p, share(std::mem::take(&mut counts[p as usize])))).collect();
    (Row { entries, fallback: false, widened: false }, share(escaped))
}
