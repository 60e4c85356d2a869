//! Whether light gets along a surface from one place to another, tested by rays.
//!
//! Two places on one flat floor see each other only edge-on, where rounding decides. So each place
//! is first raised above its surface, through air that a ray found empty, and the raised
//! points look at each other. Over a bend that curves away (a column) the look goes by way of
//! a point above the ridge. Every step is a tested segment in open air: places in two rooms are
//! never joined, whatever the thickness of the wall between them.

use glam::Vec3;
use scene::{NO_TRIANGLE, Rays};

/// How far places are raised, in voxels: bumps lower than this do not hide one place from another.
const LIFT: f32 = 0.02;
/// Bends with a cosine above this are looked over in a straight line.
const FLAT: f32 = 0.9995;
/// Where along the way the look goes over a ridge; off the middle, where walls like to stand.
const WAYPOINT: f32 = 0.4731;

/// Looks along surfaces.
pub struct Sight<'a> {
    rays: &'a Rays,
    lift: f32,
}

/// A place on a surface, raised into the open air.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The place itself.
    pub position: Vec3,
    /// Unit normal of its side.
    pub normal: Vec3,
    raised: Vec3,
}

impl<'a> Sight<'a> {
    /// Sight over surfaces of voxel size `cell`.
    pub fn new(rays: &'a Rays, cell: f32) -> Sight<'a> {
        Sight { rays, lift: (LIFT * cell).max(4.0 * rays.gap()) }
    }

    /// The place of a point that lies on a surface, on the side of `normal`.
    pub fn place(&self, position: Vec3, normal: Vec3) -> Place {
        let foot = self.rays.off_surface(position, normal);
        let high = position + self.lift * normal;
        let raised = if self.rays.visible(foot, high, NO_TRIANGLE) { high } else { foot };
        Place { position, normal, raised }
    }

    /// Whether there is open air between two places.
    pub fn joined(&self, a: &Place, b: &Place) -> bool {
        let way = b.position - a.position;
        let convex = (b.normal - a.normal).dot(way) > 0.0;
        let cosine = a.normal.dot(b.normal);
        if cosine > FLAT || !convex {
            return self.clear(a.raised, b.raised);
        }
        // The tangent planes of both places meet at this height at most above the middle.
        let half_bend = ((1.0 - cosine) / (1.0 + cosine)).max(0.0).sqrt();
        let ridge = 0.5 * way.length() * half_bend;
        let over = a.raised.lerp(b.raised, WAYPOINT) + ridge * (a.normal + b.normal).normalize_or_zero();
        self.clear(a.raised, over) && self.clear(over, b.raised)
    }

    /// The face that a place lies on: the first that a ray down from it meets.
    pub fn face_under(&self, place: &Place) -> Option<u32> {
        let hit = self.rays.closest(place.raised, -place.normal, 2.0 * self.lift, NO_TRIANGLE)?;
        Some(radfile::face_id(hit.triangle, hit.side))
    }

    fn clear(&self, from: Vec3, to: Vec3) -> bool {
        self.rays.visible(from, to, NO_TRIANGLE)
    }
}
