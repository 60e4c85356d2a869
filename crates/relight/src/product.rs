//! All bounces at once: H_ind = A^{-1/2} K A^{1/2} (ρ H⁰) with the packed K, docs/theory.md (4.3).

use radfile::{PackedOperator, Patches};
use rayon::prelude::*;

use crate::operator::{Operator, Workspace};

/// Partial sums of a row: independent, so that the processor adds several at a time.
const LANES: usize = 8;

/// y = K x in three colours; `x` is in the order of patches. Rows are decoded four at a time and
/// never kept, so the memory is that of the packed operator.
///
/// # Panics
///
/// If `x` has not one value a patch: a bug in the caller.
pub fn multiply(packed: &PackedOperator, x: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let n = packed.packing.n as usize;
    assert_eq!(x.len(), n, "one value a patch of the operator");
    let colours: [Vec<f32>; 3] = std::array::from_fn(|c| x.iter().map(|v| v[c]).collect());
    let mut y = vec![[0.0; 3]; n];
    let decoder = packed.decoder();
    y.par_chunks_mut(4).enumerate().for_each_init(
        || vec![0.0; 4 * n],
        |rows, (block_row, y)| {
            for channel in 0..packed.packing.channels as usize {
                decoder.rows(channel, block_row, rows);
                for (i, y) in y.iter_mut().enumerate() {
                    let row = &rows[i * n..][..n];
                    if packed.packing.channels == 1 {
                        *y = std::array::from_fn(|c| dot(row, &colours[c]));
                    } else {
                        y[channel] = dot(row, &colours[channel]);
                    }
                }
            }
        },
    );
    y
}

/// Sum of products in double precision, always in the same order.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut lanes = [0.0f64; LANES];
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            lanes[lane] += f64::from(a[lane]) * f64::from(b[lane]);
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum();
    (lanes.iter().sum::<f64>() + rest) as f32
}

/// Indirect irradiance of the patches frame after frame, without taking memory for each.
pub struct Bounces<'a> {
    operator: &'a Operator<'a>,
    patches: &'a Patches,
    /// √A.
    root: Vec<f32>,
    sent: Vec<[f32; 3]>,
    received: Vec<[f32; 3]>,
    workspace: Workspace,
}

impl<'a> Bounces<'a> {
    /// For the patches that the operator is of.
    ///
    /// # Panics
    ///
    /// If it is of another number of patches: a bug in the caller.
    pub fn new(patches: &'a Patches, operator: &'a Operator<'a>) -> Bounces<'a> {
        assert_eq!(operator.patches(), patches.len(), "the operator of these patches");
        let zero = vec![[0.0; 3]; patches.len()];
        let root = patches.area.iter().map(|a| a.sqrt()).collect();
        Bounces { operator, patches, root, sent: zero.clone(), received: zero, workspace: operator.workspace() }
    }

    /// H_ind, W/m², of the direct irradiance `direct`.
    ///
    /// # Panics
    ///
    /// If there is not one value a patch: a bug in the caller.
    pub fn indirect(&mut self, direct: &[[f32; 3]]) -> &[[f32; 3]] {
        assert_eq!(direct.len(), self.root.len(), "one value a patch");
        let reflectance = &self.patches.reflectance;
        for (i, sent) in self.sent.iter_mut().enumerate() {
            *sent = std::array::from_fn(|c| self.root[i] * reflectance[i][c] * direct[i][c]);
        }
        self.operator.multiply(reflectance, &self.sent, &mut self.received, &mut self.workspace);
        for (h, root) in self.received.iter_mut().zip(&self.root) {
            *h = h.map(|v| v / root);
        }
        &self.received
    }
}

/// Indirect irradiance of the patches in one frame, W/m², from their direct irradiance.
///
/// # Panics
///
/// As [`Bounces`].
pub fn indirect(patches: &Patches, operator: &Operator, direct: &[[f32; 3]]) -> Vec<[f32; 3]> {
    Bounces::new(patches, operator).indirect(direct).to_vec()
}
