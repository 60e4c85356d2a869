//! Parts patches into elements: what the last gather tells apart of a sender.
//!
//! Rays between patches land where light comes from; there a patch is looked at, and nowhere else: much of what a voxel
//! holds may be hidden within it. A cubic grid of about half a patch's extent parts each patch. How much of it is seen
//! in a cell, what it reflects there, and points at which its direct light is looked up come from where rays landed.
//! Rays are as many as the area that they leave, so that by reciprocity they land evenly on all that is seen. Nothing
//! is clipped.

use std::collections::BTreeMap;

use glam::Vec3;
use radfile::{CellKey, Elements, Patches, Progress};
use rayon::prelude::*;
use scene::{Landing, PatchSampler, Rays, Sobol, Surfaces, cosine_direction, hash, land};

/// Rays for each patch, on average.
const RAYS: f64 = 512.0;
/// The fewest and the most of a patch.
const RAYS_OF_A_PATCH: (f64, f64) = (16.0, 65536.0);
/// A patch that fewer rays landed on is looked at everywhere instead.
const FEWEST_LANDINGS: usize = 16;
/// Points that such a patch is looked at.
const DRAWN: u32 = 64;
/// A part of less than this share of its patch is no element; a quarter is usual.
const SMALLEST_SHARE: f64 = 1.0 / 32.0;
/// Largest f32 below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;
/// Points at which the direct light of an element is looked up.
const POINTS: usize = 8;

/// The elements of one patch.
struct Parted {
    elements: Vec<Part>,
    /// Cells with the number of their element.
    cells: Vec<(u64, u32)>,
}

/// An element.
struct Part {
    area: f32,
    reflectance: [f32; 3],
    points: Vec<Landing>,
}

/// Parts every patch into about four elements, those that are smaller than a quarter of a voxel's face not at all.
pub fn subdivide(patches: &Patches, surfaces: &Surfaces, rays: &Rays, progress: &dyn Progress) -> Elements {
    let landings = landings(patches, rays, progress);
    let edges: Vec<f32> = patches.area.iter().map(|&area| edge(patches.locator.cell_size, area)).collect();
    let parted: Vec<Parted> =
        (0..patches.len()).into_par_iter().map(|p| part(patches, surfaces, p, edges[p], &landings[p])).collect();
    let mut all = Elements {
        start: vec![0],
        grid_origin: patches.locator.grid_origin,
        edge: edges,
        cell_start: vec![0],
        point_start: vec![0],
        ..Elements::default()
    };
    for Parted { elements, cells } in parted {
        let first = all.len() as u32;
        all.cell_key.extend(cells.iter().map(|c| c.0));
        all.cell_element.extend(cells.iter().map(|c| first + c.1));
        all.cell_start.push(all.cell_key.len() as u32);
        for element in elements {
            all.area.push(element.area);
            all.reflectance.push(element.reflectance);
            all.point.extend(element.points.iter().map(|p| p.position.to_array()));
            all.point_face.extend(element.points.iter().map(|p| p.face));
            all.point_start.push(all.point.len() as u32);
        }
        all.start.push(all.len() as u32);
    }
    all
}

/// Edge of the cells that part a patch: half its extent, by powers of two from the voxel, which it need not be cut
/// finer than in half.
fn edge(voxel: f32, area: f32) -> f32 {
    let levels = (area.sqrt() / voxel).log2().round().max(0.0);
    0.5 * voxel * levels.exp2()
}

/// Where rays from all patches land on each; a patch that is hardly met is drawn on instead.
fn landings(patches: &Patches, rays: &Rays, progress: &dyn Progress) -> Vec<Vec<Landing>> {
    progress.begin("elements", patches.len() as u64);
    let sampler = PatchSampler::new(patches);
    let total: f64 = patches.area.iter().map(|&a| f64::from(a)).sum();
    let per_area = RAYS * patches.len() as f64 / total;
    let from = |patch: usize| {
        let (fewest, most) = RAYS_OF_A_PATCH;
        let count = (per_area * f64::from(patches.area[patch])).clamp(fewest, most) as u32;
        let sobol = Sobol::new(hash(0xe1e3, patch as u32));
        let landing = |k: u32| {
            let [x, y, u, v] = sobol.sample(k);
            let point = sampler.point(patch, x, y);
            let origin = rays.off_surface(point.position, point.normal);
            let direction = cosine_direction(point.normal, u, v);
            land(rays, &patches.locator, origin, direction, point.triangle)
        };
        progress.advance(1);
        (0..count).filter_map(landing).collect::<Vec<_>>()
    };
    let all: Vec<Vec<Landing>> = (0..patches.len()).into_par_iter().map(from).collect();
    let mut on: Vec<Vec<Landing>> = vec![Vec::new(); patches.len()];
    for landing in all.into_iter().flatten() {
        if let Some(patch) = landing.patch {
            on[patch as usize].push(landing);
        }
    }
    for (patch, landings) in on.iter_mut().enumerate().filter(|(_, l)| l.len() < FEWEST_LANDINGS) {
        let sobol = Sobol::new(hash(0xd2a1, patch as u32));
        let draw = |k: u32| {
            let [x, y, ..] = sobol.sample(k);
            let point = sampler.point(patch, x, y);
            Landing {
                position: point.position,
                face: face_on(patches, patch, point.triangle),
                patch: Some(patch as u32),
            }
        };
        *landings = (0..DRAWN).map(draw).collect();
    }
    on
}

/// The face of a patch's pieces that is a side of `triangle`.
fn face_on(patches: &Patches, patch: usize, triangle: u32) -> u32 {
    let own = patches.pieces_of(patch).iter().map(|p| p.face);
    own.into_iter().find(|face| face / 2 == triangle).unwrap_or(2 * triangle)
}

fn part(patches: &Patches, surfaces: &Surfaces, patch: usize, edge: f32, landings: &[Landing]) -> Parted {
    let origin = patches.locator.grid_origin;
    let mut cells: BTreeMap<u64, Vec<Landing>> = BTreeMap::new();
    for landing in landings {
        cells.entry(CellKey::of(origin, edge, landing.position.to_array()).0).or_default().push(*landing);
    }
    // A patch of many small parts far from each other has no cell with that share; the fullest is large in any case.
    let fullest = cells.values().map(Vec::len).max().unwrap_or(0);
    let large = (SMALLEST_SHARE * landings.len() as f64).min(fullest as f64);
    let is_large = |cell: &Vec<Landing>| cell.len() as f64 >= large;
    let middles: Vec<Vec3> = cells.values().filter(|c| is_large(c)).map(|c| middle(c)).collect();
    let mut groups: Vec<Vec<Landing>> = vec![Vec::new(); middles.len()];
    let (mut numbered, mut next) = (Vec::new(), 0);
    for (key, cell) in &cells {
        let number = if is_large(cell) {
            next += 1;
            next - 1
        } else {
            nearest(&middles, middle(cell))
        };
        groups[number].extend(cell);
        numbered.push((*key, number as u32));
    }
    let share = |group: &Vec<Landing>| patches.area[patch] * group.len() as f32 / landings.len() as f32;
    // Surfaces say how the parts of a patch differ, the patch how much all of it reflects.
    let (mean, rho) = (reflectance(surfaces, landings), patches.reflectance[patch]);
    let scaled = |own: [f32; 3], c: usize| if mean[c] > 0.0 { rho[c] * own[c] / mean[c] } else { rho[c] };
    let element = |group: Vec<Landing>| {
        let own = reflectance(surfaces, &group);
        let reflectance = std::array::from_fn(|c| scaled(own, c).clamp(0.0, BELOW_ONE));
        Part { area: share(&group), reflectance, points: spread(group) }
    };
    let elements: Vec<Part> = groups.into_iter().map(element).collect();
    let cells = if elements.len() < 2 { vec![] } else { numbered };
    Parted { elements, cells }
}

fn middle(cell: &[Landing]) -> Vec3 {
    cell.iter().map(|l| l.position).sum::<Vec3>() / cell.len() as f32
}

fn nearest(middles: &[Vec3], point: Vec3) -> usize {
    let distance = |i: usize| middles[i].distance_squared(point);
    (0..middles.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
}

fn reflectance(surfaces: &Surfaces, group: &[Landing]) -> [f32; 3] {
    let mut sum = [0.0f64; 3];
    for landing in group {
        let (u, v) = surfaces.weights_at(landing.face / 2, landing.position);
        let rho = surfaces.reflectance(landing.face / 2, u, v);
        sum = std::array::from_fn(|c| sum[c] + f64::from(rho[c]));
    }
    sum.map(|s| (s / group.len() as f64) as f32)
}

/// Some of the landings, evenly over the element: every so many along a space-filling curve (G. M. Morton, 1966).
fn spread(mut group: Vec<Landing>) -> Vec<Landing> {
    let fold = |f: fn(Vec3, Vec3) -> Vec3| group.iter().map(|l| l.position).reduce(f).unwrap_or_default();
    let (low, high) = (fold(Vec3::min), fold(Vec3::max));
    let scale = 255.0 / (high - low).max_element().max(f32::MIN_POSITIVE);
    let code = |l: &Landing| {
        let cell = ((l.position - low) * scale).to_array().map(|x| x as u32);
        (0..8).map(|bit| (0..3).map(|a| (cell[a] >> bit & 1) << (3 * bit + a)).sum::<u32>()).sum::<u32>()
    };
    group.sort_by_cached_key(code);
    let count = POINTS.min(group.len());
    (0..count).map(|k| group[(2 * k + 1) * group.len() / (2 * count)]).collect()
}
