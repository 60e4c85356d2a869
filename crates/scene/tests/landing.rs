//! No ray is counted on the far side of a wall, however near to its foot it lands.

use glam::Vec3;
use radfile::{CUT, Cut, PatchLocator};
use scene::{NO_TRIANGLE, Rays, Sobol, hash, land};

/// Where the wall stands on the floor: no number that single precision holds.
const FOOT: f32 = 0.3;
/// Rays of each trial.
const COUNT: u32 = 1 << 15;

/// A floor z = 0 and a wall on it, below it too, that leans towards +x by so much a metre.
struct Parted {
    rays: Rays,
    lean: f32,
}

impl Parted {
    fn new(lean: f32) -> Parted {
        let at = |y: f32, z: f32| [FOOT + lean * z, y, z];
        let triangles = [
            [[-4.0, -4.0, 0.0], [4.0, -4.0, 0.0], [0.0, 8.0, 0.0]],
            [at(-9.0, -0.02), at(9.0, -0.02), at(9.0, 3.0)],
            [at(-9.0, -0.02), at(9.0, 3.0), at(-9.0, 3.0)],
        ];
        Parted { rays: Rays::from_triangles(triangles.len(), |t| triangles[t]), lean }
    }

    /// Of rays that are aimed at the wall's foot, to rounding: how many land on the floor, how many of those are looked
    /// up across the wall by their place alone, and how many when the ray is known.
    fn astray(&self, locator: &PatchLocator) -> [usize; 3] {
        let (mut landed, mut by_place, mut by_ray) = (0, 0, 0);
        for k in 0..COUNT {
            let sobol = Sobol::new(hash(7, k));
            let ([x, y, z, w], [fine, ..]) = (sobol.sample(0), sobol.sample(1));
            let [height, side] = [1e-4 + 2.0 * z, if w < 0.5 { -1.0 } else { 1.0 }];
            let origin = Vec3::new(FOOT + self.lean * height + side * (1e-3 + x), 2.0 * y - 1.0, height);
            let target = Vec3::new(FOOT + 2e-6 * (fine - 0.5), 2.0 * w - 1.0, 0.0);
            let Some(landing) = land(&self.rays, locator, origin, target - origin, NO_TRIANGLE) else { continue };
            if landing.face != 0 {
                continue;
            }
            let own = Some(u32::from(side > 0.0));
            landed += 1;
            by_place += usize::from(locator.patch_at(0, landing.position.to_array()) != own);
            by_ray += usize::from(landing.patch != own);
        }
        [landed, by_place, by_ray]
    }
}

/// Patches 0 and 1 of the floor's front below and above x = [`FOOT`].
fn by_cut() -> PatchLocator {
    let cut = Cut { plane: [1.0, 0.0, 0.0, FOOT], child: [0, 1] };
    let face_start = vec![0, 1, 1, 1, 1, 1, 1];
    PatchLocator {
        cell_size: 9.0,
        cell_patch: vec![CUT],
        cell_key: vec![0],
        face_start,
        cuts: vec![cut],
        ..Default::default()
    }
}

/// The same, by cells that end there.
fn by_cells() -> PatchLocator {
    let face_start = vec![0, 2, 2, 2, 2, 2, 2];
    let grid_origin = [FOOT - 9.0, -4.5, -4.5];
    PatchLocator { grid_origin, cell_size: 9.0, cell_patch: vec![0, 1], cell_key: vec![0, 1], face_start, cuts: vec![] }
}

#[test]
fn no_ray_lands_across_a_wall_whatever_parts_the_floor_and_however_the_wall_leans() {
    for (name, locator) in [("cut", by_cut()), ("cells", by_cells())] {
        for lean in [0.0, 0.6, -1.7] {
            let [landed, by_place, by_ray] = Parted::new(lean).astray(&locator);
            assert!(landed > 1000 && by_place > 20, "{name}, {lean}: {by_place} of {landed} show nothing");
            assert_eq!(by_ray, 0, "{name}, {lean}: of {landed}, {by_place} by place alone");
        }
    }
}

#[test]
fn a_ray_that_lands_away_from_borders_is_looked_up_where_it_lands() {
    let (parted, locator) = (Parted::new(0.0), by_cut());
    let down = |x: f32| land(&parted.rays, &locator, Vec3::new(x, 0.1, 1.0), Vec3::NEG_Z, NO_TRIANGLE);
    for (x, patch) in [(-1.0, 0), (0.29, 0), (0.31, 1), (1.0, 1)] {
        let landing = down(x).expect("the floor");
        assert_eq!((landing.face, landing.patch), (0, Some(patch)));
        assert!(landing.position.distance(Vec3::new(x, 0.1, 0.0)) < 1e-6);
    }
    let across = land(&parted.rays, &locator, Vec3::new(-1.0, 0.1, 1.0), Vec3::X, NO_TRIANGLE).expect("the wall");
    assert_eq!(across.patch, None, "the wall has no patches");
    assert!(land(&parted.rays, &locator, Vec3::new(-1.0, 0.1, 1.0), Vec3::Z, NO_TRIANGLE).is_none(), "up is nothing");
}
