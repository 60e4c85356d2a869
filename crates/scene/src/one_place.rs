//! Hits that rounding cannot tell apart, and which of them is the first.
//!
//! Where triangles share an edge, a ray at that edge meets all of them, at distances that differ by rounding
//! alone. The nearest number may belong to one that the ray could not have reached: the floor of the next room, behind
//! the foot of the wall between, or the far side of a convex edge. A triangle is hidden by another of the same
//! place if it lies behind the other's plane as the ray's origin sees it; one that none hides is taken.

use glam::{DVec3, Vec3};
use radfile::Side;

use crate::rays::Hit;

/// Hits of one place that are compared; at most so many triangles of a fan are told apart.
const MOST: usize = 8;
/// What lies nearer to a plane than this part of the triangle's size is neither before nor behind it.
const IN_PLANE: f64 = 1e-5;

/// The hits nearest to the origin of a ray, all at one place.
pub struct Place {
    /// The least distance so far.
    pub nearest: f32,
    count: usize,
    hits: [(Hit, [Vec3; 3]); MOST],
}

impl Place {
    pub fn new() -> Place {
        let none = Hit { triangle: 0, side: Side::Front, t: f32::INFINITY, u: 0.0, v: 0.0 };
        Place { nearest: f32::INFINITY, count: 0, hits: [(none, [Vec3::ZERO; 3]); MOST] }
    }

    /// Adds a hit that is no further than `same_place` beyond the nearest; forgets those that it leaves behind.
    #[inline(always)]
    pub fn enter(&mut self, hit: Hit, corners: impl FnOnce() -> [Vec3; 3], same_place: f32) {
        if hit.t + same_place < self.nearest {
            self.count = 0;
        }
        if self.count < MOST {
            self.hits[self.count] = (hit, corners());
            self.count += 1;
        } else if hit.t < self.nearest {
            self.hits[MOST - 1] = (hit, corners());
        }
        if hit.t < self.nearest {
            self.nearest = hit.t;
            if self.count > 1 {
                self.forget(self.nearest + same_place);
            }
        }
    }

    #[cold]
    fn forget(&mut self, reach: f32) {
        let mut kept = 0;
        for k in 0..self.count {
            if self.hits[k].0.t <= reach {
                self.hits[kept] = self.hits[k];
                kept += 1;
            }
        }
        self.count = kept;
    }

    /// The hit that no other hides; among several the front before the back, then the nearer, then the lower number.
    pub fn first(mut self, origin: Vec3) -> Option<Hit> {
        let hits = &mut self.hits[..self.count];
        if hits.len() > 1 {
            hits.sort_by(|(a, _), (b, _)| {
                let side = |hit: &Hit| hit.side == Side::Back;
                side(a).cmp(&side(b)).then(a.t.total_cmp(&b.t)).then(a.triangle.cmp(&b.triangle))
            });
            let is_hidden = |own: &[Vec3; 3]| hits.iter().any(|(_, other)| hides(other, own, origin));
            if let Some((hit, _)) = hits.iter().find(|(_, corners)| !is_hidden(corners)) {
                return Some(*hit);
            }
        }
        hits.first().map(|(hit, _)| *hit)
    }
}

/// Whether the middle of `own` lies behind the plane of `other`, seen from `origin`.
fn hides(other: &[Vec3; 3], own: &[Vec3; 3], origin: Vec3) -> bool {
    let [a, b, c] = other.map(|p| p.as_dvec3());
    let Some(normal) = (b - a).cross(c - a).try_normalize() else { return false };
    let middle = own.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / 3.0;
    let (viewer, middle) = (normal.dot(origin.as_dvec3() - a), normal.dot(middle - a));
    let size = own.iter().map(|p| p.as_dvec3().distance(own[0].as_dvec3())).fold(0.0, f64::max);
    viewer * middle < 0.0 && middle.abs() > IN_PLANE * size
}
