//! Sheets to patches: one for each side that is used, and the locator that finds them again.

use glam::{DVec3, Vec3};
use radfile::{CUT, Cut, PatchLocator, Patches, Piece, Side, face_id};
use rayon::prelude::*;

use crate::{
    clip::{Clip, Clips},
    draft::{Coat, Draft},
    grid::Grid,
    group::Sheets,
    merge::Merged,
    surface::{Surface, turn},
    tree::{Child, Node},
};

/// A patch smaller than this part of a voxel's side is no patch.
const LEAST_PATCH: f64 = 1e-9;

/// One side of a sheet on its way to a patch.
struct Patch {
    area: f64,
    normal: DVec3,
    position: DVec3,
    pieces: Vec<Piece>,
}

/// Makes the patches of all sheets, in the order of cells, `+` before `−`.
pub fn assemble(surface: &Surface, grid: &Grid, clips: &Clips, sheets: &Sheets, merged: &Merged) -> Draft {
    let mut members: Vec<(u32, u32, bool)> = (0..)
        .zip(&sheets.of_clip)
        .map(|(clip, &(sheet, turned))| {
            let (root, root_turned) = merged.into[sheet as usize];
            (root, clip, turned ^ root_turned)
        })
        .collect();
    members.par_sort_unstable();
    let runs: Vec<&[(u32, u32, bool)]> = members.chunk_by(|a, b| a.0 == b.0).collect();
    let sides: Vec<[Option<Patch>; 2]> =
        runs.par_iter().map(|run| [Side::Front, Side::Back].map(|side| one_side(surface, clips, run, side))).collect();

    let least = LEAST_PATCH * grid.size * grid.size;
    let mut patches = Patches { piece_start: vec![0], ..Patches::default() };
    let mut sliver_area = clips.lost_area * if surface.scene.mesh.one_sided { 1.0 } else { 2.0 };
    let mut patch_of_sheet = vec![[None; 2]; sheets.sheets.len()];
    for (run, sides) in runs.iter().zip(sides) {
        for (side, patch) in sides.into_iter().enumerate() {
            let Some(patch) = patch else { continue };
            if patch.area < least || patch.pieces.is_empty() {
                sliver_area += patch.area;
                continue;
            }
            patch_of_sheet[run[0].0 as usize][side] = Some(patches.area.len() as u32);
            push(&mut patches, patch);
        }
    }
    patches.locator = locate(surface, grid, clips, |clip, side| {
        let (sheet, turned) = sheets.of_clip[clip];
        let (root, root_turned) = merged.into[sheet as usize];
        patch_of_sheet[root as usize][turn(side, turned ^ root_turned) as usize]
    });
    let weighed = patches.pieces.iter().map(|&p| (p, piece_area(&p)));
    let coat = Coat { start: patches.piece_start.clone(), parts: weighed.collect() };
    let touches = touches(sheets, merged, &patch_of_sheet);
    Draft { patches, coat, touches, cells: sheets.cells, pieces: clips.clips.len(), merged: merged.count, sliver_area }
}

/// Patches that touch, on either side of the sheets that do.
fn touches(sheets: &Sheets, merged: &Merged, patch_of_sheet: &[[Option<u32>; 2]]) -> Vec<[u32; 2]> {
    let mut touches = Vec::new();
    for touch in &sheets.touches {
        let [(a, a_turned), (b, b_turned)] = [touch.a, touch.b].map(|sheet| merged.into[sheet as usize]);
        for side in [Side::Front, Side::Back] {
            let here = patch_of_sheet[a as usize][turn(side, a_turned) as usize];
            let there = patch_of_sheet[b as usize][turn(side, b_turned ^ touch.turned) as usize];
            touches.extend(here.zip(there).filter(|(a, b)| a != b).map(|(a, b)| [a.min(b), a.max(b)]));
        }
    }
    touches.sort_unstable();
    touches.dedup();
    touches
}

fn push(patches: &mut Patches, patch: Patch) {
    patches.position.push(patch.position.as_vec3().to_array());
    patches.normal.push(patch.normal.as_vec3().to_array());
    patches.area.push(patch.area as f32);
    patches.reflectance.push([0.0; 3]);
    patches.emission.push([0.0; 3]);
    patches.pieces.extend(patch.pieces);
    patches.piece_start.push(patches.pieces.len() as u32);
}

/// The patch on one side of a sheet, `None` if no piece has a used face there.
fn one_side(surface: &Surface, clips: &Clips, members: &[(u32, u32, bool)], sheet_side: Side) -> Option<Patch> {
    let mut patch = Patch { area: 0.0, normal: DVec3::ZERO, position: DVec3::ZERO, pieces: Vec::new() };
    let mut largest = (0.0, DVec3::ZERO);
    let mut moment = DVec3::ZERO;
    for &(_, clip, turned) in members {
        let clip = &clips.clips[clip as usize];
        let side = turn(sheet_side, turned);
        if !surface.uses(side) {
            continue;
        }
        let front = surface.normal[clip.triangle as usize];
        let normal = if side == Side::Front { front } else { -front };
        patch.area += clip.area;
        patch.normal += clip.area * normal;
        moment += clip.area * centroid(clip);
        if clip.area > largest.0 {
            largest = (clip.area, normal);
        }
        patch.pieces.extend(fan(clip, side).filter(|p| is_sound(p, front)));
    }
    if patch.area == 0.0 {
        return None;
    }
    patch.normal = patch.normal.try_normalize().unwrap_or(largest.1);
    patch.position = nearest(&patch.pieces, moment / patch.area);
    Some(patch)
}

/// The triangles of a polygon, in its winding.
pub fn fan(clip: &Clip, side: Side) -> impl Iterator<Item = Piece> + '_ {
    let face = face_id(clip.triangle, side);
    let corner = |i: usize| clip.corners[i].point.as_vec3().to_array();
    (1..clip.corners.len() - 1).map(move |i| Piece { corners: [corner(0), corner(i), corner(i + 1)], face })
}

/// Whether a piece is still a triangle with its normal after rounding to f32, so that points can be drawn on it.
pub fn is_sound(piece: &Piece, front: DVec3) -> bool {
    let [a, b, c] = piece.corners.map(Vec3::from);
    (b - a).cross(c - a).normalize_or_zero().as_dvec3().dot(front) > 0.5
}

/// Area of a piece, m².
pub fn piece_area(piece: &Piece) -> f32 {
    let [a, b, c] = piece.corners.map(Vec3::from);
    0.5 * (b - a).cross(c - a).length()
}

/// Centre of gravity of a polygon.
fn centroid(clip: &Clip) -> DVec3 {
    let origin = clip.corners[0].point;
    let (mut moment, mut weight) = (DVec3::ZERO, 0.0);
    for pair in clip.corners[1..].windows(2) {
        let (a, b) = (pair[0].point - origin, pair[1].point - origin);
        let double_area = a.cross(b).length();
        moment += double_area / 3.0 * (a + b);
        weight += double_area;
    }
    if weight > 0.0 { origin + moment / weight } else { origin }
}

/// The point of the pieces that is nearest to `target`.
pub fn nearest(pieces: &[Piece], target: DVec3) -> DVec3 {
    let points = pieces.iter().map(|p| nearest_on_triangle(p.corners.map(|c| Vec3::from(c).as_dvec3()), target));
    points.min_by(|p, q| p.distance_squared(target).total_cmp(&q.distance_squared(target))).unwrap_or(target)
}

/// The point of a triangle that is nearest to `p`: its projection, or the nearest point of the edges.
fn nearest_on_triangle([a, b, c]: [DVec3; 3], p: DVec3) -> DVec3 {
    let normal = (b - a).cross(c - a);
    let inside = |q: DVec3, r: DVec3| (r - q).cross(p - q).dot(normal) >= 0.0;
    if normal != DVec3::ZERO && inside(a, b) && inside(b, c) && inside(c, a) {
        return p - (p - a).dot(normal) / normal.length_squared() * normal;
    }
    let on_edge = |q: DVec3, r: DVec3| {
        let along = r - q;
        q + ((p - q).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0) * along
    };
    let candidates = [on_edge(a, b), on_edge(b, c), on_edge(c, a)];
    candidates.into_iter().min_by(|q, r| q.distance_squared(p).total_cmp(&r.distance_squared(p))).unwrap_or(a)
}

/// The table of (face, cell) → patch; `patch_of` says which patch a side of a clipped piece is in.
pub fn locate(
    surface: &Surface,
    grid: &Grid,
    clips: &Clips,
    patch_of: impl Fn(usize, Side) -> Option<u32>,
) -> PatchLocator {
    let mut locator = PatchLocator {
        grid_origin: grid.origin.as_vec3().to_array(),
        cell_size: grid.size as f32,
        face_start: vec![0],
        ..PatchLocator::default()
    };
    for triangle in 0..surface.carrier.len() {
        let carrier = surface.carrier[triangle] as usize;
        for side in [Side::Front, Side::Back] {
            if surface.uses(side) {
                let side = turn(side, surface.turned[triangle]);
                let (own, mut first) = (clips.of_triangle[carrier].clone(), clips.of_triangle[carrier].start);
                while first < own.end {
                    let clip = &clips.clips[first as usize];
                    let parts = clips.pieces_of(clip.triangle, clip.cell);
                    let patches = parts.clone().map(|part| patch_of(part as usize, side));
                    let nodes = clip.cutting.map_or(&[][..], |number| &clips.cuttings[number as usize].nodes);
                    if let Some(entry) = plant(&mut locator.cuts, nodes, &patches.collect::<Vec<_>>()) {
                        locator.cell_key.push(clip.cell.0);
                        locator.cell_patch.push(entry);
                    }
                    first = parts.end;
                }
            }
            locator.face_start.push(locator.cell_key.len() as u32);
        }
    }
    locator
}

/// Adds the tree of a piece that was cut, whose leaves have these patches, and returns the locator's entry for it.
///
/// A leaf without a patch leaves its place to the other side of the nearest cut.
fn plant(cuts: &mut Vec<Cut>, nodes: &[Node], patches: &[Option<u32>]) -> Option<u32> {
    if nodes.is_empty() {
        return patches[0];
    }
    let first = cuts.len() as u32;
    let entry = |child: Child| match child {
        Child::Leaf(leaf) => leaf,
        Child::Node(node) => CUT | node,
    };
    let tree = PatchLocator {
        face_start: vec![0, 1],
        cell_key: vec![0],
        cell_patch: vec![CUT],
        cuts: nodes.iter().map(|n| Cut { plane: plane(n), child: n.child.map(entry) }).collect(),
        ..PatchLocator::default()
    };
    let tree = tree.renumbered(|leaf| patches[leaf as usize]);
    let shifted = |entry: u32| if entry & CUT != 0 { entry + first } else { entry };
    cuts.extend(tree.cuts.iter().map(|cut| Cut { child: cut.child.map(shifted), ..*cut }));
    tree.cell_patch.first().copied().map(shifted)
}

fn plane(node: &Node) -> [f32; 4] {
    let normal = node.normal.as_vec3();
    [normal.x, normal.y, normal.z, node.offset as f32]
}
