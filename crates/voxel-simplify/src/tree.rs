//! A piece parted by the lines that walls stand on: a tree of planes and its leaves.
//!
//! It is a tree for binary space partitioning (H. Fuchs, Z. Kedem, B. Naylor, On visible surface
//! generation by a priori tree structures, SIGGRAPH 1980): a line cuts those leaves that one of its
//! walls passes through, so leaves stay convex and few.

use glam::DVec3;

use crate::{
    clip::{Corner, Edge, area, split},
    wall::{Wall, common, union},
};

/// A part smaller than this share of a cell's side is not cut off. What is left straddling links both sides of a wall,
/// so only rounding may be.
const LEAST_PART: f64 = 1e-9;
/// Most cuts of one piece.
const MOST_CUTS: usize = 16;
/// Most lines that are tried; walls on others only part what touches along them.
const MOST_LINES: usize = 64;

/// What stands on a piece of one triangle in one cell, and how that was cut.
#[derive(Clone, Debug, Default)]
pub struct Cutting {
    pub walls: Vec<Wall>,
    /// Children come after their parents; empty if the piece was left whole.
    pub nodes: Vec<Node>,
    /// More cuts would have been due.
    pub capped: bool,
}

/// A plane upright on the piece.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    pub normal: DVec3,
    /// Of the plane's points along the normal, metres.
    pub offset: f64,
    /// What lies below and above.
    pub child: [Child; 2],
}

#[derive(Clone, Copy, Debug)]
pub enum Child {
    Node(u32),
    /// A leaf, by its number among the pieces of this triangle in this cell.
    Leaf(u32),
}

/// A line of a piece and the walls on it.
struct Line {
    from: DVec3,
    direction: DVec3,
    /// In the piece, across the line.
    aside: DVec3,
    /// Parts of the line that walls stand on, from `from`, metres.
    parts: Vec<[f64; 2]>,
    /// Sum of their lengths.
    length: f64,
}

/// Gathers walls by lines; those with the longest walls come first.
fn lines(walls: &[Wall], normal: DVec3, tolerance: f64) -> Vec<Line> {
    let mut order: Vec<(f64, usize)> = walls.iter().map(|w| w.ends[0].distance(w.ends[1])).zip(0..).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut lines: Vec<Line> = Vec::new();
    for (length, wall) in order {
        let ends = walls[wall].ends;
        let near = |line: &Line| ends.iter().all(|&p| (p - line.from).dot(line.aside).abs() <= tolerance);
        let at = match lines.iter().position(near) {
            Some(at) => at,
            None if lines.len() == MOST_LINES => continue,
            None => {
                let direction = (ends[1] - ends[0]) / length;
                let aside = normal.cross(direction).normalize();
                lines.push(Line { from: ends[0], direction, aside, parts: vec![], length: 0.0 });
                lines.len() - 1
            }
        };
        let line = &mut lines[at];
        let [a, b] = ends.map(|p| (p - line.from).dot(line.direction));
        line.parts.push([a.min(b), a.max(b)]);
    }
    for line in &mut lines {
        line.length = union(&mut line.parts);
    }
    lines.sort_by(|a, b| b.length.total_cmp(&a.length));
    lines
}

/// Corners of a convex polygon.
pub type Polygon = Vec<Corner>;

/// Parts a piece by its walls; returns how, and its leaves, one if it was left whole.
pub fn part(
    polygon: Polygon,
    walls: Vec<Wall>,
    normal: DVec3,
    cell_size: f64,
    tolerance: f64,
) -> (Cutting, Vec<Polygon>) {
    let least = LEAST_PART * cell_size * cell_size;
    let leaves = vec![Leaf { polygon, parent: None }];
    let mut tree = Tree { leaves, cutting: Cutting::default(), least, tolerance };
    for line in lines(&walls, normal, tolerance) {
        tree.cut_by(&line);
    }
    let Tree { leaves, mut cutting, .. } = tree;
    cutting.walls = walls;
    (cutting, leaves.into_iter().map(|leaf| leaf.polygon).collect())
}

/// A part of a piece.
struct Leaf {
    polygon: Polygon,
    /// Node and side that it hangs from.
    parent: Option<(u32, usize)>,
}

/// A piece on its way to leaves.
struct Tree {
    leaves: Vec<Leaf>,
    cutting: Cutting,
    /// Smallest part, m².
    least: f64,
    tolerance: f64,
}

impl Tree {
    /// Cuts those leaves that walls on the line pass through.
    fn cut_by(&mut self, line: &Line) {
        for leaf in 0..self.leaves.len() {
            let Some(parts) = self.parts(leaf, line) else { continue };
            if self.cutting.nodes.len() == MOST_CUTS {
                self.cutting.capped = true;
                return;
            }
            self.replace(leaf, line, parts);
        }
    }

    /// Both parts of a leaf if it is to be cut, with edges that will have the next node's number.
    fn parts(&self, leaf: usize, line: &Line) -> Option<[Polygon; 2]> {
        let polygon = &self.leaves[leaf].polygon;
        let distance = |p: DVec3| (p - line.from).dot(line.aside);
        let (low, high) =
            polygon.iter().map(|c| distance(c.point)).fold((0.0f64, 0.0f64), |(l, h), d| (l.min(d), h.max(d)));
        if low > -self.tolerance || high < self.tolerance {
            return None;
        }
        let chord = common(polygon, distance, line.direction, 0.0)?;
        let [from, to] = chord.map(|p| (p - line.from).dot(line.direction));
        let passes = |&[a, b]: &[f64; 2]| b.min(to) - a.max(from) > 2.0 * self.tolerance;
        if !line.parts.iter().any(passes) {
            return None;
        }
        let edge = Edge::Cut(self.cutting.nodes.len() as u8);
        let (below, above) = split(polygon, distance, [edge, edge], |p| p);
        let sound = |part: &[Corner]| part.len() >= 3 && area(part) >= self.least;
        (sound(&below) && sound(&above)).then_some([below, above])
    }

    fn replace(&mut self, leaf: usize, line: &Line, [below, above]: [Polygon; 2]) {
        let (node, other) = (self.cutting.nodes.len() as u32, self.leaves.len() as u32);
        let child = [Child::Leaf(leaf as u32), Child::Leaf(other)];
        self.cutting.nodes.push(Node { normal: line.aside, offset: line.from.dot(line.aside), child });
        if let Some((parent, side)) = self.leaves[leaf].parent {
            self.cutting.nodes[parent as usize].child[side] = Child::Node(node);
        }
        self.leaves[leaf] = Leaf { polygon: below, parent: Some((node, 0)) };
        self.leaves.push(Leaf { polygon: above, parent: Some((node, 1)) });
    }
}
