//! The lightmap coordinates that a scene file brings: its second set, if it is fit for a lightmap.
//!
//! A second set may as well belong to a texture that repeats, or be shared by instances that lie in different light. So
//! it must stay inside the texture, give all surface a place, and give no place to two.

use radfile::Mesh;

use crate::{
    Atlas, Error, Result, Size,
    atlas::charts_of,
    coverage::{count, touch},
    flat::{Flat, nearest, signed_area},
    size::{check_extent, scale_for},
};

/// How far coordinates may lie outside of 0 to 1; they are brought back.
const OUTSIDE: f32 = 1e-3;
/// Part of the surface that may have no place.
const PLACELESS: f64 = 1e-3;
/// Part of the texels that two triangles may cover.
const TWICE: f64 = 2e-3;
/// A texel's centre is inside a triangle if its barycentric weights are above this; on a common edge it is in neither.
const INSIDE: f64 = 1e-6;
/// Texels around each chart that belong to it: authors leave that many.
const PADDING: u32 = 2;

impl Atlas {
    /// The atlas of the mesh's own lightmap coordinates, as a square.
    ///
    /// # Errors
    ///
    /// [`Error::NoCoordinates`] if there are none, [`Error::Unusable`] if they are no lightmap's: outside of 0 to 1, two
    /// triangles over one texel, surface without a place; [`Error::Size`], [`Error::TooLarge`].
    pub fn from_mesh(mesh: &Mesh, size: Size) -> Result<Atlas> {
        size.check()?;
        if mesh.lightmap_uv.is_empty() {
            return Err(Error::NoCoordinates);
        }
        let legal = |uv: &[f32; 2]| uv.iter().all(|x| (-OUTSIDE..=1.0 + OUTSIDE).contains(x));
        if let Some(v) = mesh.lightmap_uv.iter().position(|uv| !legal(uv)) {
            return Err(unusable(format!("vertex {v} lies at {:?}, expected 0 to 1", mesh.lightmap_uv[v])));
        }
        let corner = |&v: &u32| mesh.lightmap_uv[v as usize].map(|x| x.clamp(0.0, 1.0));
        let corner_uv: Vec<[[f32; 2]; 3]> = mesh.triangles.iter().map(|t| t.each_ref().map(corner)).collect();
        let unit: Vec<Flat> = corner_uv.iter().map(|c| c.map(|uv| uv.map(f64::from))).collect();
        let areas = areas(mesh, &unit)?;
        let edge = match size {
            Size::Width(width) => f64::from(width),
            Size::PerMetre(density) => (f64::from(density) * (areas[0] / areas[1]).sqrt()).ceil(),
            Size::Texels(wanted) => {
                let whole = [unit.clone()];
                scale_for(wanted, (f64::from(wanted) / areas[1]).sqrt(), |edge| count(&whole, edge)).round().max(1.0)
            }
        };
        check_extent(edge, edge)?;
        let chart = charts_of(&corner_uv);
        let atlas = Atlas { width: edge as u32, height: edge as u32, corner_uv, chart, padding: PADDING };
        check_overlap(&atlas)?;
        Ok(atlas)
    }
}

/// Area of the surface in m² and of its coordinates, if these fit into the texture at all.
fn areas(mesh: &Mesh, unit: &[Flat]) -> Result<[f64; 2]> {
    let (mut surface, mut flat, mut placeless) = (0.0, 0.0, 0.0);
    for (t, corners) in unit.iter().enumerate() {
        let (area, place) = (crate::area(mesh, t as u32), signed_area(*corners).abs());
        (surface, flat) = (surface + area, flat + place);
        placeless += if place > 0.0 { 0.0 } else { area };
    }
    if placeless > PLACELESS * surface || flat <= 0.0 {
        let share = 100.0 * placeless / surface;
        return Err(unusable(format!("{share:.1} % of the surface has no area in it, expected all to have a place")));
    }
    if flat > 1.0 + TWICE {
        return Err(unusable(format!("its triangles have {flat:.2} times the area of the texture, so some overlap")));
    }
    Ok([surface, flat])
}

/// Refuses an atlas in which triangles lie on each other.
fn check_overlap(atlas: &Atlas) -> Result<()> {
    let mut times = vec![0u8; (atlas.width * atlas.height) as usize];
    for t in 0..atlas.corner_uv.len() as u32 {
        let corners = atlas.corners(t);
        touch(corners, [atlas.width, atlas.height], |[x, y], _| {
            let (weights, _) = nearest(corners, [f64::from(x) + 0.5, f64::from(y) + 0.5]);
            if weights.iter().all(|w| *w > INSIDE) {
                let times = &mut times[(y * atlas.width + x) as usize];
                *times = times.saturating_add(1);
            }
        });
    }
    let at_least = |n: u8| times.iter().filter(|t| **t >= n).count();
    let (once, twice) = (at_least(1), at_least(2));
    if twice as f64 > TWICE * once as f64 {
        let what = format!("{twice} of {once} texels are covered by several triangles, expected one each");
        return Err(unusable(what));
    }
    Ok(())
}

fn unusable(what: String) -> Error {
    Error::Unusable { what }
}
