//! Polygons in the plane of the texels: clipping, area, the nearest point of a triangle.

/// A point, in texels.
pub type Point = [f64; 2];

/// Corners of a triangle, in texels.
pub type Flat = [Point; 3];

/// A convex polygon of a few corners: a triangle cut by the sides of a texel has seven at most.
#[derive(Clone, Copy)]
pub struct Polygon {
    corners: [Point; 8],
    count: usize,
}

impl Polygon {
    pub fn triangle([a, b, c]: Flat) -> Polygon {
        let mut corners = [[0.0; 2]; 8];
        corners[..3].copy_from_slice(&[a, b, c]);
        Polygon { corners, count: 3 }
    }

    pub fn corners(&self) -> &[Point] {
        &self.corners[..self.count]
    }

    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The part with low ≤ coordinate ≤ high on one axis, borders included.
    ///
    /// Source: I. E. Sutherland, G. W. Hodgman, Reentrant polygon clipping, CACM 17(1), 1974.
    pub fn between(&self, axis: usize, low: f64, high: f64) -> Polygon {
        self.above(|p| p[axis] - low).above(|p| high - p[axis])
    }

    /// The part where `height` is not negative.
    fn above(&self, height: impl Fn(Point) -> f64) -> Polygon {
        let mut kept = Polygon { corners: [[0.0; 2]; 8], count: 0 };
        for (k, &to) in self.corners().iter().enumerate() {
            let from = self.corners[(k + self.count - 1) % self.count];
            let (h, g) = (height(from), height(to));
            if (h >= 0.0) != (g >= 0.0) {
                let s = h / (h - g);
                kept.push([from[0] + s * (to[0] - from[0]), from[1] + s * (to[1] - from[1])]);
            }
            if g >= 0.0 {
                kept.push(to);
            }
        }
        kept
    }

    fn push(&mut self, p: Point) {
        // Rounding may let a line leave and enter a thin polygon once too often; such a corner is on the line already.
        if self.count < self.corners.len() {
            self.corners[self.count] = p;
            self.count += 1;
        }
    }

    /// Lowest and highest coordinate on an axis.
    pub fn range(&self, axis: usize) -> [f64; 2] {
        let each = self.corners().iter().map(|p| p[axis]);
        each.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    }

    /// Area and centroid; of a polygon without area the mean of its corners.
    pub fn area_and_centroid(&self) -> (f64, Point) {
        let corners = self.corners();
        let first = corners[0];
        let (mut twice, mut moment) = (0.0, [0.0; 2]);
        for pair in corners[1..].windows(2) {
            let [p, q] = [sub(pair[0], first), sub(pair[1], first)];
            let area = cross(p, q);
            twice += area;
            moment = [moment[0] + area * (p[0] + q[0]) / 3.0, moment[1] + area * (p[1] + q[1]) / 3.0];
        }
        if twice.abs() > 1e-12 {
            return (0.5 * twice.abs(), [first[0] + moment[0] / twice, first[1] + moment[1] / twice]);
        }
        let n = corners.len() as f64;
        (0.0, [0, 1].map(|a| corners.iter().map(|p| p[a]).sum::<f64>() / n))
    }
}

/// Area of a triangle, signed by its winding.
pub fn signed_area([a, b, c]: Flat) -> f64 {
    0.5 * cross(sub(b, a), sub(c, a))
}

/// Barycentric weights of the point of a triangle that is nearest to `p`, and the square of its distance.
pub fn nearest(triangle: Flat, p: Point) -> ([f64; 3], f64) {
    let area = signed_area(triangle);
    let [a, b, c] = triangle;
    let weights = [[p, b, c], [a, p, c], [a, b, p]].map(|t| signed_area(t) / area);
    // Triangles of next to no area have weights of any size.
    if weights.iter().all(|w| *w >= 0.0) && (weights.iter().sum::<f64>() - 1.0).abs() < 1e-6 {
        return (weights, 0.0);
    }
    let on_edge = |k: usize| {
        let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
        let (way, length) = (sub(to, from), dot(sub(to, from), sub(to, from)));
        let s = if length > 0.0 { (dot(sub(p, from), way) / length).clamp(0.0, 1.0) } else { 0.0 };
        let off = sub(p, [from[0] + s * way[0], from[1] + s * way[1]]);
        let mut weights = [0.0; 3];
        (weights[k], weights[(k + 1) % 3]) = (1.0 - s, s);
        (weights, dot(off, off))
    };
    [0, 1, 2].map(on_edge).into_iter().min_by(|e, f| e.1.total_cmp(&f.1)).expect("three edges")
}

pub fn distance_squared(a: Point, b: Point) -> f64 {
    dot(sub(a, b), sub(a, b))
}

fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: Flat = [[0.0, 0.0], [4.0, 0.0], [0.0, 2.0]];

    #[test]
    fn a_clipped_triangle_has_the_area_and_centroid_of_what_is_left() {
        // Left of x = 2 there is a trapezoid of heights 2 and 1.
        let (area, centroid) = Polygon::triangle(TRIANGLE).between(0, 0.0, 2.0).area_and_centroid();
        assert!((area - 3.0).abs() < 1e-12, "{area}");
        assert!((centroid[0] - 8.0 / 9.0).abs() < 1e-12 && (centroid[1] - 7.0 / 9.0).abs() < 1e-12, "{centroid:?}");
        assert!(Polygon::triangle(TRIANGLE).between(0, 4.5, 5.0).is_empty());
    }

    #[test]
    fn nearest_points_are_inside_on_edges_and_at_corners() {
        for (p, weights, squared) in [
            ([1.0, 0.5], [0.5, 0.25, 0.25], 0.0),
            ([2.0, -3.0], [0.5, 0.5, 0.0], 9.0),
            ([-3.0, -4.0], [1.0, 0.0, 0.0], 25.0),
            ([3.0, 3.0], [0.0, 0.5, 0.5], 5.0),
        ] {
            let (w, d) = nearest(TRIANGLE, p);
            assert!((d - squared).abs() < 1e-12, "{p:?}: {d}");
            assert!((0..3).all(|k| (w[k] - weights[k]).abs() < 1e-12), "{p:?}: {w:?}");
        }
    }

    #[test]
    fn triangles_without_area_have_nearest_points_too() {
        let (w, d) = nearest([[0.0, 0.0], [2.0, 0.0], [1.0, 0.0]], [0.5, 1.0]);
        assert!((d - 1.0).abs() < 1e-12 && (w.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(nearest([[1.0; 2]; 3], [4.0, 5.0]).1, 25.0);
    }
}
