//! The receivers of a lightmap, and what they gather.
//!
//! Texels are placed by the crate `lightmap`: by the coordinates that the scene file brings where those are a
//! lightmap's, otherwise unwrapped.

use glam::Vec3;
use lightmap::{Atlas, Size, UnwrapParams, texels, unwrap};
use radfile::{Gathered, Lightmap, Mesh, Progress};
use scene::SurfacePoint;

use crate::{Params, Result, Senders, gather::pack, report};

/// How large a lightmap is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightmapParams {
    /// About how many texels touch the mesh.
    pub texels: u32,
    /// Texels around each chart that belong to it, 1 or more; only where the mesh is unwrapped.
    pub padding: u32,
}

impl Default for LightmapParams {
    fn default() -> LightmapParams {
        LightmapParams { texels: 256 * 256, padding: UnwrapParams::default().padding }
    }
}

/// A mesh of more triangles is packed row by row: fitting thousands of charts into each other takes minutes.
const MANY_TRIANGLES: usize = 20_000;

/// Places the receivers of a lightmap and packs their form factors.
///
/// # Errors
///
/// [`crate::Error::Lightmap`], [`crate::Error::Packing`].
pub fn lightmap(
    mesh: &Mesh,
    senders: &Senders,
    size: &LightmapParams,
    params: &Params,
    progress: &dyn Progress,
) -> Result<(Lightmap, Gathered, report::Lightmap)> {
    let (atlas, coordinates) = atlas(mesh, size, progress)?;
    let (lightmap, placed) = texels(mesh, &atlas, senders.rays, progress);
    let point = |r: usize| SurfacePoint {
        position: Vec3::from(lightmap.position[r]),
        normal: Vec3::from(lightmap.normal[r]),
        triangle: lightmap.triangle[r],
    };
    let points: Vec<SurfacePoint> = (0..lightmap.receivers()).map(point).collect();
    let (gathered, numbers) = pack(senders, &points, &params.gather, params.gather_error, progress)?;
    Ok((lightmap, gathered, report::Lightmap { coordinates, placed, gathered: numbers }))
}

/// The scene's own coordinates where they are usable; says which were taken.
fn atlas(mesh: &Mesh, size: &LightmapParams, progress: &dyn Progress) -> Result<(Atlas, String)> {
    let why = match Atlas::from_mesh(mesh, Size::Texels(size.texels)) {
        Ok(atlas) => return Ok((atlas, "those of the scene file".into())),
        Err(lightmap::Error::NoCoordinates) => String::new(),
        Err(lightmap::Error::Unusable { what }) => format!("; those of the scene file are no lightmap's: {what}"),
        Err(other) => return Err(other.into()),
    };
    let fast = mesh.triangles.len() > MANY_TRIANGLES;
    let params = UnwrapParams { size: Size::Texels(size.texels), padding: size.padding, fast };
    Ok((unwrap(mesh, &params, progress)?, format!("unwrapped{why}")))
}
