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

use radfile::CellKey;

use crate::{
    clip::{Clip, Edge},
    surface::Surface,
};

/// Pieces that are paired with one piece along one edge; more meet through each other.
const MOST_ON_AN_EDGE: usize = 16;

/// Two pieces of one cell that touch, by their numbers in the cell.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    pub a: u32,
    pub b: u32,
    /// The front of one goes on in the back of the other.
    pub turned: bool,
    /// Length of the common edge, metres.
    pub length: f64,
}

/// An edge of a triangle as far as it lies in the cell.
struct Segment {
    /// Welded vertices, the smaller first.
    key: (u32, u32),
    /// Whether the piece runs from the smaller to the larger.
    forward: bool,
    piece: u32,
    from: glam::DVec3,
    to: glam::DVec3,
}

impl Segment {
    fn length(&self) -> f64 {
        self.from.distance(self.to)
    }
}

/// All contacts in a cell; `tolerance` in metres.
pub fn contacts(surface: &Surface, pieces: &[&Clip], tolerance: f64) -> Vec<Contact> {
    debug_assert!(pieces.windows(2).all(|w| CellKey::cmp(&w[0].cell, &w[1].cell).is_eq()));
    let mut segments = segments(surface, pieces);
    segments.sort_by_key(|s| (s.key, s.piece));
    let mut contacts = Vec::new();
    let mut lone = Vec::new();
    for shared in segments.chunk_by(|s, t| s.key == t.key) {
        if let [single] = shared {
            lone.push(single);
        }
        for (i, s) in shared.iter().enumerate() {
            for t in shared[i + 1..].iter().take(MOST_ON_AN_EDGE) {
                let length = s.length().min(t.length());
                contacts.push(Contact { a: s.piece, b: t.piece, turned: s.forward == t.forward, length });
            }
        }
    }
    meet_in_space(lone, tolerance, &mut contacts);
    contacts
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

/// Finds lone edges that lie on each other, by a sweep along x.
fn meet_in_space(mut lone: Vec<&Segment>, tolerance: f64, contacts: &mut Vec<Contact>) {
    let low = |s: &Segment| s.from.x.min(s.to.x);
    lone.sort_by(|s, t| low(s).total_cmp(&low(t)).then(s.piece.cmp(&t.piece)));
    for (i, s) in lone.iter().enumerate() {
        let reach = s.from.max(s.to) + tolerance;
        let floor = s.from.min(s.to) - tolerance;
        for t in lone[i + 1..].iter().take_while(|t| low(t) <= reach.x) {
            let apart = t.from.min(t.to).cmpgt(reach).any() || t.from.max(t.to).cmplt(floor).any();
            if apart || s.piece == t.piece {
                continue;
            }
            if let Some((turned, length)) = overlap(s, t, tolerance) {
                contacts.push(Contact { a: s.piece.min(t.piece), b: s.piece.max(t.piece), turned, length });
            }
        }
    }
}

/// Whether two segments lie on each other for more than the tolerance: direction and length.
fn overlap(s: &Segment, t: &Segment, tolerance: f64) -> Option<(bool, f64)> {
    let (long, short) = if s.length() >= t.length() { (s, t) } else { (t, s) };
    let length = long.length();
    let along = (long.to - long.from) / length;
    let place = |p: glam::DVec3| {
        let offset = p - long.from;
        let x = offset.dot(along);
        (x, (offset - x * along).length())
    };
    let ((x, off_x), (y, off_y)) = (place(short.from), place(short.to));
    let common = x.max(y).min(length) - x.min(y).max(0.0);
    let least = (2.0 * tolerance).min(0.5 * short.length());
    (off_x <= tolerance && off_y <= tolerance && common > least).then_some((y > x, common))
}
