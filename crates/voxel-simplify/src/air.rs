//! Which patches stand in the same air.
//!
//! Where a ray passes from one patch to another, light can too. Patches linked by rays, directly or
//! through others, make an airspace; the sky belongs to that of every patch with a ray that leaves
//! the scene. Two patches of different airspaces must never share a radiosity: a sealed room would
//! be lit through its wall.

use radfile::Patches;
use rayon::prelude::*;
use scene::{PatchSampler, Rays, Sobol, cosine_direction, hash, land};

use crate::sets::{join, root};

/// Rays a patch.
const RAYS: u32 = 32;

/// Airspaces of patches.
pub struct Air {
    /// For every patch a number that it shares with the patches of its airspace.
    space: Vec<u32>,
    /// For every such number, the area of the airspace's patches, m²; infinite where there is sky.
    area: Vec<f64>,
    /// For every patch the share of back sides among the sides that it sees.
    back_share: Vec<f32>,
}

/// What one patch sees.
#[derive(Default)]
struct View {
    /// Patches, and the number of patches for the sky; sorted, each once.
    met: Vec<u32>,
    fronts: u32,
    backs: u32,
}

impl Air {
    /// Explores from all patches that `kept` holds; the others stand alone.
    pub fn explore(patches: &Patches, kept: &[bool], rays: &Rays, seed: u32) -> Air {
        let sampler = PatchSampler::new(patches);
        let n = patches.len();
        let sky = n as u32;
        let look = |patch| if kept[patch] { look(patches, &sampler, rays, patch, seed) } else { View::default() };
        let views: Vec<View> = (0..n).into_par_iter().map(look).collect();
        let mut parent: Vec<u32> = (0..=sky).collect();
        for (patch, view) in (0..).zip(&views) {
            for &other in &view.met {
                join(&mut parent, patch, other);
            }
        }
        let space: Vec<u32> = (0..=sky).map(|p| root(&mut parent, p)).collect();
        let mut area = vec![0.0; n + 1];
        for patch in (0..n).filter(|&p| kept[p]) {
            area[space[patch] as usize] += f64::from(patches.area[patch]);
        }
        area[space[n] as usize] = f64::INFINITY;
        let back_share = views.iter().map(|v| v.backs as f32 / (v.fronts + v.backs).max(1) as f32).collect();
        Air { space, area, back_share }
    }

    /// Whether two patches stand in the same air.
    pub fn is_shared(&self, a: usize, b: usize) -> bool {
        self.space(a) == self.space(b)
    }

    /// A number that patches in the same air have in common.
    pub fn space(&self, patch: usize) -> u32 {
        self.space[patch]
    }

    /// Share of back sides among the sides that a patch sees.
    pub fn back_share(&self, patch: usize) -> f32 {
        self.back_share[patch]
    }

    /// Area of all patches in the air of one, m²; infinite if the sky is part of it.
    pub fn area(&self, patch: usize) -> f64 {
        self.area[self.space[patch] as usize]
    }
}

/// Casts the rays of one patch.
fn look(patches: &Patches, sampler: &PatchSampler, rays: &Rays, patch: usize, seed: u32) -> View {
    let mut view = View::default();
    let sequence = Sobol::new(hash(seed, patch as u32));
    for ray in 0..RAYS {
        let [x, y, z, w] = sequence.sample(ray);
        let point = sampler.point(patch, x, y);
        let origin = rays.off_surface(point.position, point.normal);
        let direction = cosine_direction(point.normal, z, w);
        let Some(landing) = land(rays, &patches.locator, origin, direction, point.triangle) else {
            view.met.push(patches.len() as u32);
            continue;
        };
        match landing.face.is_multiple_of(2) {
            true => view.fronts += 1,
            false => view.backs += 1,
        }
        view.met.extend(landing.patch);
    }
    view.met.sort_unstable();
    view.met.dedup();
    view
}
