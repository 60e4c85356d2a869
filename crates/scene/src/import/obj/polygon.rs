//! Cutting polygons into triangles by clipping ears, in the plane of the polygon's Newell normal.
//!
//! Convex polygons come out as the fan about their first corner, as other readers cut them.
//! Sources: G. H. Meisters, Polygons have ears, 1975; M. E. Newell's normal as in I. E. Sutherland et al., 1974.

use glam::{DVec2, DVec3};

/// Triangles of corner numbers with the polygon's winding, and whether the polygon was simple; one that crosses
/// itself is cut too, but not all of it is covered once.
pub fn triangulate(corners: &[[f64; 3]]) -> (Vec<[usize; 3]>, bool) {
    let n = corners.len();
    if n <= 3 {
        return (if n == 3 { vec![[0, 1, 2]] } else { vec![] }, true);
    }
    let flat = flatten(corners);
    let mut left: Vec<usize> = (0..n).collect();
    let (mut triangles, mut simple) = (Vec::with_capacity(n - 2), true);
    let mut at = 1;
    while left.len() > 3 {
        // Ears with an area first: flat ones would leave a corner hanging in the middle of an edge.
        let ear = find_ear(&flat, &left, at, true).or_else(|| find_ear(&flat, &left, at, false));
        simple &= ear.is_some();
        let k = ear.unwrap_or(at % left.len());
        triangles.push(around(&left, k));
        left.remove(k);
        at = if k == 0 { 1 } else { k };
    }
    triangles.push([left[0], left[1], left[2]]);
    (triangles, simple)
}

/// The corners in the coordinate plane that is nearest to the polygon's own, counter-clockwise.
fn flatten(corners: &[[f64; 3]]) -> Vec<DVec2> {
    let middle = DVec3::from(corners[0]);
    let points: Vec<DVec3> = corners.iter().map(|&p| DVec3::from(p) - middle).collect();
    let next = points.iter().cycle().skip(1);
    let normal: DVec3 = points.iter().zip(next).map(|(a, b)| a.cross(*b)).sum();
    let dropped = normal.abs().max_position();
    // These two axes keep the winding as seen from the positive end of the one that is dropped.
    let (x, y) = ((dropped + 1) % 3, (dropped + 2) % 3);
    let (x, y) = if normal[dropped] >= 0.0 { (x, y) } else { (y, x) };
    points.iter().map(|p| DVec2::new(p[x], p[y])).collect()
}

/// The corner before, at and after place `k`.
fn around(left: &[usize], k: usize) -> [usize; 3] {
    let n = left.len();
    [left[(k + n - 1) % n], left[k], left[(k + 1) % n]]
}

/// The first place from `start` on that can be cut off; with an area above zero if `strict`.
fn find_ear(flat: &[DVec2], left: &[usize], start: usize, strict: bool) -> Option<usize> {
    let n = left.len();
    (0..n).map(|i| (start + i) % n).find(|&k| {
        let [a, b, c] = around(left, k).map(|i| flat[i]);
        let area = (b - a).perp_dot(c - b);
        if area < 0.0 || (strict && area == 0.0) {
            return false;
        }
        let inside = |p: DVec2| {
            p != a
                && p != b
                && p != c
                && (b - a).perp_dot(p - a) >= 0.0
                && (c - b).perp_dot(p - b) >= 0.0
                && (a - c).perp_dot(p - c) >= 0.0
        };
        !left.iter().any(|&i| inside(flat[i]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[[f64; 3]], triangles: &[[usize; 3]]) -> DVec3 {
        let cross = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|i| DVec3::from(corners[i]));
            0.5 * (b - a).cross(c - a)
        };
        triangles.iter().map(cross).sum()
    }

    fn covered(corners: &[[f64; 3]], triangles: &[[usize; 3]]) -> f64 {
        triangles.iter().map(|t| area(corners, &[*t]).length()).sum()
    }

    /// A 3 × 3 square without its 2 × 2 corner, in the plane that `place` makes of (x, y).
    fn l_shape(place: impl Fn(f64, f64) -> [f64; 3]) -> Vec<[f64; 3]> {
        [(0., 0.), (3., 0.), (3., 1.), (1., 1.), (1., 3.), (0., 3.)].map(|(x, y)| place(x, y)).to_vec()
    }

    #[test]
    fn a_convex_polygon_becomes_a_fan() {
        let square = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
        assert_eq!(triangulate(&square), (vec![[0, 1, 2], [0, 2, 3]], true));
        let hexagon: Vec<[f64; 3]> = (0..6).map(|k| f64::from(k).sin_cos()).map(|(s, c)| [c, 0.0, s]).collect();
        assert_eq!(triangulate(&hexagon).0, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
    }

    #[test]
    fn a_concave_polygon_keeps_its_area_and_winding_in_every_plane_and_from_every_start() {
        let planes: [fn(f64, f64) -> [f64; 3]; 6] = [
            |x, y| [x, y, 5.0],
            |x, y| [y, x, 5.0],
            |x, y| [5.0, x, y],
            |x, y| [5.0, y, x],
            |x, y| [x, 5.0, y],
            |x, y| [x, 0.3 * x + y, y],
        ];
        for plane in planes {
            for start in 0..6 {
                let mut corners = l_shape(plane);
                let whole = area(&corners, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
                corners.rotate_left(start);
                let (triangles, simple) = triangulate(&corners);
                assert!(simple && triangles.len() == 4, "{triangles:?}");
                assert!((area(&corners, &triangles) - whole).length() < 1e-12);
                assert!((covered(&corners, &triangles) - whole.length()).abs() < 1e-12, "no part twice");
            }
        }
    }

    #[test]
    fn a_corner_in_the_middle_of_an_edge_stays_a_corner_of_a_triangle_with_area() {
        let corners = [[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [2., 2., 0.], [0., 2., 0.]];
        let (triangles, simple) = triangulate(&corners);
        assert!(simple && triangles.iter().all(|t| area(&corners, &[*t]).z > 0.0), "{triangles:?}");
    }

    #[test]
    fn polygons_that_cross_themselves_or_are_flat_are_cut_without_end_or_panic() {
        let bow = [[0., 0., 0.], [1., 1., 0.], [1., 0., 0.], [0., 1., 0.]];
        assert_eq!(triangulate(&bow).0.len(), 2);
        let star: Vec<[f64; 3]> = (0..5).map(|k| (f64::from(k) * 2.513).sin_cos()).map(|(s, c)| [c, s, 0.0]).collect();
        assert_eq!(triangulate(&star).0.len(), 3);
        assert_eq!(triangulate(&[[1.0; 3]; 7]).0.len(), 5);
        assert_eq!(triangulate(&[[f64::MAX, -f64::MAX, 1.0]; 5]).0.len(), 3);
    }
}
