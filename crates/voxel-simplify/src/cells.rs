//! Pieces by cell.

use std::ops::Range;

use radfile::CellKey;
use rayon::prelude::*;

use crate::clip::Clips;

/// The numbers of all pieces, in the order of cells.
pub struct Cells {
    order: Vec<u32>,
    /// Cells in increasing order, each with its part of `order`.
    pub runs: Vec<(CellKey, Range<usize>)>,
}

impl Cells {
    pub fn new(clips: &Clips) -> Cells {
        let mut order: Vec<u32> = (0..clips.clips.len() as u32).collect();
        order.par_sort_unstable_by_key(|&c| (clips.clips[c as usize].cell, c));
        let mut runs = Vec::new();
        let mut start = 0;
        for run in order.chunk_by(|&a, &b| clips.clips[a as usize].cell == clips.clips[b as usize].cell) {
            runs.push((clips.clips[run[0] as usize].cell, start..start + run.len()));
            start += run.len();
        }
        Cells { order, runs }
    }

    pub fn of(&self, run: usize) -> &[u32] {
        &self.order[self.runs[run].1.clone()]
    }

    pub fn at(&self, cell: [i64; 3]) -> &[u32] {
        let inside = cell.iter().all(|&c| c >= 0);
        let found = self.runs.binary_search_by_key(&CellKey::new(cell), |r| r.0).ok();
        found.filter(|_| inside).map_or(&[], |run| self.of(run))
    }
}
