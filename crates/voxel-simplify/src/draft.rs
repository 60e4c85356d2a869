//! Patches before it is known which of them are seen and what colour they have.

use glam::DVec3;
use radfile::{Patches, Piece};

use crate::assemble::nearest;

/// Every patch that the grid yields.
pub struct Draft {
    /// Reflectance and emission are still zero.
    pub patches: Patches,
    /// The surface that each patch takes its colour from.
    pub coat: Coat,
    /// Pairs of patches that touch, the smaller number first, each pair once: all, or those with a small one.
    pub touches: Vec<[u32; 2]>,
    pub cells: usize,
    pub pieces: usize,
    pub merged: usize,
    /// Area that is in no patch because it is too small, all used sides, m².
    pub sliver_area: f64,
}

/// Weighted pieces of the surface, gathered by patch.
#[derive(Default)]
pub struct Coat {
    /// Offsets into `parts`, patches + 1.
    pub start: Vec<u32>,
    /// Pieces and their weights.
    pub parts: Vec<(Piece, f32)>,
}

impl Coat {
    /// The parts of one patch.
    pub fn of(&self, patch: usize) -> &[(Piece, f32)] {
        &self.parts[self.start[patch] as usize..self.start[patch + 1] as usize]
    }
}

/// Whether a patch has back sides only.
pub fn is_back(patches: &Patches, patch: usize) -> bool {
    patches.pieces_of(patch).iter().all(|piece| piece.face % 2 == 1)
}

/// The final patches: `owner` names for each drafted patch the one that it is part of, `None` if it is dropped.
pub fn compose(drafted: &Patches, owner: &[Option<u32>]) -> Patches {
    let mut members: Vec<(u32, usize)> = (0..owner.len()).filter_map(|p| Some((owner[p]?, p))).collect();
    members.sort_unstable();
    let mut number = vec![None; owner.len()];
    let mut patches = Patches { piece_start: vec![0], ..Patches::default() };
    for group in members.chunk_by(|a, b| a.0 == b.0) {
        for &(_, member) in group {
            number[member] = Some(patches.area.len() as u32);
            patches.pieces.extend_from_slice(drafted.pieces_of(member));
        }
        push_mean(drafted, group, &mut patches);
        patches.piece_start.push(patches.pieces.len() as u32);
    }
    patches.locator = drafted.locator.renumbered(|drafted| number[drafted as usize]);
    patches
}

/// Adds the values of one patch, means over its members by area. Its pieces are already there.
fn push_mean(drafted: &Patches, group: &[(u32, usize)], patches: &mut Patches) {
    if let [(_, only)] = *group {
        patches.position.push(drafted.position[only]);
        patches.normal.push(drafted.normal[only]);
        patches.area.push(drafted.area[only]);
        patches.reflectance.push(drafted.reflectance[only]);
        patches.emission.push(drafted.emission[only]);
        return;
    }
    let area: f64 = group.iter().map(|&(_, m)| f64::from(drafted.area[m])).sum();
    let mean = |values: &[[f32; 3]]| -> DVec3 {
        let weighed =
            |&(_, m): &(u32, usize)| f64::from(drafted.area[m]) / area * DVec3::from_array(values[m].map(f64::from));
        group.iter().map(weighed).sum()
    };
    let first_piece = *patches.piece_start.last().expect("starts with 0") as usize;
    let position = nearest(&patches.pieces[first_piece..], mean(&drafted.position));
    let normal = mean(&drafted.normal).try_normalize();
    patches.position.push(position.as_vec3().to_array());
    patches.normal.push(normal.map_or(drafted.normal[group[0].1], |n| n.as_vec3().to_array()));
    patches.area.push(area as f32);
    patches.reflectance.push(mean(&drafted.reflectance).as_vec3().to_array());
    patches.emission.push(mean(&drafted.emission).as_vec3().to_array());
}
