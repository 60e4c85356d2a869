//! The pieces of each cell gathered to sheets.
//!
//! A sheet grows from its largest piece over contacts to pieces that face within a cone of the
//! sheet's mean normal. It has two sides, `+` and `−`; each piece is entered with whether its front
//! belongs to `−`. Emissive and other surfaces are kept apart, or a lamp would spread over its
//! frame.

use glam::DVec3;
use radfile::CellKey;
use rayon::prelude::*;

use crate::{
    cells::Cells,
    clip::{Clip, Clips, Edge},
    contact::{Contact, WALLED, contacts, walls},
    grid::Grid,
    surface::Surface,
    wall::covered,
};

/// Cosine of 35°: pieces that face further away from the mean start a sheet of their own.
const CONE: f64 = 0.819;

/// A wall that stands this far from a plane between cells, in cells, still keeps apart what touches there.
const BESIDE: f64 = 1e-3;

/// A connected part of the surface in one cell.
#[derive(Clone, Copy, Debug)]
pub struct Sheet {
    /// One side, m².
    pub area: f64,
    /// Sum of area times unit normal of the `+` side.
    pub normal: DVec3,
    /// Bounding box.
    pub lower: DVec3,
    pub upper: DVec3,
    pub emits: bool,
}

/// Two sheets that touch.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    pub a: u32,
    pub b: u32,
    /// `+` of one goes on in `−` of the other.
    pub turned: bool,
    /// Metres.
    pub length: f64,
}

/// All sheets, in the order of cells.
pub struct Sheets {
    pub sheets: Vec<Sheet>,
    /// For every piece, its sheet and whether its front belongs to `−`.
    pub of_clip: Vec<(u32, bool)>,
    /// At least one of the two is small.
    pub touches: Vec<Touch>,
    /// Occupied cells.
    pub cells: usize,
}

/// What one cell yields, with numbers that count within the cell.
struct Cell {
    sheets: Vec<Sheet>,
    of_piece: Vec<(u32, bool)>,
    touches: Vec<Touch>,
}

/// Gathers the pieces of every cell. Touches are kept where a sheet is smaller than `small` m².
pub fn group(surface: &Surface, grid: &Grid, clips: &Clips, tolerance: f64, small: f64) -> Sheets {
    let by_cell = Cells::new(clips);
    let cells: Vec<Cell> = (0..by_cell.runs.len())
        .into_par_iter()
        .map(|run| {
            let pieces: Vec<&Clip> = by_cell.of(run).iter().map(|&c| &clips.clips[c as usize]).collect();
            group_cell(surface, clips, &pieces, tolerance, small)
        })
        .collect();
    let mut all =
        Sheets { sheets: vec![], of_clip: vec![(0, false); clips.clips.len()], touches: vec![], cells: cells.len() };
    for (run, cell) in cells.into_iter().enumerate() {
        let first = all.sheets.len() as u32;
        for (&clip, (sheet, turned)) in by_cell.of(run).iter().zip(cell.of_piece) {
            all.of_clip[clip as usize] = (first + sheet, turned);
        }
        all.touches.extend(cell.touches.iter().map(|t| Touch { a: first + t.a, b: first + t.b, ..*t }));
        all.sheets.extend(cell.sheets);
    }
    touch_across_planes(clips, &mut all, small, [tolerance, BESIDE * grid.size]);
    all
}

fn group_cell(surface: &Surface, clips: &Clips, pieces: &[&Clip], tolerance: f64, small: f64) -> Cell {
    let contacts = contacts(surface, clips, pieces, tolerance);
    let neighbours = neighbours(pieces.len(), &contacts);
    let mut by_area: Vec<usize> = (0..pieces.len()).collect();
    by_area.sort_by(|&a, &b| pieces[b].area.total_cmp(&pieces[a].area).then(a.cmp(&b)));
    let mut of_piece: Vec<Option<(u32, bool)>> = vec![None; pieces.len()];
    let mut sheets = Vec::new();
    for seed in by_area {
        if of_piece[seed].is_some() {
            continue;
        }
        let number = sheets.len() as u32;
        of_piece[seed] = Some((number, false));
        let mut sheet = Sheet::of(surface, pieces[seed], false);
        let mut frontier = std::collections::VecDeque::from([(seed, false)]);
        while let Some((piece, turned)) = frontier.pop_front() {
            for &(next, contact_turned) in &neighbours[piece] {
                let next_turned = turned ^ contact_turned;
                let candidate = Sheet::of(surface, pieces[next], next_turned);
                if of_piece[next].is_none() && sheet.accepts(&candidate, CONE) {
                    of_piece[next] = Some((number, next_turned));
                    sheet.join(&candidate);
                    frontier.push_back((next, next_turned));
                }
            }
        }
        sheets.push(sheet);
    }
    let of_piece: Vec<(u32, bool)> = of_piece.into_iter().flatten().collect();
    let touches = contacts
        .iter()
        .filter_map(|c| touch(&sheets, small, of_piece[c.a as usize], of_piece[c.b as usize], c.turned, c.length));
    Cell { touches: touches.collect(), sheets, of_piece }
}

/// For every piece, what it may make a sheet with and whether turned.
fn neighbours(count: usize, contacts: &[Contact]) -> Vec<Vec<(usize, bool)>> {
    let mut neighbours = vec![Vec::new(); count];
    for c in contacts.iter().filter(|c| !c.weak) {
        neighbours[c.a as usize].push((c.b as usize, c.turned));
        neighbours[c.b as usize].push((c.a as usize, c.turned));
    }
    neighbours
}

impl Sheet {
    fn of(surface: &Surface, clip: &Clip, turned: bool) -> Sheet {
        let normal = surface.normal[clip.triangle as usize] * clip.area;
        let points = || clip.corners.iter().map(|c| c.point);
        Sheet {
            area: clip.area,
            normal: if turned { -normal } else { normal },
            lower: points().fold(DVec3::INFINITY, DVec3::min),
            upper: points().fold(DVec3::NEG_INFINITY, DVec3::max),
            emits: surface.emits[clip.triangle as usize],
        }
    }

    /// Whether the other sheet's `+` faces within a cone of this one's and is of the same kind.
    pub fn accepts(&self, other: &Sheet, cosine: f64) -> bool {
        let cone = cosine * self.normal.length() * other.normal.length();
        self.emits == other.emits && self.normal.dot(other.normal) >= cone
    }

    /// Adds the other sheet, `+` to `+`.
    pub fn join(&mut self, other: &Sheet) {
        self.area += other.area;
        self.normal += other.normal;
        self.lower = self.lower.min(other.lower);
        self.upper = self.upper.max(other.upper);
    }
}

/// A touch of two sheets by way of two of their pieces, if it can matter.
fn touch(
    sheets: &[Sheet],
    small: f64,
    (a, a_turned): (u32, bool),
    (b, b_turned): (u32, bool),
    turned: bool,
    length: f64,
) -> Option<Touch> {
    let matters = a != b && (sheets[a as usize].area < small || sheets[b as usize].area < small);
    matters.then_some(Touch { a, b, turned: a_turned ^ b_turned ^ turned, length })
}

/// Enters touches of pieces of one triangle on both sides of a plane between cells, unless a wall stands there.
///
/// As within a cell, what has no more than the tolerance in common meets at a corner only: where walls cross the plane,
/// rounding alone says that pieces inside of a wall and pieces beside it do so at all.
fn touch_across_planes(clips: &Clips, all: &mut Sheets, small: f64, [tolerance, beside]: [f64; 2]) {
    let mut touches = Vec::new();
    for (clip, &here) in clips.clips.iter().zip(&all.of_clip) {
        for (edge, ends) in clip.edges() {
            let Edge::Above(axis) = edge else { continue };
            let mut cell = clip.cell.cell();
            cell[axis as usize] += 1;
            for number in clips.pieces_of(clip.triangle, CellKey::new(cell)) {
                let other = &clips.clips[number as usize];
                let length = other.edges().filter(|(edge, _)| *edge == Edge::Below(axis)).map(|(_, e)| common(ends, e));
                let length = length.sum::<f64>();
                let touch = touch(&all.sheets, small, here, all.of_clip[number as usize], false, length);
                let is_walled = || {
                    let walls = walls(clips, clip).chain(walls(clips, other)).filter(|wall| wall.upright);
                    covered(walls, ends, beside) >= WALLED * ends[0].distance(ends[1])
                };
                touches.extend(touch.filter(|t| t.length > 2.0 * tolerance && !is_walled()));
            }
        }
    }
    all.touches.extend(touches);
}

/// Metres that two edges on one line have in common.
fn common(s: [DVec3; 2], t: [DVec3; 2]) -> f64 {
    let along = (s[1] - s[0]).normalize_or_zero();
    let [a, b] = t.map(|p| (p - s[0]).dot(along));
    a.max(b).min((s[1] - s[0]).dot(along)) - a.min(b).max(0.0)
}
