//! Exchange areas of axis-parallel rectangles in closed form.
//!
//! A_1 F_12 is an alternating sum over the corners of both rectangles of a function G of their distances.
//! Source: J. R. Howell, A Catalog of Radiation Heat Transfer Configuration Factors, entries C-13 (parallel) and
//! C-15 (perpendicular). Both assume that nothing stands between the two, as in an empty box.

use std::f64::consts::TAU;

/// A rectangle in a plane across one axis, whose front looks up or down that axis.
#[derive(Clone, Copy, Debug)]
pub struct Rectangle {
    /// Lowest and highest corner, metres; equal along `axis`.
    pub corners: [[f64; 3]; 2],
    /// 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// 1 if the front looks up the axis, −1 if down.
    pub facing: f64,
}

impl Rectangle {
    /// The two axes along which it extends, in the order that makes the first × the second look up `axis`.
    pub fn sides(&self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    /// m².
    pub fn area(&self) -> f64 {
        self.sides().iter().map(|&a| self.corners[1][a] - self.corners[0][a]).product()
    }

    /// The middle of it.
    pub fn centre(&self) -> [f64; 3] {
        std::array::from_fn(|a| 0.5 * (self.corners[0][a] + self.corners[1][a]))
    }

    /// Unit normal of the front.
    pub fn normal(&self) -> [f64; 3] {
        std::array::from_fn(|a| if a == self.axis { self.facing } else { 0.0 })
    }

    /// Where its plane is on its axis.
    fn plane(&self) -> f64 {
        self.corners[0][self.axis]
    }
}

/// A_1 F_12 = A_2 F_21, m², of two rectangles that face each other, or 0 for two of one plane.
pub fn exchange_area(one: &Rectangle, two: &Rectangle) -> f64 {
    let along = |r: &Rectangle, axis: usize| [r.corners[0][axis], r.corners[1][axis]];
    if one.axis == two.axis {
        let gap = (one.plane() - two.plane()).abs();
        if gap == 0.0 {
            return 0.0;
        }
        let [s, t] = one.sides();
        return alternating([along(one, s), along(two, s), along(one, t), along(two, t)], |[a, b, c, d]| {
            parallel(a - b, c - d, gap)
        });
    }
    // Distances from the line in which both planes meet.
    let from_line = |r: &Rectangle, other: &Rectangle| along(r, other.axis).map(|v| (v - other.plane()).abs());
    let shared = 3 - one.axis - two.axis;
    let corners = [along(one, shared), along(two, shared), from_line(one, two), from_line(two, one)];
    alternating(corners, |[a, b, y, z]| perpendicular(a - b, y * y + z * z)).abs()
}

/// Σ ± f over all choices of one of two values in four places; − for an odd number of second choices.
fn alternating(values: [[f64; 2]; 4], f: impl Fn([f64; 4]) -> f64) -> f64 {
    let term = |choice: usize| {
        let sign = if choice.count_ones().is_multiple_of(2) { 1.0 } else { -1.0 };
        sign * f(std::array::from_fn(|place| values[place][choice >> place & 1]))
    };
    (0..16).map(term).sum()
}

/// G of parallel rectangles for corners that lie `u`, `v` apart along the sides and `gap` across.
fn parallel(u: f64, v: f64, gap: f64) -> f64 {
    let square = gap * gap;
    let arc = |a: f64, b: f64| {
        let leg = (b * b + square).sqrt();
        a * leg * (a / leg).atan()
    };
    (arc(u, v) + arc(v, u) - 0.5 * square * (u * u + v * v + square).ln()) / TAU
}

/// G of perpendicular rectangles for corners `u` apart along the line in which the planes meet, and with `square`
/// the sum of their squared distances from it. 0 ln 0 is 0.
fn perpendicular(u: f64, square: f64) -> f64 {
    let leg = square.sqrt();
    let whole = u * u + square;
    let logarithm = if whole > 0.0 { 0.25 * (u * u - square) * whole.ln() } else { 0.0 };
    (u * leg * u.atan2(leg) + logarithm) / TAU
}
