//! Where a scene stands in the world.

use crate::workbench::Point;

/// A turn about the vertical, then a shift.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// In words of a table.
    pub name: &'static str,
    degrees: f64,
    shift: [f64; 3],
}

/// Walls lie along the grid of voxels.
pub const ALIGNED: Placement = Placement { name: "along the grid", degrees: 0.0, shift: [0.0; 3] };
/// Walls lie at odd places of voxels.
pub const OFF_GRID: Placement = Placement { name: "off the grid", degrees: 0.0, shift: [0.1371, 0.0713, -0.2219] };
/// Walls cross voxels at 20 degrees.
pub const TURNED: Placement = Placement { name: "turned by 20°", degrees: 20.0, shift: [0.1371, 0.0713, -0.2219] };
/// The same at another angle, where slivers of the surfaces around a thin wall lie inside of it.
pub const TURNED_MORE: Placement = Placement { name: "turned by 30°", degrees: 30.0, shift: [0.33, 0.2583, -0.2219] };
/// Those that every wall is tried in.
pub const PLACEMENTS: [Placement; 3] = [ALIGNED, OFF_GRID, TURNED];

impl Placement {
    /// A point of the scene in the world.
    pub fn to_world(&self, p: [f64; 3]) -> [f64; 3] {
        let p = turn(p, self.degrees);
        std::array::from_fn(|a| p[a] + self.shift[a])
    }

    /// A point of the scene, with its normal, in the world.
    pub fn point(&self, p: &Point) -> Point {
        Point { position: self.to_world(p.position), normal: turn(p.normal, self.degrees) }
    }

    /// A point of the world, with its normal, in axes of the scene.
    pub fn to_scene(&self, p: &Point) -> Point {
        let position = std::array::from_fn(|a| p.position[a] - self.shift[a]);
        Point { position: turn(position, -self.degrees), normal: turn(p.normal, -self.degrees) }
    }
}

/// About +Y; nothing is rounded where there is no turn.
fn turn([x, y, z]: [f64; 3], degrees: f64) -> [f64; 3] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [cos * x + sin * z, y, cos * z - sin * x]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_come_back() {
        let p = Point { position: [1.0, 2.0, 3.0], normal: [0.6, 0.0, 0.8] };
        for placement in PLACEMENTS {
            let back = placement.to_scene(&placement.point(&p));
            let off = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max);
            assert!(off(back.position, p.position) < 1e-12 && off(back.normal, p.normal) < 1e-12, "{placement:?}");
        }
    }
}
