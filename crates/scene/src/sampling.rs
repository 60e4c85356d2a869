//! Low-discrepancy points and what is made of them.
//!
//! Sources: S. Joe, F. Kuo, Constructing Sobol sequences with better two-dimensional projections,
//! SIAM J. Sci. Comput. 30, 2008 (direction numbers); B. Burley, Practical Hash-based Owen
//! Scrambling, JCGT 9(4), 2020 (scrambling), with the constants of N. Vegdahl, Building a Better LK
//! Hash, 2021, as in pbrt 4; P. Shirley, K. Chiu, A low distortion map between
//! disk and square, 1997; E. Heitz, A Low-Distortion Map Between Triangle and Square, 2019.

use glam::{Vec2, Vec3};

/// An Owen-scrambled Sobol sequence in four dimensions.
///
/// Every seed gives another scrambling, so estimates of different seeds are independent and each is
/// unbiased. The best sample counts are powers of two.
#[derive(Clone, Copy, Debug)]
pub struct Sobol {
    /// Scrambles the order.
    order: u32,
    /// Scrambles each dimension.
    seeds: [u32; 4],
}

/// For every bit of the index, the direction numbers of the four dimensions (the first is van der Corput),
/// lowest bit first, as the scrambling wants them.
const DIRECTIONS: [[u32; 4]; 32] = transpose([
    directions(0, 0, [1, 0, 0]),
    directions(1, 0, [1, 0, 0]),
    directions(2, 1, [1, 3, 0]),
    directions(3, 1, [1, 3, 1]),
]);

const fn transpose(dimensions: [[u32; 32]; 4]) -> [[u32; 4]; 32] {
    let mut bits = [[0; 4]; 32];
    let mut i = 0;
    while i < 128 {
        bits[i / 4][i % 4] = dimensions[i % 4][i / 4].reverse_bits();
        i += 1;
    }
    bits
}

/// Direction numbers from a primitive polynomial of `degree` with inner coefficients `a`.
const fn directions(degree: usize, a: u32, initial: [u32; 3]) -> [u32; 32] {
    let mut v = [0u32; 32];
    let mut i = 0;
    while i < 32 {
        if degree == 0 {
            v[i] = 1 << (31 - i);
        } else if i < degree {
            v[i] = initial[i] << (31 - i);
        } else {
            v[i] = v[i - degree] ^ (v[i - degree] >> degree);
            let mut k = 1;
            while k < degree {
                if (a >> (degree - 1 - k)) & 1 == 1 {
                    v[i] ^= v[i - k];
                }
                k += 1;
            }
        }
        i += 1;
    }
    v
}

impl Sobol {
    /// The sequence with this scrambling.
    pub fn new(seed: u32) -> Sobol {
        Sobol { order: hash(seed, 0x5bd1), seeds: std::array::from_fn(|d| hash(seed, d as u32)) }
    }

    /// Sample `index`: four numbers in [0, 1).
    ///
    /// The order is scrambled as well, so sequences of different seeds may be used side by side.
    pub fn sample(&self, index: u32) -> [f32; 4] {
        let mut bits = scramble(index.reverse_bits(), self.order).reverse_bits();
        let mut x = [0u32; 4];
        while bits != 0 {
            let directions = &DIRECTIONS[bits.trailing_zeros() as usize];
            x = std::array::from_fn(|d| x[d] ^ directions[d]);
            bits &= bits - 1;
        }
        let fraction = |bits: u32| (bits.reverse_bits() >> 8) as f32 * (1.0 / (1 << 24) as f32);
        std::array::from_fn(|d| fraction(scramble(x[d], self.seeds[d])))
    }
}

/// Nested uniform scrambling: each bit of a fraction is flipped by a hash of the bits above it.
///
/// The hash carries from low bits to high ones, so `x` and the result are in reverse order. On an index it
/// permutes every block of 2^k and keeps it a block, so stratification survives.
fn scramble(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Mixes two numbers to a seed.
pub fn hash(a: u32, b: u32) -> u32 {
    let mut x = u64::from(a) << 32 | u64::from(b);
    x ^= x >> 31;
    x = x.wrapping_mul(0x7fb5_d329_728e_a185);
    x ^= x >> 27;
    x = x.wrapping_mul(0x81da_def4_bc2d_d44d);
    (x ^ (x >> 33)) as u32
}

/// Two unit vectors that make a right-handed frame with the unit vector `n`.
pub fn basis(n: Vec3) -> (Vec3, Vec3) {
    n.any_orthonormal_pair()
}

/// A direction about the unit vector `normal` with density cos θ / π, strictly above the surface.
pub fn cosine_direction(normal: Vec3, x: f32, y: f32) -> Vec3 {
    let d = square_to_disk(x, y);
    let height = (1.0 - d.length_squared()).max(1e-8).sqrt();
    let (s, t) = basis(normal);
    (d.x * s + d.y * t + height * normal).normalize()
}

/// The unit square to the unit disk, area-preserving, continuous.
fn square_to_disk(x: f32, y: f32) -> Vec2 {
    let (a, b) = (2.0 * x - 1.0, 2.0 * y - 1.0);
    if a == 0.0 && b == 0.0 {
        return Vec2::ZERO;
    }
    let (radius, angle) = if a.abs() > b.abs() {
        (a, std::f32::consts::FRAC_PI_4 * (b / a))
    } else {
        (b, std::f32::consts::FRAC_PI_2 - std::f32::consts::FRAC_PI_4 * (a / b))
    };
    radius * Vec2::from_angle(angle)
}

/// Barycentric weights of the second and third corner, uniform over a triangle, strictly inside.
pub fn square_to_triangle(x: f32, y: f32) -> (f32, f32) {
    let (x, y) = (x.clamp(1e-6, 1.0 - 1e-6), y.clamp(1e-6, 1.0 - 1e-6));
    if y > x {
        let u = 0.5 * x;
        (u, y - u)
    } else {
        let v = 0.5 * y;
        (x - v, v)
    }
}
