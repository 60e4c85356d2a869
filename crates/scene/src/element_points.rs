//! The points at which the direct light of elements is looked up.

use std::ops::Range;

use glam::Vec3;
use radfile::{Elements, Mesh, Patches};

use crate::{PatchSampler, Sobol, SurfacePoint, hash};

/// Points of all elements. Shared by both run times.
pub struct ElementPoints {
    /// The points, those of one element together.
    pub points: Vec<SurfacePoint>,
    start: Vec<u32>,
}

impl ElementPoints {
    /// Those that the elements have, or else `count` for each patch; then there must be one element a patch.
    ///
    /// # Panics
    ///
    /// If there are more elements than patches, but no points: a bug in the caller.
    pub fn new(mesh: &Mesh, patches: &Patches, elements: &Elements, count: u32) -> ElementPoints {
        if elements.point.is_empty() {
            assert_eq!(elements.len(), patches.len(), "points, or one element a patch");
            return ElementPoints::drawn(patches, count);
        }
        let point = |(position, face): (&[f32; 3], &u32)| {
            let [a, b, c] = mesh.corners((face / 2) as usize).map(|p| Vec3::from(p).as_dvec3());
            let front = (b - a).cross(c - a).normalize_or_zero().as_vec3();
            let normal = if face.is_multiple_of(2) { front } else { -front };
            SurfacePoint { position: Vec3::from(*position), normal, triangle: face / 2 }
        };
        let points = elements.point.iter().zip(&elements.point_face).map(point).collect();
        ElementPoints { points, start: elements.point_start.clone() }
    }

    fn drawn(patches: &Patches, count: u32) -> ElementPoints {
        let sampler = PatchSampler::new(patches);
        let of_patch = |patch: usize| {
            let (sobol, sampler) = (Sobol::new(hash(0x9a7c, patch as u32)), &sampler);
            (0..count).map(move |i| {
                let [x, y, ..] = sobol.sample(i);
                sampler.point(patch, x, y)
            })
        };
        let points = (0..patches.len()).flat_map(of_patch).collect();
        ElementPoints { points, start: (0..=patches.len() as u32).map(|p| p * count).collect() }
    }

    /// Which points those of an element are.
    pub fn of(&self, element: usize) -> Range<usize> {
        self.start[element] as usize..self.start[element + 1] as usize
    }
}
