//! The last gather: form factors from points to the elements that they see, docs/theory.md (11.3).
//!
//! Patches are coarse, and light changes within them and from one to the next, most of all in corners. What a
//! point receives from far patches hardly feels that. So the last bounce is not interpolated between the
//! irradiances of patches nearby but gathered from the radiosities of all elements in view: rays leave the point
//! with density cos θ / π and are counted where they land. No wall, however thin, lets light through.
//!
//! What covers much of the view is told apart by elements, what is far by patches alone.
//!
//! Source: M. F. Cohen, J. R. Wallace, Radiosity and Realistic Image Synthesis, 1993, §8.4 (the final gather);
//! the rays are those of the form factors of patches.

use glam::Vec3;
use radfile::{Elements, GatherCertificate, Gathered, Patches, PointRows, Progress, Rows};
use rayon::prelude::*;
use scene::{Rays, Sobol, SurfacePoint, cosine_direction, hash, land};

use crate::{
    Result, report,
    rows::{Row, join},
};

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

/// A patch that fewer rays than this meet counts as a whole: they would say more of chance than of its elements.
const NEAR: u32 = 16;

/// A receiver of which less than this share of the rays meets anything lies inside of something.
const BURIED: f32 = 0.05;
/// Where less than this share meets front sides or the sky, it lies inside of a solid; back sides may have patches.
const FRONTS: f32 = 0.02;
/// Where at least this share does, it is in the open; if no more than some receivers are, the scene is inside out.
const OPEN: f32 = 0.75;
const WOUND: f32 = 0.1;

/// What light is gathered from.
#[derive(Clone, Copy)]
pub struct Senders<'a> {
    /// The patches of the scene.
    pub patches: &'a Patches,
    /// What they are parted into.
    pub elements: &'a Elements,
    /// Over all triangles of their mesh.
    pub rays: &'a Rays,
}

/// Bytes that [`gather_for_points`] takes at most.
pub fn gather_memory_needed(points: usize, senders: usize, params: &GatherParams) -> u64 {
    // A row as it is counted and, when all are joined, once more.
    let row = (senders as u64).min(u64::from(params.rays)) * 2 * 8 + 64;
    row.saturating_mul(points as u64)
}

/// Form factors of points; columns are the senders of a gather ([`Elements`]). The triangles that they lie on need not
/// be known ([`scene::NO_TRIANGLE`]).
///
/// # Panics
///
/// If elements and patches are not of the same number: a bug in the caller.
pub fn gather_for_points(
    senders: &Senders,
    points: &[SurfacePoint],
    params: &GatherParams,
    progress: &dyn Progress,
) -> PointRows {
    let FormFactors { rows, sky, .. } = form_factors(senders, points, params, progress);
    PointRows::Gathered { rows, sky }
}

/// The same, packed, and what came of it.
///
/// # Errors
///
/// [`crate::Error::Packing`]: an error that cannot be asked for, or no points.
///
/// # Panics
///
/// As [`gather_for_points`].
pub fn pack(
    senders: &Senders,
    points: &[SurfacePoint],
    params: &GatherParams,
    error: f64,
    progress: &dyn Progress,
) -> Result<(Gathered, report::Gathered)> {
    let FormFactors { rows, sky, fronts } = form_factors(senders, points, params, progress);
    let vectors = |f: fn(&SurfacePoint) -> [f32; 3]| points.iter().map(f).collect::<Vec<_>>();
    let (position, normal) = (vectors(|p| p.position.to_array()), vectors(|p| p.normal.to_array()));
    let receivers = hmatrix::Receivers { position: &position, normal: &normal };
    let (patches, elements) = (senders.patches, senders.elements);
    let normal_of_elements =
        (0..elements.patches()).flat_map(|patch| elements.of(patch).map(move |_| patches.normal[patch]));
    let columns = hmatrix::Senders {
        position: &[&patches.position[..], &middles(elements)].concat(),
        normal: &patches.normal.iter().copied().chain(normal_of_elements).collect::<Vec<_>>(),
        area: &[&patches.area[..], &elements.area].concat(),
        reflectance: &[&patches.reflectance[..], &elements.reflectance].concat(),
    };
    let source = hmatrix::sparse(&rows, &receivers)?;
    let (packed, numbers) =
        hmatrix::compress_rows(&receivers, &columns, &source, &hmatrix::Params::error(error), progress)?;
    let (l2_mean, vis99) = (numbers.l2_mean, numbers.vis99);
    let report = report::Gathered {
        elements: elements.len(),
        rays: params.rays,
        mean_row: rows.sender.len() as f64 / points.len().max(1) as f64,
        buried: buried(&rows, &sky, &fronts),
        bytes: packed.to_bytes().len(),
        bytes_per_receiver: packed.to_bytes().len() as f64 / points.len().max(1) as f64,
        error_wanted: error,
        l2_mean,
        vis99,
    };
    let certificate = GatherCertificate {
        senders: elements.senders() as u32,
        rays: params.rays,
        error_wanted: error,
        l2_mean,
        vis99,
    };
    Ok((Gathered { certificate, stream: packed.to_bytes().to_vec(), sky }, report))
}

/// Receivers inside of something, which no light enters: their rays hardly meet a patch or the sky, or only back sides.
///
/// Of a scene that is wound the wrong way all show their backs; there, these tell nothing.
fn buried(rows: &Rows, sky: &[f32], fronts: &[f32]) -> Vec<u32> {
    let wound = fronts.iter().filter(|&&f| f >= OPEN).count() as f32 >= WOUND * rows.len() as f32;
    let met = |r: usize| sky[r] + rows.row(r).map(|(_, share)| share).sum::<f32>();
    (0..rows.len()).filter(|&r| met(r) < BURIED || wound && fronts[r] < FRONTS).map(|r| r as u32).collect()
}

/// What points see, as shares of their views.
struct FormFactors {
    /// Patches and elements.
    rows: Rows,
    /// The sky.
    sky: Vec<f32>,
    /// Front sides and the sky.
    fronts: Vec<f32>,
}

/// The middle of the points of each element.
fn middles(elements: &Elements) -> Vec<[f32; 3]> {
    let middle = |range: &[u32]| {
        let points = &elements.point[range[0] as usize..range[1] as usize];
        (points.iter().map(|&p| Vec3::from(p)).sum::<Vec3>() / points.len() as f32).to_array()
    };
    elements.point_start.windows(2).map(middle).collect()
}

fn form_factors(
    senders: &Senders,
    points: &[SurfacePoint],
    params: &GatherParams,
    progress: &dyn Progress,
) -> FormFactors {
    assert_eq!(senders.elements.patches(), senders.patches.len(), "the elements of these patches");
    progress.begin("last gather", points.len() as u64);
    let gather = |counts: &mut Vec<u32>, (number, point): (usize, &SurfacePoint)| {
        let sobol = Sobol::new(hash(params.seed, number as u32));
        let seen = senders.seen_by(point, &sobol, params.rays, counts);
        progress.advance(1);
        seen
    };
    let seen = points.par_iter().enumerate().map_init(|| vec![0; senders.elements.len()], gather);
    let (rows, (sky, fronts)): (Vec<Row>, (Vec<f32>, Vec<f32>)) = seen.unzip();
    FormFactors { rows: join(rows), sky, fronts }
}

impl Senders<'_> {
    /// Sends the rays of one point; `counts` is zero before and after. Returns the shares of senders, and those of the sky
    /// and of fronts or the sky.
    fn seen_by(&self, point: &SurfacePoint, sobol: &Sobol, count: u32, counts: &mut [u32]) -> (Row, (f32, f32)) {
        let origin = self.rays.off_surface(point.position, point.normal);
        let (mut met, mut escaped, mut fronts) = (Vec::new(), 0, 0);
        for k in 0..count {
            let [u, v, ..] = sobol.sample(k);
            let direction = cosine_direction(point.normal, u, v);
            let Some(landing) = land(self.rays, &self.patches.locator, origin, direction, point.triangle) else {
                escaped += 1;
                continue;
            };
            // Faces with even numbers are front sides.
            fronts += u32::from(landing.face.is_multiple_of(2));
            let Some(patch) = landing.patch else { continue };
            let element = self.elements.at(patch as usize, landing.position.to_array());
            if counts[element as usize] == 0 {
                met.push((patch, element));
            }
            counts[element as usize] += 1;
        }
        let share = |hits: u32| hits as f32 / count.max(1) as f32;
        (Row { entries: self.entries(met, counts, share), ..Row::default() }, (share(escaped), share(escaped + fronts)))
    }

    /// Weights of the (patch, element) pairs that were met, far patches as a whole; takes the counts back to zero.
    fn entries(&self, mut met: Vec<(u32, u32)>, counts: &mut [u32], share: impl Fn(u32) -> f32) -> Vec<(u32, f32)> {
        met.sort_unstable();
        let (mut whole, mut parts) = (Vec::new(), Vec::new());
        let patches = self.patches.len() as u32;
        for group in met.chunk_by(|a, b| a.0 == b.0) {
            let patch = group[0].0;
            let hits: Vec<(u32, u32)> =
                group.iter().map(|&(_, e)| (e, std::mem::take(&mut counts[e as usize]))).collect();
            let all: u32 = hits.iter().map(|h| h.1).sum();
            if all < NEAR || self.elements.of(patch as usize).len() == 1 {
                whole.push((patch, share(all)));
            } else {
                parts.extend(hits.iter().map(|&(e, hits)| (patches + e, share(hits))));
            }
        }
        whole.append(&mut parts);
        whole
    }
}
