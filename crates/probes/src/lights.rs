//! Synthetic direct light to try an operator with.
//!
//! Real lights are not known when a scene is baked, and shadow rays would need its geometry. What
//! matters for the error of a product is that the light is as uneven as light in rooms is: strong
//! near a lamp, nothing on faces that are turned away, or everywhere the same. Walls cast no
//! shadow here.

use radfile::Patches;

type Vector = [f32; 3];

/// What is lit: patches, or pieces of them. Every array has a number a piece.
#[derive(Clone, Copy, Debug)]
pub struct Surfaces<'a> {
    /// A point on each, metres.
    pub position: &'a [[f32; 3]],
    /// Unit vectors.
    pub normal: &'a [[f32; 3]],
    /// m².
    pub area: &'a [f32],
}

impl<'a> From<&'a Patches> for Surfaces<'a> {
    fn from(patches: &'a Patches) -> Surfaces<'a> {
        Surfaces { position: &patches.position, normal: &patches.normal, area: &patches.area }
    }
}

/// Direct irradiance of every patch under `count` lights, W/m²; the same for the same seed.
///
/// The first is uniform, every fifth after it shines from one direction, the others are points at
/// 2 to 25 % of the scene's diagonal above a random patch.
pub fn probe_lights<'a>(patches: impl Into<Surfaces<'a>>, count: u32, seed: u64) -> Vec<Vec<f32>> {
    let (patches, mut random) = (patches.into(), Random(seed));
    let n = patches.area.len();
    (0..count)
        .map(|light| match light {
            0 => vec![1.0; n],
            _ if light % 5 == 0 => {
                let towards = random.direction();
                patches.normal.iter().map(|n| dot(*n, towards).max(0.0)).collect()
            }
            _ => {
                let patch = (random.unit() * n as f32) as usize % n;
                let height = (0.02 + 0.23 * random.unit()) * diagonal(patches.position);
                let lamp = add(patches.position[patch], patches.normal[patch], height);
                (0..n).map(|i| point_light(&patches, i, lamp)).collect()
            }
        })
        .collect()
}

/// Irradiance of a patch from a lamp of 1 W/sr. A lamp nearer than the patch is wide does not make
/// it infinitely bright, hence the area in the square of the distance.
fn point_light(patches: &Surfaces, patch: usize, lamp: Vector) -> f32 {
    let away = add(lamp, patches.position[patch], -1.0);
    let square = dot(away, away) + patches.area[patch] / std::f32::consts::PI;
    (dot(patches.normal[patch], away) / (square * square.sqrt())).max(0.0)
}

fn diagonal(positions: &[Vector]) -> f32 {
    let extent = |a: usize| {
        let coordinates = || positions.iter().map(|p| p[a]);
        coordinates().fold(f32::MIN, f32::max) - coordinates().fold(f32::MAX, f32::min)
    };
    let size = [extent(0), extent(1), extent(2)];
    dot(size, size).sqrt()
}

fn dot(a: Vector, b: Vector) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a + factor · b.
fn add(a: Vector, b: Vector, factor: f32) -> Vector {
    std::array::from_fn(|c| a[c] + factor * b[c])
}

/// SplitMix64 (G. Steele, D. Lea, C. Flood, Fast splittable pseudorandom number generators, 2014).
struct Random(u64);

impl Random {
    /// Uniform in [0, 1).
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Uniform over the sphere.
    fn direction(&mut self) -> Vector {
        let height = 2.0 * self.unit() - 1.0;
        let (sin, cos) = (std::f32::consts::TAU * self.unit()).sin_cos();
        let radius = (1.0 - height * height).max(0.0).sqrt();
        [radius * cos, radius * sin, height]
    }
}
