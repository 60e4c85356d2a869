//! Where in a texel light is gathered, and whether anybody can look there.
//!
//! A box on a floor covers texels of the floor, a wall that passes through it others. What is gathered under the box
//! is dark and would bleed out through the filter. As in other bakers, such a place is known by its rays: they meet the
//! insides of solids, or something close by whatever their direction.

use glam::{DVec3, Vec3};
use radfile::Side;
use scene::{Sobol, hash};

use crate::{Atlas, flat::signed_area, view::View};

/// Rays that decide whether a place is hidden.
const RAYS: u32 = 64;
/// It is not if so many of them get away: in the corner of a room a quarter does.
const FREE: u32 = 8;
/// Distance that receivers keep from the edges of their triangle, relative to the largest coordinate: four times the
/// gap of `Rays::off_surface`, so that none sees past a wall that meets the triangle there.
const INSET: f64 = 64.0 * f32::EPSILON as f64;
const SEED: u32 = 0x7e8e1;

/// A place on the side of a triangle that is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub triangle: u32,
    /// Metres, local axes.
    pub position: Vec3,
    /// Unit normal.
    pub normal: Vec3,
}

/// A mesh with its atlas, and the side of each triangle that receives.
pub struct Ground<'a> {
    pub view: View<'a>,
    pub atlas: &'a Atlas,
    pub sides: Vec<Side>,
    /// Distance that receivers keep from edges, metres.
    inset: f64,
}

impl<'a> Ground<'a> {
    pub fn new(view: View<'a>, atlas: &'a Atlas, sides: Vec<Side>) -> Ground<'a> {
        let largest = view.mesh.positions.as_flattened().iter().fold(0.0f32, |m, x| m.max(x.abs()));
        Ground { view, atlas, sides, inset: INSET * f64::from(largest) }
    }

    /// The place with these barycentric weights, kept off the edges; `None` on a triangle without area.
    pub fn place(&self, triangle: u32, weights: [f64; 3]) -> Option<Place> {
        let normal = self.view.normal(triangle, self.sides[triangle as usize])?;
        let corners = self.view.mesh.corners(triangle as usize).map(|p| Vec3::from(p).as_dvec3());
        let [x, y, z] = off_edges(corners, weights, self.inset);
        let position = (x * corners[0] + y * corners[1] + z * corners[2]).as_vec3();
        Some(Place { triangle, position, normal })
    }

    /// Whether nobody can look at a place of a texel.
    pub fn is_hidden(&self, place: &Place, texel: u32) -> bool {
        let near = 0.5 * self.texel_edge(place.triangle);
        let sequence = Sobol::new(hash(SEED, texel));
        let (mut free, mut shut) = (0, 0);
        for ray in 0..RAYS {
            let [x, y, ..] = sequence.sample(ray);
            let hit = self.view.look(place.triangle, place.position, place.normal, [x, y]);
            let gets_away = |hit: scene::Hit| hit.side == self.sides[hit.triangle as usize] && hit.t >= near;
            match hit.is_none_or(gets_away) {
                true => free += 1,
                false => shut += 1,
            }
            if free == FREE || shut > RAYS - FREE {
                break;
            }
        }
        free < FREE
    }

    /// Edge of a texel on a triangle, metres.
    fn texel_edge(&self, triangle: u32) -> f32 {
        let flat = signed_area(self.atlas.corners(triangle)).abs();
        let edge = (crate::area(self.view.mesh, triangle) / flat).sqrt() as f32;
        if edge.is_finite() { edge } else { 0.0 }
    }
}

/// Weights moved towards the middle of the triangle until each edge is `inset` away, or as far as there is room.
fn off_edges(corners: [DVec3; 3], weights: [f64; 3], inset: f64) -> [f64; 3] {
    let [a, b, c] = corners;
    let twice_area = (b - a).cross(c - a).length();
    // A weight is the distance from the opposite edge in heights of the triangle over it.
    let least = [(c - b).length(), (a - c).length(), (b - a).length()].map(|edge| inset * edge / twice_area);
    let towards_middle = |k: usize| match weights[k] < least[k] {
        true => (least[k] - weights[k]) / (1.0 / 3.0 - weights[k]).max(f64::MIN_POSITIVE),
        false => 0.0,
    };
    let part = [0, 1, 2].map(towards_middle).into_iter().fold(0.0, f64::max).min(1.0);
    weights.map(|w| (1.0 - part) * w + part / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_kept_off_edges_and_slivers_keep_their_middle() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let [x, y, z] = off_edges(corners, [1.0, 0.0, 0.0], 0.01);
        // A corner moves along the bisector until it is as far from both edges.
        assert!((y - 0.01).abs() < 1e-12 && (z - 0.01).abs() < 1e-12 && (x + y + z - 1.0).abs() < 1e-12);
        assert_eq!(off_edges(corners, [0.5, 0.25, 0.25], 0.01), [0.5, 0.25, 0.25]);
        let sliver = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1e-3, 0.0)];
        assert!(off_edges(sliver, [0.0, 1.0, 0.0], 0.01).iter().all(|w| (w - 1.0 / 3.0).abs() < 1e-12));
    }
}
