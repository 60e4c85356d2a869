//! Which pieces of a cell touch, and whether they turn the same way.
//!
//! Two pieces touch where they share a piece of an edge inside the cell. Edges of welded triangles
//! are found by their vertices; what is left over is compared in space, because meshes have
//! T-junctions and seams that are open by rounding. Touching at a single point is no contact.
//!
//! Along a common edge two triangles of one sheet run in opposite directions. If they run in the
//! same direction, the front of one goes on in the back of the other: the contact is `turned`.
//! For triangles that face the same way this also tells a surface that goes on from one that is
//! folded back onto itself, so the two sides of a thin wedge never count as one.
//!
//! Where a third surface stands on the common edge, the floors of two rooms and the wall between
//! them, the contact is cut: light does not pass from one floor to the other.

use glam::DVec3;

use crate::{
    boxes::{Box3, close_pairs},
    clip::{Clip, Edge},
    surface::Surface,
};

/// Pieces that are paired with one piece along one edge; more meet through each other.
const MOST_ON_AN_EDGE: usize = 16;

/// Largest tolerance for the place of an edge, as a part of its length.
const MOST_OF_EDGE: f64 = 0.05;
/// Cosine of 50°: pieces that face apart by less go on in each other, others stand on each other.
const GOES_ON: f64 = 0.643;

/// Two pieces of one cell that touch, by their numbers in the cell.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    pub a: u32,
    pub b: u32,
    /// The front of one goes on in the back of the other.
    pub turned: bool,
    /// Length of the common edge, metres.
    pub length: f64,
    /// Ends of the common edge.
    ends: [DVec3; 2],
}

/// An edge of a triangle as far as it lies in the cell.
struct Segment {
    /// Welded vertices, the smaller first.
    key: (u32, u32),
    /// Whether the piece runs from the smaller to the larger.
    forward: bool,
    piece: u32,
    from: DVec3,
    to: DVec3,
}

impl Box3 {
    fn around(s: &Segment, pad: f64) -> Box3 {
        Box3 { low: s.from.min(s.to) - pad, high: s.from.max(s.to) + pad }
    }
}

impl Segment {
    fn length(&self) -> f64 {
        self.from.distance(self.to)
    }
}

/// All contacts in a cell; `tolerance` in metres.
pub fn contacts(surface: &Surface, pieces: &[&Clip], tolerance: f64) -> Vec<Contact> {
    let mut segments = segments(surface, pieces);
    segments.sort_by_key(|s| (s.key, s.piece));
    let shared: Vec<&[Segment]> = segments.chunk_by(|s, t| s.key == t.key).collect();
    let mut contacts = Vec::new();
    for edge in &shared {
        for (i, s) in edge.iter().enumerate() {
            contacts.extend(edge[i + 1..].iter().take(MOST_ON_AN_EDGE).map(|t| {
                let shorter = if s.length() < t.length() { s } else { t };
                Contact {
                    a: s.piece,
                    b: t.piece,
                    turned: s.forward == t.forward,
                    length: shorter.length(),
                    ends: [shorter.from, shorter.to],
                }
            }));
        }
    }
    meet_in_space(&shared, tolerance, &mut contacts);
    cut_below_walls(surface, pieces, &contacts, tolerance)
}

fn segments(surface: &Surface, pieces: &[&Clip]) -> Vec<Segment> {
    let mut segments = Vec::new();
    for (clip, piece) in pieces.iter().zip(0..) {
        let vertices = surface.scene.mesh.triangles[clip.triangle as usize].map(|v| surface.welded[v as usize]);
        for (i, corner) in clip.corners.iter().enumerate() {
            let Edge::Triangle(k) = corner.edge else { continue };
            let (from, to) = (corner.point, clip.corners[(i + 1) % clip.corners.len()].point);
            let (v, w) = (vertices[k as usize], vertices[(k as usize + 1) % 3]);
            if from != to {
                segments.push(Segment { key: (v.min(w), v.max(w)), forward: v < w, piece, from, to });
            }
        }
    }
    segments
}

/// Finds edges that lie on each other though their vertices differ, at least one of them alone.
fn meet_in_space(edges: &[&[Segment]], tolerance: f64, contacts: &mut Vec<Contact>) {
    // Half on either side, so boxes overlap where segments lie within the tolerance of each other.
    let pad = |s: &Segment| 0.5 * tolerance.min(MOST_OF_EDGE * s.length());
    let boxes: Vec<Box3> = edges.iter().map(|e| Box3::around(&e[0], pad(&e[0]))).collect();
    let one_alone = |i: usize, j: usize| edges[i].len() == 1 || edges[j].len() == 1;
    for (i, j) in close_pairs(&boxes, one_alone) {
        for s in edges[i].iter().take(MOST_ON_AN_EDGE) {
            let others = edges[j].iter().take(MOST_ON_AN_EDGE).filter(|t| t.piece != s.piece);
            contacts.extend(others.filter_map(|t| meet(s, t, tolerance)));
        }
    }
}

/// The contact of two segments that lie on each other for more than the tolerance.
fn meet(s: &Segment, t: &Segment, tolerance: f64) -> Option<Contact> {
    let (first, second) = if s.piece < t.piece { (s, t) } else { (t, s) };
    let ends = overlap([first.from, first.to], [second.from, second.to], tolerance)?;
    let turned = (first.to - first.from).dot(second.to - second.from) > 0.0;
    Some(Contact { a: first.piece, b: second.piece, turned, length: ends[0].distance(ends[1]), ends })
}

/// What two segments have in common, if that is more than the tolerance. For short ones that is a part of their length.
fn overlap(s: [DVec3; 2], t: [DVec3; 2], tolerance: f64) -> Option<[DVec3; 2]> {
    let (d, e) = (s[1] - s[0], t[1] - t[0]);
    let (longer, shorter) = (d.length_squared().max(e.length_squared()), d.length_squared().min(e.length_squared()));
    let tolerance = tolerance.min(MOST_OF_EDGE * shorter.sqrt());
    if d.cross(e).length_squared() > 4.0 * tolerance * tolerance * longer {
        return None; // not parallel enough for both ends of the shorter to lie on the longer
    }
    let length = |s: [DVec3; 2]| s[0].distance(s[1]);
    let (long, short) = if length(s) >= length(t) { (s, t) } else { (t, s) };
    let along = (long[1] - long[0]) / length(long);
    let place = |p: DVec3| (p - long[0]).dot(along);
    let off = |p: DVec3| (p - long[0] - place(p) * along).length();
    let (x, y) = (place(short[0]), place(short[1]));
    let (low, high) = (x.min(y).max(0.0), x.max(y).min(length(long)));
    let common = off(short[0]) <= tolerance && off(short[1]) <= tolerance && high - low > 2.0 * tolerance;
    common.then_some([long[0] + low * along, long[0] + high * along])
}

/// The contacts that no third piece stands on for half of their length or more.
fn cut_below_walls(surface: &Surface, pieces: &[&Clip], contacts: &[Contact], tolerance: f64) -> Vec<Contact> {
    let normal = |piece: u32| surface.normal[pieces[piece as usize].triangle as usize];
    let goes_on = |c: &Contact| normal(c.a).dot(normal(c.b)).abs() >= GOES_ON;
    let mut standing: Vec<Vec<(u32, [DVec3; 2])>> = vec![Vec::new(); pieces.len()];
    for c in contacts.iter().filter(|c| !goes_on(c)) {
        standing[c.a as usize].push((c.b, c.ends));
        standing[c.b as usize].push((c.a, c.ends));
    }
    for walls in &mut standing {
        walls.sort_by_key(|(wall, _)| *wall);
    }
    let covers = |c: &Contact, ends: [DVec3; 2]| {
        overlap(ends, c.ends, tolerance).is_some_and(|common| common[0].distance(common[1]) >= 0.5 * c.length)
    };
    let on = |piece: u32, wall: u32| {
        let walls = &standing[piece as usize];
        let first = walls.partition_point(|(w, _)| *w < wall);
        walls[first..].iter().take_while(move |(w, _)| *w == wall).map(|(_, ends)| *ends)
    };
    let is_cut = |c: &Contact| {
        let mut walls = standing[c.a as usize].iter();
        walls.any(|&(wall, ends)| on(c.b, wall).any(|other| covers(c, other)) && covers(c, ends))
    };
    contacts.iter().filter(|c| !goes_on(c) || !is_cut(c)).copied().collect()
}
