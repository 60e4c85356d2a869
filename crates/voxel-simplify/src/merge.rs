//! Small sheets join the neighbour with which they share the longest edge.
//!
//! A triangle that pokes a little into a cell, the narrow side of a door leaf, a bevel: each would
//! be a patch with a row and a column of its own in every matrix, though hardly any light leaves
//! it. The neighbour may lie in the next cell or be another facing of the same one; it must face
//! roughly the same way and the two together must not spread.

use crate::{grid::Grid, group::Sheets};

/// Sheets smaller than this part of a cell's side look for a neighbour to join.
pub const SMALL: f64 = 0.04;
/// Cosine of 50°.
const CONE: f64 = 0.643;
/// Longest side of a joined sheet's box, in cells.
const MOST_SPREAD: f64 = 2.5;

/// For every sheet, the one it belongs to now and whether its `+` lies on that one's `−`.
pub struct Merged {
    pub into: Vec<(u32, bool)>,
    /// Sheets that joined another.
    pub count: usize,
}

/// Joins small sheets to neighbours, smallest first.
pub fn merge(sheets: &mut Sheets, grid: &Grid) -> Merged {
    let small = SMALL * grid.size * grid.size;
    let count = sheets.sheets.len();
    let mut forest = Forest { parent: (0..count as u32).collect(), turned: vec![false; count] };
    let mut touching: Vec<Vec<(u32, bool, f64)>> = vec![Vec::new(); count];
    for t in &sheets.touches {
        touching[t.a as usize].push((t.b, t.turned, t.length));
        touching[t.b as usize].push((t.a, t.turned, t.length));
    }
    let mut queue: Vec<u32> = (0..count as u32).filter(|&s| sheets.sheets[s as usize].area < small).collect();
    queue.sort_by(|&a, &b| sheets.sheets[a as usize].area.total_cmp(&sheets.sheets[b as usize].area).then(a.cmp(&b)));
    let mut joined = 0;
    for s in queue {
        // A sheet is taken from the queue before any that is larger, so it is still its own root or was never one.
        if forest.find(s).0 != s || sheets.sheets[s as usize].area >= small {
            continue;
        }
        let Some((to, turned)) = best_neighbour(s, sheets, &mut forest, &touching, MOST_SPREAD * grid.size) else {
            continue;
        };
        let mut part = sheets.sheets[s as usize];
        part.normal = if turned { -part.normal } else { part.normal };
        sheets.sheets[to as usize].join(&part);
        forest.parent[s as usize] = to;
        forest.turned[s as usize] = turned;
        let own = std::mem::take(&mut touching[s as usize]);
        let own = own.into_iter().map(|(other, t, length)| (other, t ^ turned, length));
        touching[to as usize].extend(own);
        joined += 1;
    }
    Merged { into: (0..count as u32).map(|s| forest.find(s)).collect(), count: joined }
}

/// The root with the longest common edge among those that `s` may join, and whether it is turned.
fn best_neighbour(
    s: u32,
    sheets: &Sheets,
    forest: &mut Forest,
    touching: &[Vec<(u32, bool, f64)>],
    most_spread: f64,
) -> Option<(u32, bool)> {
    let mut lengths: Vec<(u32, bool, f64)> = touching[s as usize]
        .iter()
        .map(|&(other, turned, length)| {
            let (root, root_turned) = forest.find(other);
            (root, turned ^ root_turned, length)
        })
        .filter(|&(root, ..)| root != s)
        .collect();
    lengths.sort_by_key(|&(root, turned, _)| (root, turned));
    let own = &sheets.sheets[s as usize];
    let mut best: Option<(u32, bool, f64)> = None;
    for same in lengths.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (root, turned, _) = same[0];
        let length: f64 = same.iter().map(|&(.., l)| l).sum();
        let mut part = *own;
        part.normal = if turned { -part.normal } else { part.normal };
        let other = &sheets.sheets[root as usize];
        let spread = (own.upper.max(other.upper) - own.lower.min(other.lower)).max_element();
        if other.accepts(&part, CONE) && spread <= most_spread && best.is_none_or(|(.., l)| length > l) {
            best = Some((root, turned, length));
        }
    }
    best.map(|(root, turned, _)| (root, turned))
}

/// Union-find with the turn of every sheet against its root.
struct Forest {
    parent: Vec<u32>,
    turned: Vec<bool>,
}

impl Forest {
    /// The root of a sheet and whether the sheet is turned against it.
    fn find(&mut self, sheet: u32) -> (u32, bool) {
        let (mut root, mut turned) = (sheet, false);
        while self.parent[root as usize] != root {
            turned ^= self.turned[root as usize];
            root = self.parent[root as usize];
        }
        let (mut at, mut rest) = (sheet, turned);
        while self.parent[at as usize] != root && at != root {
            let (next, step) = (self.parent[at as usize], self.turned[at as usize]);
            self.parent[at as usize] = root;
            self.turned[at as usize] = rest;
            rest ^= step;
            at = next;
        }
        (root, turned)
    }
}
