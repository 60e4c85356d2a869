//! Which places of a grid are in the open, and which lie inside of something.
//!
//! From within a closed solid all rays meet the back sides of its triangles, or sides that have no patch. Back sides
//! alone do not tell: two rooms may have one sheet for a wall, and it shows one of them its back. So a place that sees
//! backs is in the open, too, if it is in plain sight of one beside it that is.
//!
//! Source: Z. Majercik et al., Dynamic Diffuse Global Illumination with Ray-Traced Irradiance Fields, JCGT 8(2), 2019,
//! whose probes are inside of something where more than a quarter of the rays meet back faces.

use glam::Vec3;
use rayon::prelude::*;
use scene::{NO_TRIANGLE, Sobol, hash, land};

use crate::{
    Senders,
    spread::{NONE, spread},
};

/// Rays of each place.
const RAYS: u32 = 512;
/// The share of them that must be seen, by front sides or by any.
const MOST: f32 = 0.75;

/// What rays in all directions meet, as shares.
struct View {
    /// The sky, or a side with a patch.
    seen: f32,
    /// The sky, or a front side with a patch.
    fronts: f32,
}

/// For each of the places, one in the middle of every cell of a grid, whether it is in the open.
pub fn open_air(count: [u32; 3], places: &[Vec3], senders: &Senders, seed: u32) -> Vec<bool> {
    let look = |(number, &place): (usize, &Vec3)| view(senders, place, &Sobol::new(hash(seed, number as u32)));
    let views: Vec<View> = places.par_iter().enumerate().map(look).collect();
    let sees_fronts = |view: &View| view.fronts >= MOST;
    // Where no place does, the scene is inside out, and its windings tell nothing.
    let wound = views.iter().any(sees_fronts);
    let sure = |view: &View| if sees_fronts(view) || !wound && view.seen >= MOST { 0 } else { NONE };
    let mut open: Vec<u32> = views.iter().map(sure).collect();
    spread(count, &mut open, |cell, beside, _| {
        views[cell].seen >= MOST && senders.rays.visible(places[beside], places[cell], NO_TRIANGLE)
    });
    open.iter().map(|&number| number != NONE).collect()
}

fn view(senders: &Senders, place: Vec3, sobol: &Sobol) -> View {
    let (mut seen, mut fronts) = (0, 0);
    for k in 0..RAYS {
        let [u, v, ..] = sobol.sample(k);
        match land(senders.rays, &senders.patches.locator, place, direction(u, v), NO_TRIANGLE) {
            Some(landing) if landing.patch.is_none() => {}
            // Faces with odd numbers are back sides.
            Some(landing) if landing.face % 2 == 1 => seen += 1,
            _ => (seen, fronts) = (seen + 1, fronts + 1),
        }
    }
    let share = |rays: u32| rays as f32 / RAYS as f32;
    View { seen: share(seen), fronts: share(fronts) }
}

/// Directions of equal density over the sphere.
fn direction(u: f32, v: f32) -> Vec3 {
    let (z, (sin, cos)) = (1.0 - 2.0 * u, (std::f32::consts::TAU * v).sin_cos());
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(radius * cos, radius * sin, z)
}
