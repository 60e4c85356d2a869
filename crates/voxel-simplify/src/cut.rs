//! Pieces cut where other surfaces stand on them or pass through them.
//!
//! A floor often runs on under a wall, a column or a box without an edge there. Then one piece of it
//! is open floor on one side and covered, or another room, on the other, and as one patch it would
//! carry the light of one to the other. So each piece is cut by the lines in which others of its
//! cell meet its plane, as far as these pass through it (`wall`, `tree`). The parts are pieces of
//! their own. What ends a little above a piece cuts it, too (`rim`).
//!
//! A line often goes on beyond the wall that it was made for. Therefore the walls are kept:
//! `contact` parts what they stand between and joins the rest again.

use glam::DVec3;
use rayon::prelude::*;

use crate::{
    boxes::{Box3, close_pairs},
    cells::Cells,
    clip::{Clip, Clips, area},
    contact::GOES_ON,
    grid::Grid,
    rim::{REACH, Rims},
    surface::Surface,
    tree::{Cutting, Polygon, part},
    wall::{Wall, common},
};

/// Of two pieces that meet one must be at least as large, in cell sides: where both are details none is cut.
const LARGE: f64 = 1e-3;
/// Cosine of 2.6°: planes that are more alike have no line in common that rounding leaves in its place.
const PARALLEL: f64 = 0.999;

/// How much was cut.
#[derive(Clone, Copy, Debug, Default)]
pub struct Count {
    /// Pieces that were cut.
    pub cut: usize,
    /// Those that would have taken more cuts than are allowed.
    pub capped: usize,
}

/// Cuts the pieces of all cells; places are compared to within `tolerance` metres.
pub fn cut(surface: &Surface, grid: &Grid, clips: Clips, tolerance: f64) -> (Clips, Count) {
    let (cells, rims) = (Cells::new(&clips), Rims::new(surface, grid.size));
    let reach = REACH * grid.size;
    let found: Vec<Vec<Done>> = (0..cells.runs.len())
        .into_par_iter()
        .map(|run| {
            Workshop { surface, grid, clips: &clips, cells: &cells, rims: &rims, tolerance, reach }.cut_cell(run)
        })
        .collect();
    let mut of_clip: Vec<Option<Done>> = Vec::new();
    of_clip.resize_with(clips.clips.len(), || None);
    for done in found.into_iter().flatten() {
        let clip = done.piece as usize;
        of_clip[clip] = Some(done);
    }
    rebuild(clips, of_clip)
}

/// The pieces again, leaves in the place of what was cut.
fn rebuild(from: Clips, of_clip: Vec<Option<Done>>) -> (Clips, Count) {
    let mut count = Count::default();
    let mut first = Vec::with_capacity(from.clips.len() + 1);
    let mut to = Clips { clips: Vec::with_capacity(from.clips.len()), cuttings: vec![], ..from };
    for (clip, found) in from.clips.into_iter().zip(of_clip) {
        first.push(to.clips.len() as u32);
        let Some(Done { cutting, leaves, .. }) = found else {
            to.clips.push(clip);
            continue;
        };
        let number = Some(to.cuttings.len() as u32);
        count.cut += usize::from(!cutting.nodes.is_empty());
        count.capped += usize::from(cutting.capped);
        if cutting.nodes.is_empty() {
            to.clips.push(Clip { cutting: number, ..clip });
        } else {
            let leaf = |corners: Polygon| Clip { cutting: number, area: area(&corners), corners, ..clip };
            to.clips.extend(leaves.into_iter().map(leaf));
        }
        to.cuttings.push(cutting);
    }
    first.push(to.clips.len() as u32);
    for range in &mut to.of_triangle {
        *range = first[range.start as usize]..first[range.end as usize];
    }
    (to, count)
}

/// What it takes to cut the pieces of a cell.
struct Workshop<'a> {
    surface: &'a Surface<'a>,
    grid: &'a Grid,
    clips: &'a Clips,
    cells: &'a Cells,
    rims: &'a Rims<'a>,
    tolerance: f64,
    /// How far above a piece edges still cut it, metres.
    reach: f64,
}

impl Workshop<'_> {
    fn clip(&self, clip: u32) -> &Clip {
        &self.clips.clips[clip as usize]
    }

    fn normal(&self, clip: u32) -> DVec3 {
        self.surface.normal[self.clip(clip).triangle as usize]
    }

    /// For every piece of a cell that something stands on: what, and its leaves.
    fn cut_cell(&self, run: usize) -> Vec<Done> {
        let own = self.cells.of(run);
        let members: Vec<u32> = own.iter().copied().chain(self.guests(run)).collect();
        // They overlap where pieces come as near as the tolerance or, with edges that may hang above others, as these reach.
        let pad = |c: u32| if self.rims.has_any(self.clip(c)) { self.reach } else { 0.5 * self.tolerance };
        let boxes: Vec<Box3> = members.iter().map(|&c| self.around(c, pad(c))).collect();
        let large = LARGE * self.grid.size * self.grid.size;
        let is_large: Vec<bool> = members.iter().map(|&c| self.clip(c).area >= large).collect();
        let wanted = |i: usize, j: usize| {
            (is_large[i] || is_large[j])
                && (i < own.len() || j < own.len())
                && self.clip(members[i]).triangle != self.clip(members[j]).triangle
                && (self.reaches(members[i], &boxes[j]) || self.reaches(members[j], &boxes[i]))
        };
        let mut walls: Vec<Vec<Wall>> = vec![Vec::new(); own.len()];
        for (i, j) in close_pairs(&boxes, wanted) {
            for (piece, other) in [(i, j), (j, i)].into_iter().filter(|&(piece, _)| piece < own.len()) {
                walls[piece].extend(self.walls(members[piece], members[other]));
            }
        }
        let standing = own.iter().zip(walls).filter(|(_, walls)| !walls.is_empty());
        let cut = |(&piece, walls)| {
            let polygon = self.clip(piece).corners.clone();
            let (cutting, leaves) = part(polygon, walls, self.normal(piece), self.grid.size, self.tolerance);
            Done { piece, cutting, leaves }
        };
        standing.map(cut).collect()
    }

    /// Pieces of cells across planes in which pieces of this cell lie: what stands there may be counted to either. Of cells
    /// across planes that are only near, those with edges that may hang above them.
    fn guests(&self, run: usize) -> Vec<u32> {
        let cell = self.cells.runs[run].0.cell();
        let mut gap = [[f64::INFINITY; 2]; 3];
        for &clip in self.cells.of(run) {
            let flat = self.around(clip, 0.0);
            for (axis, [below, above]) in gap.iter_mut().enumerate() {
                if flat.high[axis] - flat.low[axis] <= 2.0 * self.tolerance {
                    *below = below.min((flat.low[axis] - self.grid.plane(axis, cell[axis])).abs());
                    *above = above.min((self.grid.plane(axis, cell[axis] + 1) - flat.high[axis]).abs());
                }
            }
        }
        let mut guests = Vec::new();
        for (axis, gap) in gap.into_iter().enumerate() {
            for (step, gap) in [-1, 1].into_iter().zip(gap).filter(|&(_, gap)| gap <= self.reach) {
                let mut beyond = cell;
                beyond[axis] += step;
                let stands = |clip: &u32| gap <= 2.0 * self.tolerance || self.rims.has_any(self.clip(*clip));
                guests.extend(self.cells.at(beyond).iter().filter(|clip| stands(clip)));
            }
        }
        guests
    }

    /// The box around a piece, and `pad` metres more.
    fn around(&self, clip: u32, pad: f64) -> Box3 {
        let points = || self.clip(clip).corners.iter().map(|c| c.point);
        Box3 {
            low: points().fold(DVec3::INFINITY, DVec3::min) - pad,
            high: points().fold(DVec3::NEG_INFINITY, DVec3::max) + pad,
        }
    }

    /// Whether the plane of a piece passes through a box.
    fn reaches(&self, piece: u32, around: &Box3) -> bool {
        let normal = self.normal(piece);
        let (middle, half) = (0.5 * (around.low + around.high), 0.5 * (around.high - around.low));
        let distance = (middle - self.clip(piece).corners[0].point).dot(normal).abs();
        distance <= half.dot(normal.abs()) + self.tolerance
    }

    /// Where `other` stands on `piece`, passes through it or ends above it.
    fn walls(&self, piece: u32, other: u32) -> Vec<Wall> {
        let (normal, across) = (self.normal(piece), self.normal(other));
        let cosine = normal.dot(across).abs();
        if cosine > PARALLEL {
            return vec![];
        }
        let (along, upright) = (normal.cross(across).normalize(), cosine < GOES_ON);
        let (piece, other) = (self.clip(piece), self.clip(other));
        let foot = piece.corners[0].point;
        let met = common(&other.corners, |p| (p - foot).dot(normal), along, self.tolerance);
        let wall = |ends| self.wall(piece, normal, ends, upright);
        if let Some(wall) = met.and_then(wall) {
            return vec![wall];
        }
        let hanging = if upright { self.rims.above(piece, other, [self.tolerance, self.reach]) } else { vec![] };
        hanging.into_iter().filter_map(wall).collect()
    }

    /// A wall over these ends, as far as it lies on the piece.
    fn wall(&self, piece: &Clip, normal: DVec3, ends: [DVec3; 2], upright: bool) -> Option<Wall> {
        let foot = piece.corners[0].point;
        let [from, to] = ends.map(|p| p - (p - foot).dot(normal) * normal);
        let direction = (to - from).try_normalize()?;
        let aside = normal.cross(direction);
        let [low, high] = common(&piece.corners, |p| (p - from).dot(aside), direction, self.tolerance)?;
        let place = |p: DVec3| (p - from).dot(direction);
        let (low, high) = (place(low).max(0.0), place(high).min(place(to)));
        let long_enough = high - low > 2.0 * self.tolerance;
        long_enough.then_some(Wall { ends: [from + low * direction, from + high * direction], upright })
    }
}

/// A piece with its leaves, one if it was left whole.
struct Done {
    piece: u32,
    cutting: Cutting,
    leaves: Vec<Polygon>,
}
