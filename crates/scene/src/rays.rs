//! Ray queries against triangles: closest hit and visibility, watertight.
//!
//! Boxes come from obvhs' 8-wide compressed BVH, triangles are tested by `triangle_test.rs`. A ray
//! must not slip through where triangles meet, so boxes are padded by more than the rounding of
//! the box test. obvhs ignores boxes that end nearer than 1e-4 along the ray, in units of the
//! ray's direction; every direction is therefore scaled by a power of two to a length at which
//! that is far below the pad of the boxes.

use glam::{Vec3, Vec3A};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::reinsertion::ReinsertionOptimizer,
    cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh},
    ploc::PlocBuilder,
    ray::{Ray, RayHit},
    splits::split_aabbs_preset,
    triangle::Triangle,
};
use radfile::{Mesh, Side};

use crate::triangle_test::{Meeting, ShearedRay};

/// Passed as `ignore` where no triangle is to be ignored.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// Pad of every box, relative to the largest coordinate. The box test rounds by up to 8 epsilon for
/// origins inside the scene, the quantisation of boxes by up to 10.
const BOX_PAD: f32 = 32.0 * f32::EPSILON;
/// Distance that ray origins keep from their surface, relative to the largest coordinate.
const SURFACE_GAP: f32 = 16.0 * f32::EPSILON;

/// A search structure over triangles.
pub struct Rays {
    bvh: CwBvh,
    /// Corners and number of the triangle in each slot of the BVH.
    slots: Vec<Slot>,
    /// Exponent of two that the largest component of every direction is brought to.
    direction_exponent: i32,
    gap: f32,
}

struct Slot {
    corners: [[f32; 3]; 3],
    triangle: u32,
}

/// The nearest triangle along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Number of the triangle.
    pub triangle: u32,
    /// Side that was hit.
    pub side: Side,
    /// Distance in lengths of the direction.
    pub t: f32,
    /// Barycentric weight of the second corner.
    pub u: f32,
    /// Barycentric weight of the third corner.
    pub v: f32,
}

impl Rays {
    /// Builds the structure for all triangles of a mesh.
    pub fn new(mesh: &Mesh) -> Rays {
        Rays::from_triangles(mesh.triangles.len(), |t| mesh.corners(t))
    }

    /// Builds the structure for `count` triangles with finite corners.
    pub fn from_triangles(count: usize, corners: impl Fn(usize) -> [[f32; 3]; 3]) -> Rays {
        let triangles: Vec<[[f32; 3]; 3]> = (0..count).map(corners).collect();
        let largest = triangles.iter().flatten().flatten().fold(1e-20f32, |m, x| m.max(x.abs()));
        let bvh = build(&triangles, largest * BOX_PAD);
        let slot = |&t: &u32| Slot { corners: triangles[t as usize], triangle: t };
        let slots = bvh.primitive_indices.iter().map(slot).collect();
        Rays { bvh, slots, direction_exponent: exponent(largest) - 14, gap: largest * SURFACE_GAP }
    }

    /// The first triangle that a ray from `origin` meets at a distance above 0 and below `limit`
    /// (in lengths of `direction`). The triangle `ignore` is passed through.
    pub fn closest(&self, origin: Vec3, direction: Vec3, limit: f32, ignore: u32) -> Option<Hit> {
        let (ray, sheared, scale) = self.prepare(origin, direction, limit);
        let mut best: Option<(Meeting, u32)> = None;
        let mut nearest = RayHit::none();
        self.bvh.ray_traverse(ray, &mut nearest, |ray, slot| {
            let slot = &self.slots[slot];
            match sheared.meet(&slot.corners) {
                Some(m) if m.t > 0.0 && m.t < ray.tmax && slot.triangle != ignore => {
                    best = Some((m, slot.triangle));
                    m.t
                }
                _ => f32::INFINITY,
            }
        });
        best.map(|(m, triangle)| Hit {
            triangle,
            side: if m.front { Side::Front } else { Side::Back },
            t: m.t * scale,
            u: m.u,
            v: m.v,
        })
    }

    /// Whether nothing but `ignore` lies strictly between two points.
    ///
    /// Points on a surface should be moved off it by [`Rays::off_surface`] first.
    pub fn visible(&self, from: Vec3, to: Vec3, ignore: u32) -> bool {
        self.open(from, to - from, 1.0, ignore)
    }

    /// Whether a ray leaves the scene.
    pub fn escapes(&self, origin: Vec3, direction: Vec3, ignore: u32) -> bool {
        self.open(origin, direction, f32::INFINITY, ignore)
    }

    /// `point`, moved off the surface on the side of the unit vector `normal` by a gap that is safely
    /// above the rounding of coordinates (about 2e-6 of the largest coordinate).
    pub fn off_surface(&self, point: Vec3, normal: Vec3) -> Vec3 {
        point + self.gap * normal
    }

    /// The gap of [`Rays::off_surface`], metres.
    pub fn gap(&self) -> f32 {
        self.gap
    }

    fn open(&self, origin: Vec3, direction: Vec3, limit: f32, ignore: u32) -> bool {
        if direction == Vec3::ZERO {
            return true;
        }
        let (ray, sheared, _) = self.prepare(origin, direction, limit);
        self.bvh.ray_traverse_miss(ray, |ray, slot| {
            let slot = &self.slots[slot];
            match sheared.meet(&slot.corners) {
                Some(m) if m.t > 0.0 && m.t < ray.tmax && slot.triangle != ignore => m.t,
                _ => f32::INFINITY,
            }
        })
    }

    /// The ray with its direction multiplied by the returned power of two.
    fn prepare(&self, origin: Vec3, direction: Vec3, limit: f32) -> (Ray, ShearedRay, f32) {
        let scale = power_of_two(self.direction_exponent - exponent(direction.abs().max_element()));
        // Adding zero turns -0 to +0: obvhs takes the near side of a box from the sign of the component.
        let direction = Vec3A::from(direction) * scale + Vec3A::ZERO;
        let inverse = direction.to_array().map(|d| (1.0 / d).clamp(-1e30, 1e30));
        let origin = Vec3A::from(origin);
        let inv_direction = Vec3A::from_array(inverse);
        let ray = Ray { origin, direction, inv_direction, tmin: 0.0, tmax: limit / scale };
        (ray, ShearedRay::new(origin, direction), scale)
    }
}

/// Exponent of a positive number: the power of two that is not above it.
fn exponent(x: f32) -> i32 {
    (x.to_bits() >> 23) as i32 - 127
}

fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent.clamp(-126, 127) + 127) as u32) << 23)
}

/// The slow, good build of obvhs, with padded boxes.
fn build(triangles: &[[[f32; 3]; 3]], pad: f32) -> CwBvh {
    let params = BvhBuildParams::very_slow_build();
    let triangles: Vec<Triangle> =
        triangles.iter().map(|&[a, b, c]| Triangle { v0: a.into(), v1: b.into(), v2: c.into() }).collect();
    let mut boxes: Vec<Aabb> = triangles.iter().map(Triangle::aabb).collect();
    let mut indices: Vec<u32> = (0..triangles.len() as u32).collect();
    let largest = boxes.iter().map(Aabb::half_area).fold(0.0, f32::max);
    let mean = boxes.iter().map(Aabb::half_area).sum::<f32>() / boxes.len().max(1) as f32;
    split_aabbs_preset(&mut boxes, &mut indices, &triangles, mean, largest);
    for b in &mut boxes {
        b.min -= Vec3A::splat(pad);
        b.max += Vec3A::splat(pad);
    }
    let mut bvh2 = PlocBuilder::with_capacity(boxes.len()).build(
        params.ploc_search_distance,
        &boxes,
        indices,
        params.sort_precision,
        params.search_depth_threshold,
    );
    bvh2.uses_spatial_splits = true;
    ReinsertionOptimizer::default().run(&mut bvh2, params.reinsertion_batch_ratio, None);
    bvh2_to_cwbvh(&bvh2, params.max_prims_per_leaf.clamp(1, 3), true, false)
}
