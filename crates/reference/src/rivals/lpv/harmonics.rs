//! Spherical harmonics of two bands: functions of direction with four coefficients.
//!
//! Order: 1, x, y, z. P.-P. Sloan, Stupid Spherical Harmonics Tricks, 2008, appendices A1 and A2 (signs of the axes all
//! positive here).

use glam::{Vec3, Vec3A, Vec4, Vec4Swizzles};

/// Y₀ = 1 / (2 √π).
pub const Y0: f32 = 0.282_094_8;
/// Y₁ = Y1 · direction, √(3 / 4π).
pub const Y1: f32 = 0.488_602_5;
/// Coefficients of the clamped cosine about an axis: √π / 2, and √(π/3) times the axis.
const LOBE0: f32 = 0.886_226_9;
const LOBE1: f32 = 1.023_326_7;

/// The harmonics at a direction: what coefficients are multiplied with to evaluate them.
pub fn basis(direction: Vec3) -> Vec4 {
    (Y1 * direction).extend(Y0).wxyz()
}

/// The clamped cosine about an axis.
pub fn lobe(axis: Vec3) -> Vec4 {
    (LOBE1 * axis).extend(LOBE0).wxyz()
}

/// Coefficients of three colours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Colours(pub [Vec3A; 4]);

impl Colours {
    /// A clamped cosine about an axis times a colour.
    pub fn lobe(axis: Vec3, colour: Vec3) -> Colours {
        Colours(lobe(axis).to_array().map(|c| c * Vec3A::from(colour)))
    }

    /// Product with one function, integrated over all directions; with [`basis`] the value in that direction.
    pub fn dot(&self, other: Vec4) -> Vec3A {
        let [a, b, c, d] = self.0;
        other.x * a + other.y * b + other.z * c + other.w * d
    }

    /// Adds another times a factor.
    pub fn add(&mut self, other: &Colours, factor: f32) {
        for (sum, value) in self.0.iter_mut().zip(other.0) {
            *sum += factor * value;
        }
    }

    /// Whether it is 0 everywhere.
    pub fn is_zero(&self) -> bool {
        self.0 == [Vec3A::ZERO; 4]
    }

    /// Clamped cosines about both directions of every axis, each times a colour: +x, -x, +y, -y, +z, -z.
    pub fn lobes(colours: &[Vec3A; 6]) -> Colours {
        let [a, b, c, d, e, f] = *colours;
        Colours([LOBE0 * (a + b + c + d + e + f), LOBE1 * (a - b), LOBE1 * (c - d), LOBE1 * (e - f)])
    }

    /// Integral over all directions.
    #[cfg(test)]
    pub fn integral(&self) -> Vec3A {
        self.0[0] / Y0
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use super::*;

    #[test]
    fn a_clamped_cosine_has_its_integrals() {
        let axis = Vec3::new(2.0, -1.0, 0.5).normalize();
        let cosine = Colours::lobe(axis, Vec3::new(1.0, 2.0, 0.0));
        assert!((cosine.integral() - Vec3A::new(PI, 2.0 * PI, 0.0)).length() < 1e-5);
        // Two bands of a clamped cosine: 1/4 + 1/2 cos θ; their square integrates to π/4 + π/3.
        assert!((cosine.dot(basis(axis)).x - 0.75).abs() < 1e-6);
        assert!((cosine.dot(basis(-axis)).x + 0.25).abs() < 1e-6);
        assert!((cosine.dot(lobe(axis)).x - PI * 7.0 / 12.0).abs() < 1e-5);
    }
}
