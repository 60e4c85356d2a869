//! Small separate parts that may share a patch though they do not touch.
//!
//! A scene may have more parts than patches are wanted. The rules are those of `gather`: what faces alike in one cell,
//! in the same air, with a ray from one to the other.

use std::collections::BTreeMap;

use radfile::Patches;
use rayon::prelude::*;
use scene::Rays;

use crate::{
    air::Air,
    gather::{Cell, small_area},
    surface::Surface,
};

/// Parts of a scene.
pub struct Parts<'a> {
    /// For every patch the part that it belongs to, `None` if it is dropped.
    pub part: &'a [Option<u32>],
    /// Area of every part, m².
    pub area: &'a [f64],
}

/// Pairs of patches that may be joined for the sake of small parts, in cells of `size` metres. In each cell a part is
/// represented by its largest patch.
pub fn pairs(patches: &Patches, surface: &Surface, rays: &Rays, air: &Air, size: f32, parts: &Parts) -> Vec<[u32; 2]> {
    let mut largest: BTreeMap<([i64; 3], u32), usize> = BTreeMap::new();
    for (patch, part) in (0..).zip(parts.part).filter_map(|(p, part)| Some((p, (*part)?))) {
        let cell = patches.position[patch].map(|x| (x / size).floor() as i64);
        let best = largest.entry((cell, part)).or_insert(patch);
        if patches.area[patch] > patches.area[*best] {
            *best = patch;
        }
    }
    let mut cells: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for (&(cell, _), &patch) in &largest {
        cells.entry(cell).or_default().push(patch);
    }
    let cells: Vec<Vec<usize>> = cells.into_values().collect();
    let small = f64::from(small_area(size));
    let is_small = |patch: usize| parts.part[patch].is_some_and(|part| parts.area[part as usize] < small);
    let found: Vec<Vec<[usize; 2]>> =
        cells.par_iter().map(|cell| Cell::new(patches, surface, rays, air, size, cell).pairs(is_small)).collect();
    found.into_iter().flatten().map(|pair| pair.map(|p| p as u32)).collect()
}
