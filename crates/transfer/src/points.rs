//! Weights of any points on surfaces, by the same rule as those of the fine mesh.

use radfile::{Patches, Progress, Rows};
use rayon::prelude::*;
use scene::{Rays, SurfacePoint};

use crate::{
    Params,
    neighbours::Neighbours,
    rows::{Row, join},
};

/// One row a point: weights of the patches in its sight, or of the patch that it lies on, or none
/// if it lies on no surface. The points' triangles need not be known ([`scene::NO_TRIANGLE`]).
pub fn rows_for_points(
    patches: &Patches,
    rays: &Rays,
    points: &[SurfacePoint],
    params: &Params,
    progress: &dyn Progress,
) -> Rows {
    let neighbours = Neighbours::new(patches, rays, params.radius);
    progress.begin("weights", points.len() as u64);
    let row = |point: &SurfacePoint| -> Row {
        let own = || {
            let place = neighbours.sight.place(point.position, point.normal);
            let face = neighbours.sight.face_under(&place)?;
            patches.locator.patch_at(face, point.position.to_array())
        };
        let row = neighbours.row(point.position, point.normal, own);
        progress.advance(1);
        row
    };
    join(points.par_iter().map(row).collect())
}
