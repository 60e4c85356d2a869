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
//! them, the contact is cut: light does not pass from one floor to the other. The same holds for the
//! parts of a piece that was cut (`cut`), where walls stand on half of their common edge or more.

use glam::DVec3;

use crate::{
    boxes::{Box3, close_pairs},
    clip::{Clip, Clips, Edge},
    surface::Surface,
    tree::Cutting,
    wall::{Wall, covered},
};

/// Pieces that are paired with one piece along one edge; more meet through each other.
const MOST_ON_AN_EDGE: usize = 16;

/// Largest tolerance for the place of an edge, as a part of its length.
const MOST_OF_EDGE: f64 = 0.05;
/// Cosine of 50°: pieces that face apart by less go on in each other, others stand on each other.
pub const GOES_ON: f64 = 0.643;
/// Part of a common edge that must be walled for the contact to be cut.
pub const WALLED: f64 = 0.5;
/// A contact is weak if it is shorter than this part of the root of the smaller area, or than so many tolerances.
const WEAK: f64 = 0.05;
const WEAK_TOLERANCES: f64 = 8.0;

/// Two pieces of one cell that touch, by their numbers in the cell.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    pub a: u32,
    pub b: u32,
    /// The front of one goes on in the back of the other.
    pub turned: bool,
    /// Length of the common edge, metres.
    pub length: f64,
    /// Too short to make one sheet of two: see [`is_weak`].
    pub weak: bool,
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
    /// Whether it may be a part of the edge only, because its piece was cut.
    part: bool,
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

/// All contacts among the pieces of a cell, which are some of `clips`; `tolerance` in metres.
pub fn contacts(surface: &Surface, clips: &Clips, pieces: &[&Clip], tolerance: f64) -> Vec<Contact> {
    let mut segments = segments(surface, pieces);
    segments.sort_by_key(|s| (s.key, s.piece));
    // Parts of an edge stand alone: they meet others, on that edge too, in space.
    let shared: Vec<&[Segment]> = segments.chunk_by(|s, t| s.key == t.key && !s.part && !t.part).collect();
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
                    weak: false,
                    ends: [shorter.from, shorter.to],
                }
            }));
        }
    }
    meet_in_space(&shared, tolerance, &mut contacts);
    let walled = |c: &Contact| is_walled(clips, pieces, c, tolerance);
    contacts.retain(|c| !goes_on(surface, pieces, c) || !walled(c));
    contacts.extend(within_triangles(pieces, tolerance).into_iter().filter(|c| !walled(c)));
    for contact in &mut contacts {
        contact.weak = is_weak(pieces, contact, tolerance);
    }
    cut_below_walls(surface, pieces, &contacts, tolerance)
}

/// Whether a contact is so short that it may be there by rounding only.
///
/// Walls cut pieces up to the tolerance, so a tip of a piece may reach to the other side of a wall. Such tips must not
/// link what the wall parts.
fn is_weak(pieces: &[&Clip], c: &Contact, tolerance: f64) -> bool {
    let [a, b] = [c.a, c.b].map(|piece| pieces[piece as usize]);
    (a.is_part() || b.is_part()) && c.length < (WEAK * a.area.min(b.area).sqrt()).max(WEAK_TOLERANCES * tolerance)
}

/// Whether two pieces face alike enough for one to go on in the other.
fn goes_on(surface: &Surface, pieces: &[&Clip], c: &Contact) -> bool {
    let normal = |piece: u32| surface.normal[pieces[piece as usize].triangle as usize];
    normal(c.a).dot(normal(c.b)).abs() >= GOES_ON
}

/// Whether that which stands on two pieces stands between them. Within a triangle all of that counts; on the edge of
/// two triangles only what is so upright that it can be neither of them.
fn is_walled(clips: &Clips, pieces: &[&Clip], c: &Contact, tolerance: f64) -> bool {
    let [a, b] = [c.a, c.b].map(|piece| pieces[piece as usize]);
    let within = a.triangle == b.triangle;
    let walls = walls(clips, a).chain(walls(clips, b).filter(|_| !within));
    covered(walls.filter(|wall| within || wall.upright), c.ends, tolerance) >= WALLED * c.length
}

/// What stands on the triangle of a piece in its cell.
pub fn walls<'a>(clips: &'a Clips, clip: &Clip) -> impl Iterator<Item = &'a Wall> + use<'a> {
    let cutting: Option<&Cutting> = clip.cutting.map(|number| &clips.cuttings[number as usize]);
    cutting.into_iter().flat_map(|cutting| &cutting.walls)
}

/// Contacts of the parts of one triangle, along the edges at which it was cut.
fn within_triangles(pieces: &[&Clip], tolerance: f64) -> Vec<Contact> {
    let mut edges: Vec<(u32, u8, Segment)> = Vec::new();
    for (clip, piece) in pieces.iter().zip(0..) {
        for (edge, [from, to]) in clip.edges() {
            if let (Edge::Cut(node), Some(cutting)) = (edge, clip.cutting) {
                edges.push((cutting, node, Segment { key: (0, 0), forward: true, piece, part: true, from, to }));
            }
        }
    }
    edges.sort_by_key(|&(cutting, node, ref s)| (cutting, node, s.piece));
    let mut contacts = Vec::new();
    for same in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        for (i, (.., s)) in same.iter().enumerate() {
            contacts.extend(same[i + 1..].iter().filter_map(|(.., t)| meet(s, t, tolerance)));
        }
    }
    contacts
}

fn segments(surface: &Surface, pieces: &[&Clip]) -> Vec<Segment> {
    let mut segments = Vec::new();
    for (clip, piece) in pieces.iter().zip(0..) {
        let vertices = surface.scene.mesh.triangles[clip.triangle as usize].map(|v| surface.welded[v as usize]);
        let part = clip.is_part();
        for (edge, [from, to]) in clip.edges() {
            let Edge::Triangle(k) = edge else { continue };
            let (v, w) = (vertices[k as usize], vertices[(k as usize + 1) % 3]);
            if from != to {
                segments.push(Segment { key: (v.min(w), v.max(w)), forward: v < w, piece, part, from, to });
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
    Some(Contact { a: first.piece, b: second.piece, turned, length: ends[0].distance(ends[1]), weak: false, ends })
}

/// What two segments have in common, if that is more than the tolerance. For short ones that is a part of their length.
pub fn overlap(s: [DVec3; 2], t: [DVec3; 2], tolerance: f64) -> Option<[DVec3; 2]> {
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
    let goes_on = |c: &Contact| goes_on(surface, pieces, c);
    let mut standing: Vec<Vec<(u32, [DVec3; 2])>> = vec![Vec::new(); pieces.len()];
    for c in contacts.iter().filter(|c| !goes_on(c)) {
        standing[c.a as usize].push((c.b, c.ends));
        standing[c.b as usize].push((c.a, c.ends));
    }
    for walls in &mut standing {
        walls.sort_by_key(|(wall, _)| *wall);
    }
    let covers = |c: &Contact, ends: [DVec3; 2]| {
        overlap(ends, c.ends, tolerance).is_some_and(|common| common[0].distance(common[1]) >= WALLED * c.length)
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
