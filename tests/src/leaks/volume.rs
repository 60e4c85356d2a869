//! Places where it is dark.

use crate::{shapes::dot, workbench::Point};

/// How far above its surface a place must still be in the dark, metres: less than any gap of the scenes.
const RAISED: f64 = 1e-4;

/// A piece of space, in axes of the scene.
#[derive(Clone, Copy, Debug)]
pub enum Volume {
    /// Low and high x, y, z.
    Box([f64; 3], [f64; 3]),
    /// The inside of a polyhedron inscribed in a sphere: what faces the middle.
    Ball { centre: [f64; 3], radius: f64 },
}

impl Volume {
    /// Whether the air just in front of a point of a surface is in it.
    pub fn holds(&self, point: &Point) -> bool {
        let air: [f64; 3] = std::array::from_fn(|a| point.position[a] + RAISED * point.normal[a]);
        match *self {
            Volume::Box(low, high) => (0..3).all(|a| low[a] < air[a] && air[a] < high[a]),
            Volume::Ball { centre, radius } => {
                let from_middle: [f64; 3] = std::array::from_fn(|a| air[a] - centre[a]);
                dot(from_middle, from_middle).sqrt() < radius && dot(from_middle, point.normal) < 0.0
            }
        }
    }
}
