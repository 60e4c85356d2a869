//! The point of a triangle that is nearest to a given point.
//!
//! Source: C. Ericson, Real-Time Collision Detection, 2005, §5.1.5.

use glam::Vec3;

/// The point of the triangle nearest to `p`.
pub fn nearest_point([a, b, c]: [Vec3; 3], p: Vec3) -> Vec3 {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + d1 / (d1 - d3) * ab;
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + d2 / (d2 - d6) * ac;
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
    }
    let sum = va + vb + vc;
    a + vb / sum * ab + vc / sum * ac
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compared with the best of many points of the triangle, to the spacing of those points.
    #[test]
    fn no_point_of_the_triangle_is_nearer() {
        let triangle = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(2.0, 0.0, 0.5), Vec3::new(0.5, 1.5, -0.5)];
        let [a, b, c] = triangle;
        for k in 0..64 {
            let p = Vec3::new((k % 4) as f32 - 1.0, (k / 4 % 4) as f32 - 1.0, (k / 16) as f32 - 1.5);
            let found = nearest_point(triangle, p).distance(p);
            let steps = 100;
            let best = (0..=steps)
                .flat_map(|i| (0..=steps - i).map(move |j| (i as f32 / 100.0, j as f32 / 100.0)))
                .map(|(u, v)| (a + u * (b - a) + v * (c - a)).distance(p))
                .fold(f32::INFINITY, f32::min);
            assert!(found <= best + 1e-6 && found >= best - 0.02, "{p}: {found}, best of grid {best}");
        }
    }
}
