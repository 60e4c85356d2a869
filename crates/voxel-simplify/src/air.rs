//! Which patches stand in the same air.
//!
//! Where a ray passes from one patch to another, light can too. Patches linked by rays, directly or
//! through others, make an airspace; the sky belongs to that of every patch with a ray that leaves
//! the scene. Two patches of different airspaces must never share a radiosity: a sealed room would
//! be lit through its wall.

use glam::Vec3;
use radfile::{Patches, face_id};
use rayon::prelude::*;
use scene::{PatchSampler, Rays, Sobol, cosine_direction, hash};

/// Rays a patch.
const RAYS: u32 = 32;

/// Airspaces of patches.
pub struct Air {
    /// For every patch a number that it shares with the patches of its airspace.
    space: Vec<u32>,
    /// For every such number, the area of the airspace's patches, m²; infinite where there is sky.
    area: Vec<f64>,
}

impl Air {
    /// Explores from all patches that `kept` holds; the others stand alone.
    pub fn explore(patches: &Patches, kept: &[bool], rays: &Rays, seed: u32) -> Air {
        let sampler = PatchSampler::new(patches);
        let n = patches.len();
        let sky = n as u32;
        let links: Vec<Vec<u32>> = (0..n)
            .into_par_iter()
            .map(|patch| {
                let count = if kept[patch] { RAYS } else { 0 };
                let mut met: Vec<u32> =
                    (0..count).filter_map(|ray| meets(patches, &sampler, rays, patch, ray, seed)).collect();
                met.sort_unstable();
                met.dedup();
                met
            })
            .collect();
        let mut parent: Vec<u32> = (0..=sky).collect();
        for (patch, met) in (0..).zip(&links) {
            for &other in met {
                let (a, b) = (root(&mut parent, patch), root(&mut parent, other));
                // The smaller number wins, so the result does not depend on the order.
                parent[a.max(b) as usize] = a.min(b);
            }
        }
        let space: Vec<u32> = (0..=sky).map(|p| root(&mut parent, p)).collect();
        let mut area = vec![0.0; n + 1];
        for patch in (0..n).filter(|&p| kept[p]) {
            area[space[patch] as usize] += f64::from(patches.area[patch]);
        }
        area[space[n] as usize] = f64::INFINITY;
        Air { space, area }
    }

    /// Whether two patches stand in the same air.
    pub fn is_shared(&self, a: usize, b: usize) -> bool {
        self.space[a] == self.space[b]
    }

    /// Area of all patches in the air of one, m²; infinite if the sky is part of it.
    pub fn area(&self, patch: usize) -> f64 {
        self.area[self.space[patch] as usize]
    }
}

/// The patch that a ray meets, the number of patches for the sky, `None` for a face without patches.
fn meets(patches: &Patches, sampler: &PatchSampler, rays: &Rays, patch: usize, ray: u32, seed: u32) -> Option<u32> {
    let [x, y, z, w] = Sobol::new(hash(seed, patch as u32)).sample(ray);
    let point = sampler.point(patch, x, y);
    let origin = rays.off_surface(point.position, point.normal);
    let direction: Vec3 = cosine_direction(point.normal, z, w);
    match rays.closest(origin, direction, f32::INFINITY, point.triangle) {
        None => Some(patches.len() as u32),
        Some(hit) => {
            let place = (origin + hit.t * direction).to_array();
            patches.locator.patch_at(face_id(hit.triangle, hit.side), place)
        }
    }
}

/// The representative of a set, with the path to it halved.
fn root(parent: &mut [u32], mut at: u32) -> u32 {
    while parent[at as usize] != at {
        let up = parent[parent[at as usize] as usize];
        parent[at as usize] = up;
        at = up;
    }
    at
}
