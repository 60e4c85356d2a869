//! Where surfaces stand on a piece or pass through it.

use glam::DVec3;

use crate::{clip::Corner, contact::overlap};

/// Where a surface stands on a piece, as far as it lies on the piece.
#[derive(Clone, Copy, Debug)]
pub struct Wall {
    pub ends: [DVec3; 2],
    /// Whether it stands so upright that the piece does not go on in it.
    pub upright: bool,
}

/// Sum of the lengths of intervals, what they have in common counted once; sorts them.
pub fn union(parts: &mut [[f64; 2]]) -> f64 {
    parts.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut end = f64::NEG_INFINITY;
    parts.iter().fold(0.0, |sum, &[from, to]| {
        let add = (to - from.max(end)).max(0.0);
        end = end.max(to);
        sum + add
    })
}

/// How many metres of `ends` some of `walls` stand on.
pub fn covered<'a>(walls: impl Iterator<Item = &'a Wall>, ends: [DVec3; 2], tolerance: f64) -> f64 {
    let along = (ends[1] - ends[0]).normalize_or_zero();
    let on = |wall: &Wall| {
        let [a, b] = overlap(wall.ends, ends, tolerance)?.map(|p| (p - ends[0]).dot(along));
        Some([a.min(b), a.max(b)])
    };
    union(&mut walls.filter_map(on).collect::<Vec<_>>())
}

/// The ends, along a direction, of what a convex polygon has in a plane: its corners within the tolerance of the plane
/// and where its edges pass through. `None` if it keeps away.
pub fn common(corners: &[Corner], distance: impl Fn(DVec3) -> f64, along: DVec3, tolerance: f64) -> Option<[DVec3; 2]> {
    let mut ends: Option<[(f64, DVec3); 2]> = None;
    let mut enter = |p: DVec3| {
        let place = (p.dot(along), p);
        let [low, high] = ends.unwrap_or([place, place]);
        ends = Some([if place.0 < low.0 { place } else { low }, if place.0 > high.0 { place } else { high }]);
    };
    let last = corners.last()?.point;
    let (mut before, mut d) = (last, distance(last));
    for corner in corners {
        let e = distance(corner.point);
        if e.abs() <= tolerance {
            enter(corner.point);
        }
        if d * e < 0.0 {
            enter(before + d / (d - e) * (corner.point - before));
        }
        (before, d) = (corner.point, e);
    }
    ends.map(|ends| ends.map(|(_, p)| p))
}
