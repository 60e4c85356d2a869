//! Which patches see any other.
//!
//! A patch all of whose rays leave the scene, or meet only faces without patches (back sides of
//! one-sided meshes), neither receives nor passes on reflected light: outer sides of buildings,
//! mostly. It would be a row and a column of zeros. Who sees little of a small thing may miss it with
//! all its rays; what the small thing's rays meet counts as well.

use radfile::{Patches, Progress};
use rayon::prelude::*;
use scene::{PatchSampler, Rays, Sobol, cosine_direction, hash, land};

/// For every patch whether it sees another or is seen by one, and how many rays that took.
pub fn seen(patches: &Patches, rays: &Rays, count: u32, seed: u32, progress: &dyn Progress) -> (Vec<bool>, u64) {
    if count == 0 {
        return (vec![true; patches.len()], 0);
    }
    progress.begin("visibility of patches", patches.len() as u64);
    let sampler = PatchSampler::new(patches);
    let target = |patch: usize, ray: u32| target(patches, &sampler, rays, patch, ray, seed);
    let results: Vec<(bool, u32)> = (0..patches.len())
        .into_par_iter()
        .map(|patch| {
            let cast = (0..count).find(|&ray| target(patch, ray).is_some());
            progress.advance(1);
            (cast.is_some(), cast.map_or(count, |ray| ray + 1))
        })
        .collect();
    let mut cast = results.iter().map(|r| u64::from(r.1)).sum();
    let mut seen: Vec<bool> = results.into_iter().map(|r| r.0).collect();
    if seen.contains(&false) {
        let lookers: Vec<usize> = (0..patches.len()).filter(|&patch| seen[patch]).collect();
        let met = |&patch: &usize| -> Vec<u32> {
            (0..count).filter_map(|ray| target(patch, ray)).filter(|&other| !seen[other as usize]).collect()
        };
        let found: Vec<Vec<u32>> = lookers.par_iter().map(met).collect();
        cast += lookers.len() as u64 * u64::from(count);
        found.into_iter().flatten().for_each(|patch| seen[patch as usize] = true);
    }
    (seen, cast)
}

/// The patch that one ray of a patch meets.
fn target(patches: &Patches, sampler: &PatchSampler, rays: &Rays, patch: usize, ray: u32, seed: u32) -> Option<u32> {
    let [x, y, z, w] = Sobol::new(hash(seed, patch as u32)).sample(ray);
    let point = sampler.point(patch, x, y);
    let origin = rays.off_surface(point.position, point.normal);
    let direction = cosine_direction(point.normal, z, w);
    land(rays, &patches.locator, origin, direction, point.triangle)?.patch
}
