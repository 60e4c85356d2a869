//! Insides of solids get coarser patches where a number of patches is asked for.
//!
//! Scenes are full of furniture, columns and thick walls whose back sides see nothing but other back
//! sides. Their meshes are seldom closed, so these cavities are no sealed air and some light does
//! get in; but they may hold half of all surface. There, patches of a block of cells that face the
//! same way are taken together, so that most of the wanted patches are left to where people look.
//!
//! A room modelled inside out has only back sides, too. It is told from a solid by its other side:
//! that of a solid is seen, that of a room is not.

use std::collections::BTreeMap;

use glam::Vec3;
use radfile::Patches;

use crate::{air::Air, draft::is_back, surface::Surface};

/// Part of what a patch sees that must be back sides.
const BACKS: f32 = 0.9;
/// Edge of a block, in cells.
const BLOCK: i64 = 4;
/// Cosine of 35°, as within one cell.
const CONE: f32 = 0.819;
/// Patches further apart than this along their normal stay apart, in cells.
const LEVEL: f32 = 1.0;

/// Patches inside solids, of those that `owner` keeps.
pub fn inside(patches: &Patches, surface: &Surface, air: &Air, owner: &[Option<u32>]) -> Vec<usize> {
    let inside: Vec<usize> = (0..patches.len())
        .filter(|&p| owner[p].is_some() && is_back(patches, p) && air.back_share(p) >= BACKS)
        .filter(|&p| !surface.shines(patches.pieces_of(p)))
        .collect();
    if mostly_solids(patches, owner, &inside) { inside } else { vec![] }
}

/// Joins patches inside solids: for each of them, `owner` then names the one that it is part of.
pub fn coarsen(patches: &Patches, surface: &Surface, air: &Air, owner: &mut [Option<u32>]) {
    let mut blocks: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for patch in inside(patches, surface, air, owner) {
        let cell = patches.locator.cell_of(patches.position[patch]);
        blocks.entry(cell.map(|c| c.div_euclid(BLOCK))).or_default().push(patch);
    }
    for mut block in blocks.into_values() {
        block.sort_by(|&a, &b| patches.area[b].total_cmp(&patches.area[a]).then(a.cmp(&b)));
        let mut roots: Vec<usize> = Vec::new();
        for patch in block {
            match roots.iter().find(|&&root| may_join(patches, air, patch, root)) {
                Some(&root) => owner[patch] = Some(root as u32),
                None => roots.push(patch),
            }
        }
    }
}

/// Whether the front sides of most of these back sides are seen.
fn mostly_solids(patches: &Patches, owner: &[Option<u32>], inside: &[usize]) -> bool {
    let area = |&p: &usize| f64::from(patches.area[p]);
    let front_is_seen = |&p: &usize| {
        let front = patches.pieces_of(p)[0].face - 1;
        patches.locator.patch_at(front, patches.position[p]).is_some_and(|front| owner[front as usize].is_some())
    };
    let all: f64 = inside.iter().map(area).sum();
    let solid: f64 = inside.iter().filter(|&p| front_is_seen(p)).map(area).sum();
    solid > 0.5 * all
}

fn may_join(patches: &Patches, air: &Air, patch: usize, root: usize) -> bool {
    let normal = Vec3::from(patches.normal[root]);
    let height = (Vec3::from(patches.position[patch]) - Vec3::from(patches.position[root])).dot(normal);
    air.is_shared(patch, root)
        && normal.dot(Vec3::from(patches.normal[patch])) >= CONE
        && height.abs() <= LEVEL * patches.locator.cell_size
}
