//! Which patches see any other.
//!
//! A patch all of whose rays leave the scene, or meet only faces without patches (back sides of
//! one-sided meshes), neither receives nor passes on reflected light: outer sides of buildings,
//! mostly. It would be a row and a column of zeros.

use radfile::{Patches, Progress, face_id};
use rayon::prelude::*;
use scene::{PatchSampler, Rays, Sobol, cosine_direction, hash};

/// For every patch whether it sees a face with patches, and how many rays that took.
pub fn seen(patches: &Patches, rays: &Rays, count: u32, seed: u32, progress: &dyn Progress) -> (Vec<bool>, u64) {
    if count == 0 {
        return (vec![true; patches.len()], 0);
    }
    progress.begin("visibility of patches", patches.len() as u64);
    let sampler = PatchSampler::new(patches);
    let results: Vec<(bool, u32)> = (0..patches.len())
        .into_par_iter()
        .map(|patch| {
            let cast = (0..count).find(|&ray| hits(patches, &sampler, rays, patch, ray, seed));
            progress.advance(1);
            (cast.is_some(), cast.map_or(count, |ray| ray + 1))
        })
        .collect();
    let cast = results.iter().map(|r| u64::from(r.1)).sum();
    (results.into_iter().map(|r| r.0).collect(), cast)
}

/// Whether one ray of a patch meets a face that has patches.
fn hits(patches: &Patches, sampler: &PatchSampler, rays: &Rays, patch: usize, ray: u32, seed: u32) -> bool {
    let [x, y, z, w] = Sobol::new(hash(seed, patch as u32)).sample(ray);
    let point = sampler.point(patch, x, y);
    let origin = rays.off_surface(point.position, point.normal);
    let direction = cosine_direction(point.normal, z, w);
    rays.closest(origin, direction, f32::INFINITY, point.triangle).is_some_and(|hit| {
        let face = face_id(hit.triangle, hit.side) as usize;
        patches.locator.face_start[face] < patches.locator.face_start[face + 1]
    })
}
