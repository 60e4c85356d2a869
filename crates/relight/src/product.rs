//! All bounces at once: H_ind = A^{-1/2} K A^{1/2} (ρ H⁰) with the packed K, docs/theory.md (4.3).

use radfile::Patches;

use crate::operator::{Operator, Workspace};

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

    /// H_ind, W/m², of the direct irradiance `direct`; nowhere below 0.
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
            *h = h.map(|v| not_negative(v / root));
        }
        &self.received
    }
}

/// Irradiance that packed numbers give: their errors have either sign, and where it is all but dark they may take more than
/// there is. What is no number stays so.
pub(crate) fn not_negative(irradiance: f32) -> f32 {
    if irradiance < 0.0 { 0.0 } else { irradiance }
}

/// Indirect irradiance of the patches in one frame, W/m², from their direct irradiance.
///
/// # Panics
///
/// As [`Bounces`].
pub fn indirect(patches: &Patches, operator: &Operator, direct: &[[f32; 3]]) -> Vec<[f32; 3]> {
    Bounces::new(patches, operator).indirect(direct).to_vec()
}
