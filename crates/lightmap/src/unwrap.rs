//! An atlas for a mesh that brings none.
//!
//! The crate `uvunwrap` cuts the surface into charts, flattens and packs them. Charts also end where surfaces stand on
//! each other: light changes there at once, and a filter that mixed texels across the edge would blur it; where a wall
//! stands between two floors it would leak.

use std::sync::{Mutex, PoisonError};

use glam::DVec3;
use radfile::{Mesh, Progress};
use uvunwrap::{Density, MeshInput, Options, Packing, Stage};

use crate::{
    Atlas, Error, Result, Size,
    atlas::NO_CHART,
    coverage::count,
    edges::{edges, welded},
    flat::Flat,
    size::{check_extent, scale_for},
};

/// Cosine of 50°: triangles that face apart by less go on in each other, others stand on each other.
const GOES_ON: f64 = 0.643;
/// Widest ring around charts that is accepted.
const MOST_PADDING: u32 = 64;

/// How to unwrap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnwrapParams {
    /// Number of texels.
    pub size: Size,
    /// Texels around each chart that belong to it, 1 or more: charts are twice as many apart.
    pub padding: u32,
    /// Pack charts row by row: many times faster where there are thousands, and somewhat more texels stay empty.
    pub fast: bool,
}

impl Default for UnwrapParams {
    fn default() -> UnwrapParams {
        UnwrapParams { size: Size::Texels(256 * 256), padding: 2, fast: false }
    }
}

/// Unwraps a mesh. The same mesh and parameters give the same atlas, whatever the number of threads.
///
/// [`crate::memory_needed`] says what it takes.
///
/// # Errors
///
/// [`Error::Size`], [`Error::Padding`], [`Error::TooLarge`], [`Error::TooSmall`] if charts and padding do not fit.
pub fn unwrap(mesh: &Mesh, params: &UnwrapParams, progress: &dyn Progress) -> Result<Atlas> {
    params.size.check()?;
    if !(1..=MOST_PADDING).contains(&params.padding) {
        return Err(Error::Padding { found: params.padding, most: MOST_PADDING });
    }
    // Texture seams and creases of smooth shading say nothing about light.
    let (triangles, seams) = (welded(mesh), seams(mesh));
    let unwrapper = Unwrapper { mesh, triangles, seams, padding: params.padding, progress };
    let packing = if params.fast { Packing::Fast } else { Packing::Shape };
    let density = match params.size {
        Size::Width(width) => {
            return unwrapper.run(Density::Auto { page_size: width }, packing).map(|(atlas, _)| atlas);
        }
        Size::PerMetre(density) => f64::from(density),
        Size::Texels(wanted) => {
            let area: f64 = (0..mesh.triangles.len() as u32).map(|t| crate::area(mesh, t)).sum();
            let first = (f64::from(wanted) / area.max(f64::MIN_POSITIVE)).sqrt();
            // Charts do not depend on density, so one quick packing shows what each density gives.
            let (atlas, used) = unwrapper.run(fixed(first), Packing::Fast)?;
            let charts = charts(&atlas);
            used * scale_for(wanted, 1.0, |scale| count(&charts, scale))
        }
    };
    unwrapper.run(fixed(density), packing).map(|(atlas, _)| atlas)
}

fn fixed(density: f64) -> Density {
    let texels_per_unit = density.clamp(f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX)) as f32;
    Density::Fixed { texels_per_unit, page_size: None }
}

/// Triangles of each chart in texels, from the chart's lowest coordinates on.
fn charts(atlas: &Atlas) -> Vec<Vec<Flat>> {
    let mut charts: Vec<Vec<Flat>> = vec![Vec::new(); atlas.charts()];
    for (t, &chart) in (0u32..).zip(&atlas.chart).filter(|(_, c)| **c != NO_CHART) {
        charts[chart as usize].push(atlas.corners(t));
    }
    for triangles in &mut charts {
        let low = [0, 1].map(|k| triangles.iter().flatten().map(|p| p[k]).fold(f64::INFINITY, f64::min));
        triangles.iter_mut().flatten().for_each(|p| *p = [p[0] - low[0], p[1] - low[1]]);
    }
    charts
}

struct Unwrapper<'a> {
    mesh: &'a Mesh,
    /// Welded vertices.
    triangles: Vec<[u32; 3]>,
    seams: Vec<[bool; 3]>,
    padding: u32,
    progress: &'a dyn Progress,
}

impl Unwrapper<'_> {
    /// The atlas and its texels a metre.
    fn run(&self, density: Density, packing: Packing) -> Result<(Atlas, f64)> {
        let options = Options { density, padding: self.padding, packing, ..Options::default() };
        let indices = self.triangles.as_flattened();
        let input = MeshInput { seams: Some(&self.seams), ..MeshInput::new(&self.mesh.positions, indices) };
        let teller = Teller { progress: self.progress, told: Mutex::new(None) };
        let unwrapped = uvunwrap::generate_with_progress(&[input], &options, |p| {
            teller.tell(p);
            true
        });
        let unwrapped = unwrapped.map_err(|e| self.refusal(e))?;
        check_extent(f64::from(unwrapped.width), f64::from(unwrapped.height))?;
        if unwrapped.page_count > 1 {
            return Err(self.too_small(unwrapped.chart_count, unwrapped.width));
        }
        let out = &unwrapped.meshes[0];
        let vertices = |t: &[u32; 3]| t.map(|v| out.vertices[v as usize]);
        let triangles: Vec<_> = out.indices.as_chunks::<3>().0.iter().map(vertices).collect();
        let atlas = Atlas {
            // A mesh of triangles without area has no texels; one stands for it.
            width: unwrapped.width.max(1),
            height: unwrapped.height.max(1),
            corner_uv: triangles.iter().map(|t| t.map(|v| v.uv)).collect(),
            chart: triangles.iter().map(|t| t[0].chart.unwrap_or(NO_CHART)).collect(),
            padding: self.padding,
        };
        Ok((atlas, f64::from(unwrapped.texels_per_unit)))
    }

    fn too_small(&self, charts: u32, width: u32) -> Error {
        Error::TooSmall { charts, width, padding: self.padding }
    }

    fn refusal(&self, error: uvunwrap::Error) -> Error {
        match error {
            uvunwrap::Error::AtlasTooLarge { texels } => {
                let edge = (texels as f64).sqrt().ceil() as u64;
                Error::TooLarge { width: edge, height: edge }
            }
            uvunwrap::Error::ChartTooLarge { page_size, .. } => self.too_small(1, page_size),
            uvunwrap::Error::InvalidOption { option: "density.page_size", .. } => {
                Error::Padding { found: self.padding, most: MOST_PADDING }
            }
            other => Error::Unwrap(other),
        }
    }
}

/// Passes on how far the unwrapper is.
struct Teller<'a> {
    progress: &'a dyn Progress,
    /// The stage that was told last, and how much of it.
    told: Mutex<Option<(Stage, usize)>>,
}

impl Teller<'_> {
    fn tell(&self, p: uvunwrap::Progress) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        let before = told.filter(|(stage, _)| *stage == p.stage).map(|(_, done)| done);
        if before.is_none() {
            let what = match p.stage {
                Stage::Segmenting => "charts of the lightmap",
                Stage::Parameterizing => "unwrapping",
                _ => "packing the lightmap",
            };
            self.progress.begin(what, p.total.unwrap_or(0) as u64);
        }
        self.progress.advance((p.done - before.unwrap_or(0)) as u64);
        *told = Some((p.stage, p.done));
    }
}

/// For every triangle the edges at which it stands on another.
fn seams(mesh: &Mesh) -> Vec<[bool; 3]> {
    let normals: Vec<DVec3> =
        (0..mesh.triangles.len() as u32).map(|t| crate::cross(mesh, t).normalize_or_zero()).collect();
    let mut seams = vec![[false; 3]; mesh.triangles.len()];
    for edge in edges(mesh).chunk_by(|a, b| a.ends == b.ends) {
        // Facing the same way or the opposite one: sheets are often doubled.
        let stands = |a: DVec3, b: DVec3| a.dot(b).abs() < GOES_ON && a != DVec3::ZERO && b != DVec3::ZERO;
        let first = normals[edge[0].triangle as usize];
        if edge.iter().any(|e| stands(first, normals[e.triangle as usize])) {
            edge.iter().for_each(|e| seams[e.triangle as usize][e.corner as usize] = true);
        }
    }
    seams
}
