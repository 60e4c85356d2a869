//! Elements: parts of what is seen of a patch, and what a gather makes of them.

mod common;
mod staged;

use common::Maker;
use glam::Vec3;
use radfile::{Elements, Mesh, Patches, PointRows, Quiet, Side};
use scene::{NO_TRIANGLE, Rays, SurfacePoint, Surfaces};
use staged::grey;
use transfer::{GatherParams, Senders, gather_for_points, subdivide};

fn parted(mesh: &Mesh, patches: &Patches) -> Elements {
    let scene = grey(mesh.clone());
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials).expect("no textures");
    subdivide(patches, &surfaces, &Rays::new(mesh), &Quiet)
}

fn room() -> (Mesh, Patches) {
    let mut maker = Maker::new(0.5);
    maker.room(Vec3::ZERO, Vec3::ONE, [2; 3]);
    let (mesh, mut patches) = maker.finish();
    // No wall lies in a plane of the grid, where rounding would decide.
    patches.locator.grid_origin = [-1e-3; 3];
    (mesh, patches)
}

/// Rays land evenly on all that is seen, so quarters of a square are quarters: 512 landings, four deviations.
#[test]
fn patches_of_a_closed_room_are_parted_into_equal_quarters() {
    let (mesh, patches) = room();
    let elements = parted(&mesh, &patches);
    assert_eq!(elements.len(), 4 * patches.len());
    for patch in 0..patches.len() {
        let area: f32 = elements.of(patch).map(|e| elements.area[e]).sum();
        assert!((area / patches.area[patch] - 1.0).abs() < 1e-5, "patch {patch}: {area}");
        for e in elements.of(patch) {
            let share = elements.area[e] / patches.area[patch];
            assert!((share - 0.25).abs() < 4.0 * (0.25 * 0.75 / 512.0f32).sqrt(), "element {e} has {share}");
            assert_eq!(elements.reflectance[e], [0.5; 3]);
            for p in elements.point_start[e] as usize..elements.point_start[e + 1] as usize {
                let point = elements.point[p];
                assert_eq!(elements.at(patch, point) as usize, e, "point {p}");
                assert_eq!(patches.locator.patch_at(elements.point_face[p], point), Some(patch as u32), "point {p}");
            }
        }
    }
}

/// A sheet under half of a ceiling's patch hides that half: its elements lie in the other.
#[test]
fn what_is_hidden_of_a_patch_is_in_no_element() {
    let mut maker = Maker::new(1.0);
    maker.sheet(Vec3::ZERO, Vec3::Z, Vec3::X, [1, 1], &[Side::Front]);
    maker.sheet(Vec3::Y, Vec3::X, Vec3::Z, [1, 1], &[Side::Front]);
    // A thousandth below the ceiling, without patches on the side that looks up.
    maker.sheet(Vec3::new(0.0, 0.999, 0.0), Vec3::X * 0.5, Vec3::Z, [1, 1], &[Side::Front]);
    let (mesh, patches) = maker.finish();
    let elements = parted(&mesh, &patches);
    for e in elements.of(1) {
        for p in elements.point_start[e] as usize..elements.point_start[e + 1] as usize {
            assert!(elements.point[p][0] > 0.49, "{:?} is behind the sheet", elements.point[p]);
        }
    }
    let area: f32 = elements.of(1).map(|e| elements.area[e]).sum();
    assert!((area - 1.0).abs() < 1e-5, "what is seen stands for all: {area}");
}

/// The top of a thin wall: no cell has a thirty-second of it.
#[test]
fn a_patch_much_longer_than_wide_has_elements_too() {
    let mut maker = Maker::new(0.02);
    maker.sheet(Vec3::ZERO, Vec3::Z * 0.001, Vec3::X * 4.0, [1, 1], &[Side::Front]);
    maker.sheet(Vec3::Y, Vec3::X * 4.0, Vec3::Z * 0.001, [1, 1], &[Side::Front]);
    let (mesh, patches) = maker.finish();
    let elements = parted(&mesh, &patches);
    for patch in 0..2 {
        let area: f32 = elements.of(patch).map(|e| elements.area[e]).sum();
        assert!((area / patches.area[patch] - 1.0).abs() < 1e-5, "patch {patch}: {area}");
    }
}

/// Near patches are told apart, far ones are not; either way nothing is counted twice.
#[test]
fn rows_over_patches_and_elements_sum_to_one_in_a_closed_room() {
    let (mesh, patches) = room();
    let elements = parted(&mesh, &patches);
    let senders = Senders { patches: &patches, elements: &elements, rays: &Rays::new(&mesh) };
    let point = SurfacePoint { position: Vec3::new(0.05, 0.0, 0.5), normal: Vec3::Y, triangle: NO_TRIANGLE };
    for (rays, told_apart) in [(64, 0..3), (4096, 12..25)] {
        let params = GatherParams { rays, ..GatherParams::default() };
        let PointRows::Gathered { rows, sky } = gather_for_points(&senders, &[point], &params, &Quiet) else {
            panic!("points are gathered")
        };
        let sum: f32 = rows.row(0).map(|(_, share)| share).sum();
        assert!((sum - 1.0).abs() < 1e-5 && sky[0] == 0.0, "{sum}");
        let n = patches.len();
        let mut parted: Vec<usize> =
            (0..n).filter(|&p| rows.row(0).any(|(s, _)| s >= n && elements.of(p).contains(&(s - n)))).collect();
        assert!(parted.iter().all(|&p| rows.row(0).all(|(s, _)| s != p)), "{parted:?} are whole as well");
        parted.dedup();
        assert!(told_apart.contains(&parted.len()), "{rays} rays tell {} patches apart", parted.len());
    }
}

#[test]
fn elements_are_the_same_for_any_number_of_threads() {
    let (mesh, patches) = room();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| parted(&mesh, &patches))
    };
    assert_eq!(with(1), with(3));
}
