//! Classical radiosity, the yardstick of the paper: the form factors in f32, bounce after bounce.
//!
//! H ← F ρ (H⁰ + H), k times, gives the first k bounces of indirect light. Three colours go through one pass
//! over F; what makes it slow is that F comes from memory k times.

use pulp::Arch;
use radfile::FormFactors;
use rayon::prelude::*;

use super::{
    Product,
    case::Case,
    loops::{ROWS, four_rows},
};

/// Bounces of a frame.
pub const BOUNCES: u32 = 8;
/// Rows that a task handles.
const TASK: usize = 16 * ROWS;

/// Bounces with dense form factors.
pub struct Classical<'a> {
    factors: &'a FormFactors<'static>,
    reflectance: &'a [[f32; 3]],
    root: Vec<f32>,
    /// ρ (H⁰ + H), a colour each.
    sent: [Vec<f32>; 3],
    /// H.
    received: Vec<[f32; 3]>,
    bounces: u32,
    arch: Arch,
}

impl<'a> Classical<'a> {
    /// [`BOUNCES`] for the patches and form factors of a case.
    pub fn new(case: &'a Case) -> Classical<'a> {
        Classical::with(case, BOUNCES)
    }

    /// So many bounces.
    pub fn with(case: &'a Case, bounces: u32) -> Classical<'a> {
        let n = case.len();
        Classical {
            factors: &case.factors,
            reflectance: &case.patches.reflectance,
            root: case.patches.area.iter().map(|a| a.sqrt()).collect(),
            sent: std::array::from_fn(|_| vec![0.0; n]),
            received: vec![[0.0; 3]; n],
            bounces,
            arch: Arch::new(),
        }
    }

    /// Bytes of the form factors.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.factors.values)
    }

    fn bounce(&mut self) {
        let (arch, factors, n) = (self.arch, self.factors, self.root.len());
        let sent = self.sent.each_ref().map(|s| &s[..]);
        self.received.par_chunks_mut(TASK).enumerate().for_each(|(task, received)| {
            for (group, received) in received.chunks_mut(ROWS).enumerate() {
                let first = task * TASK + group * ROWS;
                // The last rows are computed twice where there are not four left.
                let rows = std::array::from_fn(|r| factors.row((first + r).min(n - 1)));
                received.copy_from_slice(&four_rows(arch, rows, sent)[..received.len()]);
            }
        });
    }
}

impl Product for Classical<'_> {
    fn multiply(&mut self, x: &[[f32; 3]], y: &mut [[f32; 3]]) {
        self.received.fill([0.0; 3]);
        for _ in 0..self.bounces {
            // x is √A ρ H⁰.
            for (c, sent) in self.sent.iter_mut().enumerate() {
                for (i, sent) in sent.iter_mut().enumerate() {
                    *sent = x[i][c] / self.root[i] + self.reflectance[i][c] * self.received[i][c];
                }
            }
            self.bounce();
        }
        for (i, y) in y.iter_mut().enumerate() {
            *y = self.received[i].map(|h| h * self.root[i]);
        }
    }
}
