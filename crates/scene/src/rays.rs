//! Ray queries against triangles: closest hit and visibility, watertight.
//!
//! Boxes are those of `wide_bvh.rs`, triangles are tested by `triangle_test.rs`. A ray must not slip
//! through where triangles meet, so boxes are padded by more than the rounding of the triangle test.

use glam::Vec3;
use radfile::{Mesh, Side};

use crate::{
    one_place::Place,
    triangle_test::ShearedRay,
    wide_bvh::{BoxRay, Corners, WideBvh},
};

/// Passed as `ignore` where no triangle is to be ignored.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// Pad of every box, relative to the largest coordinate. The triangle test moves corners by up to
/// 6 epsilon for origins inside the scene.
const BOX_PAD: f32 = 16.0 * f32::EPSILON;
/// Distance that ray origins keep from their surface, relative to the largest coordinate.
const SURFACE_GAP: f32 = 16.0 * f32::EPSILON;
/// Hits nearer to each other than this are one place, relative to the largest coordinate.
const SAME_PLACE: f32 = 4.0 * f32::EPSILON;

/// A search structure over triangles.
pub struct Rays {
    bvh: WideBvh,
    /// Largest coordinate, metres.
    extent: f32,
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
        let triangles: Vec<Corners> = (0..count).map(corners).collect();
        let extent = triangles.iter().flatten().flatten().fold(1e-20f32, |m, x| m.max(x.abs()));
        Rays { bvh: WideBvh::new(&triangles, extent * BOX_PAD), extent }
    }

    /// The first triangle that a ray from `origin` meets at a distance above 0 and below `limit`
    /// (in lengths of `direction`). The triangle `ignore` is passed through.
    ///
    /// At an edge several triangles are met at one place, to rounding; the one that is taken is never hidden by
    /// another of them, so that a wall without thickness is not passed where it stands on a floor.
    pub fn closest(&self, origin: Vec3, direction: Vec3, limit: f32, ignore: u32) -> Option<Hit> {
        if !is_ray(origin, direction) {
            return None;
        }
        let (boxes, sheared) = (BoxRay::new(origin, direction), ShearedRay::new(origin, direction));
        let same_place = self.extent * SAME_PLACE / direction.abs().max_element();
        let mut place = Place::new();
        let mut reach = limit;
        self.bvh.traverse(&boxes, limit, |quad| {
            let Some(meetings) = sheared.meet(quad) else { return reach };
            let mut lanes = meetings.lanes;
            while lanes != 0 {
                let k = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                let (t, triangle) = (meetings.t[k], quad.triangle[k]);
                if !(t > 0.0 && t <= reach && t < limit) || triangle == ignore {
                    continue;
                }
                let side = if meetings.front >> k & 1 == 1 { Side::Front } else { Side::Back };
                let hit = Hit { triangle, side, t, u: meetings.u[k], v: meetings.v[k] };
                place.enter(hit, || quad.corners_of(k), same_place);
                reach = (place.nearest + same_place).min(limit);
            }
            reach
        });
        place.first(origin)
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
        point + self.gap() * normal
    }

    /// The gap of [`Rays::off_surface`], metres.
    pub fn gap(&self) -> f32 {
        self.extent * SURFACE_GAP
    }

    fn open(&self, origin: Vec3, direction: Vec3, limit: f32, ignore: u32) -> bool {
        if !is_ray(origin, direction) {
            return true;
        }
        let (boxes, sheared) = (BoxRay::new(origin, direction), ShearedRay::new(origin, direction));
        let mut open = true;
        self.bvh.traverse(&boxes, limit, |quad| {
            let Some(meetings) = sheared.meet(quad) else { return limit };
            let shuts = |k: usize| {
                let t = meetings.t[k];
                meetings.lanes >> k & 1 == 1 && t > 0.0 && t < limit && quad.triangle[k] != ignore
            };
            open = !(0..4).any(shuts);
            if open { limit } else { -1.0 }
        });
        open
    }
}

/// Rays of no direction or from nowhere meet nothing.
fn is_ray(origin: Vec3, direction: Vec3) -> bool {
    origin.is_finite() && direction.is_finite() && direction != Vec3::ZERO
}
