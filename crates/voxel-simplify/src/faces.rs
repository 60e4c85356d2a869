//! The paper's own patches: sides of occupied voxels.
//!
//! A voxel that holds a piece of the surface has up to six patches, its sides, where the voxel
//! beyond is empty and some piece inside faces that way. Their positions lie off the surface, up to
//! a voxel away, and their area is the voxel's side whatever is inside. Colours are means over the
//! pieces that face the side, weighted by area and cosine.
//!
//! Source: A. Shcherbakov, V. Frolov, Matrix transformations for efficient implementation of the
//! radiosity algorithm on GPUs, Light & Engineering 27(2), 2019.

use std::ops::Range;

use glam::DVec3;
use radfile::{CellKey, Patches, Piece, Side, face_id};

use crate::{
    assemble::{fan, is_sound, locate, piece_area},
    clip::{Clip, Clips},
    draft::{Coat, Draft},
    grid::Grid,
    surface::Surface,
};

const SIDES: [Side; 2] = [Side::Front, Side::Back];
/// Axis and sign of the six sides of a voxel.
const DIRECTIONS: [(usize, f64); 6] = [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, -1.0), (2, 1.0)];

/// Makes the patches of all occupied voxels.
pub fn faces(surface: &Surface, grid: &Grid, clips: &Clips) -> Draft {
    let mut order: Vec<u32> = (0..clips.clips.len() as u32).collect();
    order.sort_unstable_by_key(|&c| (clips.clips[c as usize].cell, c));
    let runs: Vec<&[u32]> =
        order.chunk_by(|&a, &b| clips.clips[a as usize].cell == clips.clips[b as usize].cell).collect();
    let occupied: Vec<CellKey> = runs.iter().map(|run| clips.clips[run[0] as usize].cell).collect();
    let mut patches = Patches { piece_start: vec![0], ..Patches::default() };
    let mut coat = Coat { start: vec![0], ..Coat::default() };
    let mut best_face = vec![[None; 2]; clips.clips.len()];
    for (run, &cell) in runs.iter().zip(&occupied) {
        let first = patches.area.len();
        for direction in DIRECTIONS {
            if is_empty_beyond(grid, &occupied, cell, direction) {
                push_face(surface, grid, clips, run, direction, &mut patches, &mut coat);
            }
        }
        for &clip in *run {
            best_face[clip as usize] =
                SIDES.map(|side| best(surface, &clips.clips[clip as usize], side, &patches, first..patches.area.len()));
        }
    }
    patches.locator = locate(surface, grid, clips, |clip, side| best_face[clip][side as usize]);
    Draft { patches, coat, touches: vec![], cells: runs.len(), pieces: clips.clips.len(), merged: 0, sliver_area: 0.0 }
}

fn is_empty_beyond(grid: &Grid, occupied: &[CellKey], cell: CellKey, (axis, sign): (usize, f64)) -> bool {
    let mut beyond = cell.cell();
    beyond[axis] += sign as i64;
    !(0..grid.layers[axis]).contains(&beyond[axis]) || occupied.binary_search(&CellKey::new(beyond)).is_err()
}

/// Cosine between a side of a piece and a side of its voxel.
fn cosine(surface: &Surface, clip: &Clip, side: Side, (axis, sign): (usize, f64)) -> f64 {
    let front = sign * surface.normal[clip.triangle as usize][axis];
    if side == Side::Front { front } else { -front }
}

/// Adds one side of a voxel if some piece inside faces it.
fn push_face(
    surface: &Surface,
    grid: &Grid,
    clips: &Clips,
    run: &[u32],
    direction: (usize, f64),
    patches: &mut Patches,
    coat: &mut Coat,
) {
    let mut dominant = (0.0, 0, Side::Front);
    for clip in run.iter().map(|&c| &clips.clips[c as usize]) {
        for side in SIDES.into_iter().filter(|&s| surface.uses(s)) {
            let cosine = cosine(surface, clip, side, direction);
            if cosine <= 1e-6 {
                continue;
            }
            let front = surface.normal[clip.triangle as usize];
            let sound = fan(clip, side).filter(|p| is_sound(p, front));
            coat.parts.extend(sound.map(|p| (p, cosine as f32 * piece_area(&p))));
            if clip.area * cosine > dominant.0 {
                dominant = (clip.area * cosine, clip.triangle, side);
            }
        }
    }
    if coat.parts.len() == *coat.start.last().expect("starts with 0") as usize {
        return;
    }
    coat.start.push(coat.parts.len() as u32);
    let corners = corners(grid, clips.clips[run[0] as usize].cell, direction);
    let [a, b, c, d] = corners.map(|p| p.as_vec3().to_array());
    let (_, triangle, side) = dominant;
    let face = face_id(triangle, side);
    // A piece turns like its triangle: about the patch's normal on the front, against it on the back.
    let halves = if side == Side::Front { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
    patches.pieces.extend(halves.map(|corners| Piece { corners, face }));
    patches.piece_start.push(patches.pieces.len() as u32);
    patches.position.push((0.5 * (corners[0] + corners[2])).as_vec3().to_array());
    patches.normal.push(normal(direction).as_vec3().to_array());
    patches.area.push((grid.size * grid.size) as f32);
    patches.reflectance.push([0.0; 3]);
    patches.emission.push([0.0; 3]);
}

fn normal((axis, sign): (usize, f64)) -> DVec3 {
    let mut normal = DVec3::ZERO;
    normal[axis] = sign;
    normal
}

/// Corners of a side of a voxel, counter-clockwise seen from outside.
fn corners(grid: &Grid, cell: CellKey, (axis, sign): (usize, f64)) -> [DVec3; 4] {
    let cell = cell.cell();
    let mut low = DVec3::from_array(std::array::from_fn(|a| grid.plane(a, cell[a])));
    let (mut u, mut v) = (DVec3::ZERO, DVec3::ZERO);
    u[(axis + 1) % 3] = grid.size;
    v[(axis + 2) % 3] = grid.size;
    if sign > 0.0 {
        low[axis] += grid.size;
    } else {
        std::mem::swap(&mut u, &mut v);
    }
    [low, low + u, low + u + v, low + v]
}

/// The side of its voxel, among `range`, that a side of a piece faces most.
fn best(surface: &Surface, clip: &Clip, side: Side, patches: &Patches, range: Range<usize>) -> Option<u32> {
    let front = surface.normal[clip.triangle as usize];
    let outward = if side == Side::Front { front } else { -front };
    let cosine = |p: usize| outward.dot(DVec3::from_array(patches.normal[p].map(f64::from)));
    let facing = range.filter(|&p| cosine(p) > 1e-6);
    facing.max_by(|&p, &q| cosine(p).total_cmp(&cosine(q)).then(q.cmp(&p))).map(|p| p as u32)
}
