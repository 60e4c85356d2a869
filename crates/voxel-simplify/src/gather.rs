//! Small separate parts share patches where there are too many of them.
//!
//! The blossoms of a capital, the slats of a chair: parts that touch nothing are patches of their
//! own at any voxel size, and a scene may have more of them than the patches that were asked for.
//! Then small patches of one voxel that face roughly the same way are taken together, or join a
//! large one. Parts that stand in different air never are: from a point above one to a point above
//! the other a ray must pass, so no light gets through a wall this way.

use std::collections::BTreeMap;

use glam::Vec3;
use radfile::Patches;
use rayon::prelude::*;
use scene::{NO_TRIANGLE, Rays};

use crate::{air::Air, draft::is_back, surface::Surface};

/// Patches smaller than this part of a voxel's side are small.
const SMALL: f32 = 0.15;
/// Cosine of 60°.
const CONE: f32 = 0.5;
/// A closed pocket with less area than this, in voxel sides, holds no light that anybody looks at.
const POCKET: f64 = 1.0;
/// Below this part of a voxel's side the same air is enough; above it a ray must pass.
const TINY: f32 = 0.03;
/// Neighbours that are tried, the likeliest first.
const TRIES: usize = 6;
/// Heights of the points above the parts between which a ray must pass, in voxels.
const HEIGHTS: [f32; 3] = [0.02, 0.1, 0.4];

/// Area below which a patch is small among voxels of `size` metres, m².
pub fn small_area(size: f32) -> f32 {
    SMALL * size * size
}

/// Number of small patches among those that own themselves.
pub fn count_small(patches: &Patches, owner: &[Option<u32>]) -> usize {
    let small = small_area(patches.locator.cell_size);
    (0..patches.len()).filter(|&p| owner[p] == Some(p as u32) && patches.area[p] < small).count()
}

/// Joins small patches: for each of them, `owner` then names the one that it is part of.
///
/// Patches in a closed pocket of air lose theirs if all that is in the pocket is smaller than a side of a voxel.
pub fn gather(patches: &Patches, surface: &Surface, rays: &Rays, air: &Air, owner: &mut [Option<u32>]) {
    let pocket = POCKET * f64::from(patches.locator.cell_size).powi(2);
    for (patch, owner) in owner.iter_mut().enumerate() {
        *owner = owner.filter(|_| air.area(patch) > pocket);
    }
    let mut cells: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for patch in (0..patches.len()).filter(|&p| owner[p] == Some(p as u32)) {
        cells.entry(patches.locator.cell_of(patches.position[patch])).or_default().push(patch);
    }
    let cells: Vec<Vec<usize>> = cells.into_values().collect();
    let size = patches.locator.cell_size;
    let joined: Vec<Vec<(usize, usize)>> =
        cells.par_iter().map(|cell| Cell::new(patches, surface, rays, air, size, cell).join_small()).collect();
    let mut root: Vec<u32> = (0..patches.len() as u32).collect();
    for (patch, to) in joined.into_iter().flatten() {
        root[patch] = to as u32;
    }
    for owner in owner.iter_mut().flatten() {
        *owner = root[*owner as usize];
    }
}

/// The patches of one cell.
pub struct Cell<'a> {
    patches: &'a Patches,
    rays: &'a Rays,
    air: &'a Air,
    /// Edge of the cell, metres.
    size: f32,
    /// Smallest first.
    members: Vec<Member>,
}

/// A patch and what has joined it.
struct Member {
    patch: usize,
    area: f32,
    /// Sum of area times normal, and its direction.
    normal: Vec3,
    facing: Vec3,
    emits: bool,
    /// Whether it has back sides only: then it is likely to lie inside a solid.
    back: bool,
    /// Place in `members` of what it has joined.
    into: Option<usize>,
}

impl<'a> Cell<'a> {
    pub fn new(
        patches: &'a Patches,
        surface: &Surface,
        rays: &'a Rays,
        air: &'a Air,
        size: f32,
        cell: &[usize],
    ) -> Cell<'a> {
        let member = |&patch: &usize| Member {
            patch,
            area: patches.area[patch],
            normal: Vec3::from(patches.normal[patch]) * patches.area[patch],
            facing: Vec3::from(patches.normal[patch]),
            emits: surface.shines(patches.pieces_of(patch)),
            back: is_back(patches, patch),
            into: None,
        };
        let mut members: Vec<Member> = cell.iter().map(member).collect();
        members.sort_by(|a, b| a.area.total_cmp(&b.area).then(a.patch.cmp(&b.patch)));
        Cell { patches, rays, air, size, members }
    }

    /// Pairs of a patch and the one that it is part of at last.
    fn join_small(mut self) -> Vec<(usize, usize)> {
        let small = small_area(self.size);
        for s in 0..self.members.len() {
            if self.members[s].area < small
                && let Some(to) = self.partner(s)
            {
                let (area, normal) = (self.members[s].area, self.members[s].normal);
                self.members[s].into = Some(to);
                let larger = &mut self.members[to];
                larger.area += area;
                larger.normal += normal;
                larger.facing = larger.normal.normalize_or_zero();
            }
        }
        let root = |mut s: usize| {
            while let Some(to) = self.members[s].into {
                s = to;
            }
            self.members[s].patch
        };
        (0..self.members.len()).map(|s| (self.members[s].patch, root(s))).collect()
    }

    /// Pairs of a patch that is small in the eyes of `is_small` and the best of the larger ones that it may join.
    pub fn pairs(&self, is_small: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
        let few = (0..self.members.len()).filter(|&s| is_small(self.members[s].patch));
        few.filter_map(|s| Some([s, self.partner(s)?].map(|m| self.members[m].patch))).collect()
    }

    /// The best of the larger patches that `s` may join.
    fn partner(&self, s: usize) -> Option<usize> {
        let own = &self.members[s];
        let position = self.position(s);
        let mut candidates: Vec<(f32, usize)> = Vec::new();
        for (m, other) in self.members.iter().enumerate().skip(s + 1) {
            let cosine = own.facing.dot(other.facing);
            let alike = (own.emits, own.back) == (other.emits, other.back);
            if cosine >= CONE && alike && self.air.is_shared(own.patch, other.patch) {
                let distance = self.position(m).distance(position) / self.size;
                candidates.push((distance - cosine, m));
            }
        }
        let order = |a: &(f32, usize), b: &(f32, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        if candidates.len() > TRIES {
            candidates.select_nth_unstable_by(TRIES, order);
            candidates.truncate(TRIES);
        }
        candidates.sort_by(order);
        let tiny = own.area < TINY * self.size.powi(2);
        let near = candidates.iter().map(|&(_, m)| m).find(|&m| self.sees_past(s, m));
        near.or(candidates.first().map(|&(_, m)| m).filter(|_| tiny))
    }

    fn position(&self, s: usize) -> Vec3 {
        Vec3::from(self.patches.position[self.members[s].patch])
    }

    /// Whether a ray passes from above one patch to above the other.
    fn sees_past(&self, s: usize, t: usize) -> bool {
        let above = |m: usize, height: f32| {
            let normal = Vec3::from(self.patches.normal[self.members[m].patch]);
            let foot = self.rays.off_surface(self.position(m), normal);
            let top = foot + height * self.size * normal;
            self.rays.visible(foot, top, NO_TRIANGLE).then_some(top)
        };
        HEIGHTS.iter().any(|&height| {
            above(s, height).zip(above(t, height)).is_some_and(|(p, q)| self.rays.visible(p, q, NO_TRIANGLE))
        })
    }
}
