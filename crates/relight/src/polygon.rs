//! Irradiance from a polygon of constant radiance, in closed form: docs/theory.md (10.4).
//!
//! E = L/2 · Σ Γᵢ n·(vᵢ × vᵢ₊₁)/|vᵢ × vᵢ₊₁| over the edges, where vᵢ are the corners seen from the
//! point and Γᵢ is the angle of an edge; the polygon is first clipped to what is above the horizon.
//! Source: J. H. Lambert, Photometria, 1760; D. R. Baum, H. E. Rushmeier, J. M. Winget,
//! Improving radiosity solutions through the use of analytically determined form-factors, 1989.

use glam::DVec3;

/// A quad cut by the horizon has five corners.
const MOST: usize = 5;

/// Irradiance at `point` facing the unit vector `normal`, per radiance of the polygon (sr, at most π);
/// which side of the polygon emits, and what stands between, is the caller's business.
pub fn irradiance_per_radiance(corners: &[DVec3], point: DVec3, normal: DVec3) -> f64 {
    let (clipped, count) = above_horizon(corners, point, normal);
    let clipped = &clipped[..count];
    let mut sum = 0.0;
    for (i, &a) in clipped.iter().enumerate() {
        let b = clipped[(i + 1) % count];
        let cross = a.cross(b);
        let sine = cross.length();
        if sine > 0.0 {
            sum += sine.atan2(a.dot(b)) * normal.dot(cross) / sine;
        }
    }
    0.5 * sum.abs()
}

/// Corners relative to the point, those below the horizon cut off.
fn above_horizon(corners: &[DVec3], point: DVec3, normal: DVec3) -> ([DVec3; MOST], usize) {
    let mut out = [DVec3::ZERO; MOST];
    let mut count = 0;
    let mut push = |v: DVec3| {
        out[count] = v;
        count += 1;
    };
    for (i, &corner) in corners.iter().enumerate() {
        let (a, b) = (corner - point, corners[(i + 1) % corners.len()] - point);
        let (above_a, above_b) = (a.dot(normal), b.dot(normal));
        if above_a >= 0.0 {
            push(a);
        }
        if (above_a > 0.0 && above_b < 0.0) || (above_a < 0.0 && above_b > 0.0) {
            push(a + above_a / (above_a - above_b) * (b - a));
        }
    }
    (out, count)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn rectangle(a: f64, b: f64, z: f64) -> [DVec3; 4] {
        [[0.0, 0.0], [a, 0.0], [a, b], [0.0, b]].map(|[x, y]| DVec3::new(x, y, z))
    }

    /// A plane element opposite the corner of a parallel rectangle: Howell, catalog entry B-3.
    #[test]
    fn a_rectangle_seen_from_below_its_corner_has_the_catalogued_factor() {
        for (a, b, c) in [(1.0, 1.0, 1.0), (0.3, 2.0, 0.5), (10.0, 0.1, 3.0)] {
            let (x, y) = (a / c, b / c);
            let (p, q) = (f64::sqrt(1.0 + x * x), f64::sqrt(1.0 + y * y));
            let factor = (x / p * (y / p).atan() + y / q * (x / q).atan()) / (2.0 * PI);
            let found = irradiance_per_radiance(&rectangle(a, b, c), DVec3::ZERO, DVec3::Z) / PI;
            assert!((found - factor).abs() < 1e-14, "{a} {b} {c}: {found}, expected {factor}");
        }
    }

    /// Seen from a point in the plane of its foot, half the circle of directions is below the horizon.
    #[test]
    fn what_is_below_the_horizon_gives_nothing() {
        let upright = |low: f64, high: f64| {
            [[0.0, low], [1.0, low], [1.0, high], [0.0, high]].map(|[x, z]| DVec3::new(x, 1.0, z))
        };
        let above = irradiance_per_radiance(&upright(0.0, 1.0), DVec3::ZERO, DVec3::Z);
        let both = irradiance_per_radiance(&upright(-1.0, 1.0), DVec3::ZERO, DVec3::Z);
        assert!(above > 0.1 && (above - both).abs() < 1e-14, "{above} {both}");
        assert_eq!(irradiance_per_radiance(&upright(-1.0, -0.1), DVec3::ZERO, DVec3::Z), 0.0);
    }

    /// Six faces of a cube around a point: every direction above the horizon meets one of them.
    #[test]
    fn a_closed_box_of_radiance_one_gives_pi() {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let point = at(0.2, 0.3, 0.4);
        let mut sum = 0.0;
        for axis in 0..3 {
            for side in [0.0, 1.0] {
                let face = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[a, b]| match axis {
                    0 => at(side, a, b),
                    1 => at(a, side, b),
                    _ => at(a, b, side),
                });
                sum += irradiance_per_radiance(&face, point, at(0.6, 0.0, 0.8));
            }
        }
        assert!((sum - PI).abs() < 1e-13, "{sum}");
    }
}
