//! Pairs of clusters: the blocks that a matrix can be cut into.
//!
//! Rows and columns of a symmetric matrix have one tree, and of each pair of clusters and its mirror image only one is
//! meant. A rectangle has a tree of columns and, for each of its chunks of rows, one of rows, as deep.

use std::ops::Range;

use crate::{block::Shape, cluster::Tree};

/// Largest cluster that has blocks; larger ones never had low rank.
const LARGEST: usize = 600;

/// Two clusters of a level, rows `a` and columns `b`; a ≤ b in symmetric matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Id {
    pub level: u32,
    pub a: usize,
    pub b: usize,
}

/// The blocks of a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pairs {
    pub rows: Tree,
    pub columns: Tree,
    symmetric: bool,
    /// The level whose blocks cover the matrix before any is split.
    pub first: u32,
}

impl Pairs {
    pub fn symmetric(tree: Tree) -> Pairs {
        Pairs::new(tree, tree, true)
    }

    /// The trees are equally deep; that of the columns has one root.
    pub fn rectangular(rows: Tree, columns: Tree) -> Pairs {
        Pairs::new(rows, columns, false)
    }

    fn new(rows: Tree, columns: Tree, symmetric: bool) -> Pairs {
        let largest = |level: u32| rows.largest(level).max(columns.largest(level));
        let first = (0..columns.depth).find(|&level| largest(level) <= LARGEST).unwrap_or(columns.depth);
        Pairs { rows, columns, symmetric, first }
    }

    /// Where the rows of a block are, and where its columns are.
    pub fn ranges(self, id: Id) -> [Range<usize>; 2] {
        [self.rows.range(id.level, id.a), self.columns.range(id.level, id.b)]
    }

    pub fn shape(self, id: Id) -> Shape {
        let [rows, columns] = self.ranges(id);
        match self.is_diagonal(id) {
            true => Shape::Symmetric { size: rows.len() },
            false => Shape::Full { rows: rows.len(), columns: columns.len() },
        }
    }

    pub fn is_leaf(self, id: Id) -> bool {
        id.level == self.columns.depth
    }

    /// Whether it is its own mirror image.
    pub fn is_diagonal(self, id: Id) -> bool {
        self.symmetric && id.a == id.b
    }

    /// Whether its mirror image is another block, which is meant too.
    pub fn is_mirrored(self, id: Id) -> bool {
        self.symmetric && id.a != id.b
    }

    /// The blocks that a block splits into.
    pub fn children(self, id: Id) -> impl Iterator<Item = Id> {
        let Id { level, a, b } = id;
        let fourth = (!self.is_diagonal(id)).then_some((2 * a + 1, 2 * b));
        let pairs = [(2 * a, 2 * b), (2 * a, 2 * b + 1), (2 * a + 1, 2 * b + 1)].into_iter().chain(fourth);
        pairs.map(move |(a, b)| Id { level: level + 1, a, b })
    }

    /// All blocks of a level.
    pub fn of_level(self, level: u32) -> impl Iterator<Item = Id> {
        let count = self.columns.count(level);
        let start = move |a| if self.symmetric { a } else { 0 };
        (0..self.rows.count(level)).flat_map(move |a| (start(a)..count).map(move |b| Id { level, a, b }))
    }

    /// Its place among them.
    pub fn place(self, id: Id) -> usize {
        let skipped = if self.symmetric { id.a * (id.a + 1) / 2 } else { 0 };
        id.a * self.columns.count(id.level) + id.b - skipped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_every_entry_once_at_every_level_and_stand_at_their_place() {
        let tree = |n, roots| Tree { n, roots, depth: 3 };
        let pairs = [Pairs::symmetric(tree(53, 1)), Pairs::rectangular(tree(70, 3), tree(53, 1))];
        for pairs in pairs {
            let mut ids: Vec<Id> = pairs.of_level(0).collect();
            for level in 0..=3 {
                assert!(ids.iter().all(|id| pairs.of_level(level).nth(pairs.place(*id)) == Some(*id)));
                let mut times = vec![0; pairs.rows.n * 53];
                for &id in &ids {
                    let [rows, columns] = pairs.ranges(id);
                    for (i, j) in rows.flat_map(|i| columns.clone().map(move |j| (i, j))) {
                        times[i * 53 + j] += 1;
                        if pairs.is_mirrored(id) {
                            times[j * 53 + i] += 1;
                        }
                    }
                }
                assert!(times.iter().all(|t| *t == 1), "level {level} of {pairs:?}");
                ids = ids.into_iter().flat_map(|id| pairs.children(id)).collect();
            }
        }
    }
}
