//! Real spherical harmonics.
//!
//! Source: P.-P. Sloan, Stupid spherical harmonics (SH) tricks, GDC 2008, appendix A1 (recurrences; the sign (−1)^m is
//! left out); R. Ramamoorthi, P. Hanrahan, An efficient representation for irradiance environment maps, SIGGRAPH 2001,
//! equations 8 and 9 (the clamped cosine).

use std::f32::consts::PI;

use glam::Vec3;

/// Highest number of bands.
pub const MAX_BANDS: usize = 6;
/// Functions of so many bands.
pub const MAX_FUNCTIONS: usize = MAX_BANDS * MAX_BANDS;

/// The functions of the bands below `bands`; that of band l and order m has number l² + l + m.
#[derive(Clone, Debug)]
pub struct Basis {
    bands: usize,
    /// By number: √((2l + 1) / 4π · (l − |m|)! / (l + |m|)!), times √2 where m is not 0.
    scale: [f32; MAX_FUNCTIONS],
}

impl Basis {
    /// At most [`MAX_BANDS`] bands, at least one.
    pub fn new(bands: usize) -> Basis {
        let bands = bands.clamp(1, MAX_BANDS);
        let mut scale = [0.0; MAX_FUNCTIONS];
        for l in 0..bands {
            for m in 0..=l {
                let ratio: f64 = (l - m + 1..=l + m).map(|k| k as f64).product();
                let twice = if m == 0 { 1.0 } else { 2.0 };
                let value = (twice * (2 * l + 1) as f64 / (4.0 * std::f64::consts::PI * ratio)).sqrt() as f32;
                scale[l * l + l + m] = value;
                scale[l * l + l - m] = value;
            }
        }
        Basis { bands, scale }
    }

    /// Number of bands.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// Number of functions.
    pub fn len(&self) -> usize {
        self.bands * self.bands
    }

    /// All functions at a unit direction; those beyond [`Basis::len`] are 0.
    pub fn at(&self, d: Vec3) -> [f32; MAX_FUNCTIONS] {
        let mut y = [0.0; MAX_FUNCTIONS];
        let mut put = |l: usize, m: usize, legendre: f32, (cos, sin): (f32, f32)| {
            let (plus, minus) = (l * l + l + m, l * l + l - m);
            y[minus] = self.scale[minus] * legendre * sin;
            y[plus] = self.scale[plus] * legendre * cos;
        };
        // (x + iy)^m and P_m^m over sin^m θ.
        let (mut turn, mut diagonal) = ((1.0, 0.0), 1.0);
        for m in 0..self.bands {
            let (mut before, mut last) = (0.0, diagonal);
            put(m, m, last, turn);
            for l in m + 1..self.bands {
                let next = ((2 * l - 1) as f32 * d.z * last - (l + m - 1) as f32 * before) / (l - m) as f32;
                (before, last) = (last, next);
                put(l, m, last, turn);
            }
            turn = (turn.0 * d.x - turn.1 * d.y, turn.0 * d.y + turn.1 * d.x);
            diagonal *= (2 * m + 1) as f32;
        }
        y
    }

    /// ∫ Y(ω) max(0, n · ω) dω for all functions: what light from everywhere gives a surface with unit normal `n`.
    pub fn clamped_cosine(&self, n: Vec3) -> [f32; MAX_FUNCTIONS] {
        let mut y = self.at(n);
        for l in 0..self.bands {
            y[l * l..(l + 1) * (l + 1)].iter_mut().for_each(|y| *y *= cosine_of_band(l));
        }
        y
    }
}

fn cosine_of_band(l: usize) -> f32 {
    match l {
        0 => PI,
        1 => 2.0 * PI / 3.0,
        _ if l % 2 == 1 => 0.0,
        _ => {
            let half = l / 2;
            let central: f32 = (1..=half).map(|k| (half + k) as f32 / (4 * k) as f32).product(); // l! / (2^l (l/2)!²)
            let sign = if half % 2 == 1 { 1.0 } else { -1.0 };
            2.0 * PI * sign / ((l + 2) * (l - 1)) as f32 * central
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nodes and weights of a product rule over the sphere: equal angles about the axis, the midpoint rule along it.
    fn sphere() -> Vec<(Vec3, f64)> {
        let (rings, steps) = (400, 32);
        let weight = 4.0 * std::f64::consts::PI / f64::from(rings * steps);
        let node = move |i: i32| {
            let z = 2.0 * (f64::from(i / steps) + 0.5) / f64::from(rings) - 1.0;
            let (sin, cos) = (f64::from(i % steps) * std::f64::consts::TAU / f64::from(steps)).sin_cos();
            let r = (1.0 - z * z).sqrt();
            (Vec3::new((r * cos) as f32, (r * sin) as f32, z as f32), weight)
        };
        (0..rings * steps).map(node).collect()
    }

    #[test]
    fn the_functions_are_orthonormal() {
        let basis = Basis::new(MAX_BANDS);
        let mut product = vec![0.0; MAX_FUNCTIONS * MAX_FUNCTIONS];
        for (direction, weight) in sphere() {
            let y = basis.at(direction);
            for (p, value) in product.iter_mut().enumerate() {
                *value += weight * f64::from(y[p / MAX_FUNCTIONS] * y[p % MAX_FUNCTIONS]);
            }
        }
        for (p, &value) in product.iter().enumerate() {
            let wanted = if p / MAX_FUNCTIONS == p % MAX_FUNCTIONS { 1.0 } else { 0.0 };
            assert!((value - wanted).abs() < 2e-3, "{p}: {value}");
        }
    }

    #[test]
    fn the_product_of_two_directions_depends_on_the_angle_between_them_alone() {
        // The addition theorem: within a band, Σ Y(a) Y(b) = (2l + 1) / 4π · P_l(a · b), however both are turned.
        let basis = Basis::new(4);
        let (a, b) = (Vec3::new(1.0, 2.0, -0.5).normalize(), Vec3::new(-0.3, 0.4, 0.9).normalize());
        let x = a.dot(b);
        let legendre = [1.0, x, 0.5 * (3.0 * x * x - 1.0), 0.5 * (5.0 * x * x * x - 3.0 * x)];
        for turn in [glam::Quat::IDENTITY, glam::Quat::from_rotation_x(0.7), glam::Quat::from_rotation_y(2.3)] {
            let (p, q) = (basis.at(turn * a), basis.at(turn * b));
            for (l, legendre) in legendre.iter().enumerate() {
                let sum: f32 = (l * l..(l + 1) * (l + 1)).map(|i| p[i] * q[i]).sum();
                let wanted = (2 * l + 1) as f32 / (4.0 * PI) * legendre;
                assert!((sum - wanted).abs() < 1e-5, "band {l}: {sum}, expected {wanted}");
            }
        }
    }

    #[test]
    fn the_clamped_cosine_is_its_integral() {
        let basis = Basis::new(MAX_BANDS);
        let normal = Vec3::new(0.3, -0.8, 0.5).normalize();
        let mut integral = [0.0; MAX_FUNCTIONS];
        for (direction, weight) in sphere() {
            let facing = weight * f64::from(normal.dot(direction).max(0.0));
            integral.iter_mut().zip(basis.at(direction)).for_each(|(sum, y)| *sum += facing * f64::from(y));
        }
        for (i, (found, wanted)) in basis.clamped_cosine(normal).into_iter().zip(integral).enumerate() {
            assert!((f64::from(found) - wanted).abs() < 2e-3, "function {i}: {found}, expected {wanted}");
        }
    }
}
