//! Fine patches that hang together.

use glam::Vec3;
use radfile::Patches;

use crate::{
    sets::{join, root},
    ward::CONE,
};

/// Patches that touch and face alike, directly or through others, within cells of `size` metres: what one voxel of that
/// size would make of them, about. For every patch the first of its region, `None` if it is not kept.
pub fn regions(patches: &Patches, kept: &[bool], touches: &[[u32; 2]], size: f32) -> Vec<Option<u32>> {
    let cell = |p: u32| patches.position[p as usize].map(|x| (x / size).floor() as i64);
    let normal = |p: u32| Vec3::from(patches.normal[p as usize]).as_dvec3();
    let mut parent: Vec<u32> = (0..patches.len() as u32).collect();
    for &[a, b] in touches {
        if cell(a) == cell(b) && normal(a).dot(normal(b)) >= CONE {
            join(&mut parent, a, b);
        }
    }
    (0..patches.len() as u32).map(|p| kept[p as usize].then(|| root(&mut parent, p))).collect()
}
