//! What is one patch and what is not.

mod common;

use common::{Build, at_voxel, furnished, patches_with, simplify, triangles_of, v};
use glam::Vec3;
use radfile::{Patches, Quiet};
use voxel_simplify::{Params, Resolution, voxel_simplify};

/// A room around what is tested, so that everything sees something.
fn in_a_room(build: impl FnOnce(&mut Build) -> Vec<Vec<u32>>) -> (Build, Vec<Vec<u32>>) {
    let mut scene = Build::new();
    scene.room(v(-5.0, -5.0, -5.0), v(5.0, 5.0, 5.0), 0);
    let sheets = build(&mut scene);
    (scene, sheets)
}

fn level(build: &mut Build, z: f32, size: f32) -> Vec<u32> {
    let h = 0.5 * size;
    build.quad([v(-h, -h, z), v(h, -h, z), v(h, h, z), v(-h, h, z)], 0).to_vec()
}

fn never_shared(patches: &Patches, sheets: &[Vec<u32>]) {
    for patch in 0..patches.len() {
        let touched = sheets.iter().filter(|s| triangles_of(patches, patch).iter().any(|t| s.contains(t))).count();
        assert!(touched <= 1, "patch {patch} has pieces of {touched} sheets: {:?}", triangles_of(patches, patch));
    }
}

#[test]
fn a_sheet_gives_light_back_on_both_sides() {
    let (build, sheets) = in_a_room(|b| vec![level(b, 0.1, 1.0)]);
    let (patches, _) = simplify(&build.scene(), 20.0);
    let own = patches_with(&patches, &sheets[0]);
    assert_eq!(own.len(), 2, "one patch a side");
    let normals: Vec<f32> = own.iter().map(|&p| patches.normal[p][2]).collect();
    assert_eq!(normals, [1.0, -1.0]);
    assert!(own.iter().all(|&p| patches.area[p] == 1.0));
}

#[test]
fn one_sided_surfaces_have_no_back() {
    let (mut build, sheets) = in_a_room(|b| vec![level(b, 0.1, 1.0)]);
    build.mesh.one_sided = true;
    let (patches, report) = simplify(&build.scene(), 20.0);
    assert_eq!(patches_with(&patches, &sheets[0]).len(), 1);
    assert!(patches.pieces.iter().all(|p| p.face % 2 == 0), "a back side has a piece");
    assert!((report.scene_area - 601.0).abs() < 1e-3, "{} m²", report.scene_area);
    let backs = (0..patches.locator.face_start.len() - 1).filter(|f| f % 2 == 1);
    assert!(backs.map(|f| f as u32).all(|f| patches.locator.patch_at(f, [0.0; 3]).is_none()));
}

#[test]
fn the_faces_of_a_wall_one_millimetre_thick_are_different_patches() {
    let (build, sheets) = in_a_room(|b| {
        let top = level(b, 0.0, 2.0);
        let bottom =
            b.quad([v(-1.0, -1.0, -0.001), v(-1.0, 1.0, -0.001), v(1.0, 1.0, -0.001), v(1.0, -1.0, -0.001)], 0);
        vec![top, bottom.to_vec()]
    });
    let scene = build.scene();
    for voxel in [0.25, 1.0, 20.0] {
        never_shared(&simplify(&scene, voxel).0, &sheets);
    }
}

#[test]
fn a_closed_thin_wall_keeps_its_faces_apart_although_its_edges_join_them() {
    let mut build = Build::new();
    build.room(v(-5.0, -5.0, -5.0), v(5.0, 5.0, 5.0), 0);
    let first = build.mesh.triangles.len() as u32;
    build.solid(v(-1.0, -1.0, 0.0), v(1.0, 1.0, 0.001), 0);
    let sheets = [vec![first, first + 1], vec![first + 2, first + 3]];
    let scene = build.scene();
    for voxel in [0.25, 1.0, 20.0] {
        never_shared(&simplify(&scene, voxel).0, &sheets);
    }
}

#[test]
fn parallel_sheets_in_one_voxel_never_share_a_patch() {
    let (build, sheets) = in_a_room(|b| (0..4).map(|i| level(b, 0.05 * i as f32, 1.0 - 0.2 * i as f32)).collect());
    for scene in [build.clone().scene(), build.tilted().scene()] {
        for voxel in [0.3, 1.0, 7.0, 100.0] {
            never_shared(&simplify(&scene, voxel).0, &sheets);
        }
    }
}

/// The flaps share an edge and nearly a plane; the front of one faces like the back of the other.
#[test]
fn the_two_flaps_of_a_sharp_wedge_never_share_a_patch() {
    let (build, sheets) = in_a_room(|b| {
        let upper = b.quad([v(0.0, -1.0, 0.0), v(1.0, -1.0, 0.05), v(1.0, 1.0, 0.05), v(0.0, 1.0, 0.0)], 0);
        let lower = b.quad([v(0.0, -1.0, 0.0), v(0.0, 1.0, 0.0), v(1.0, 1.0, -0.05), v(1.0, -1.0, -0.05)], 0);
        vec![upper.to_vec(), lower.to_vec()]
    });
    let scene = build.scene();
    for voxel in [0.3, 1.0, 20.0] {
        never_shared(&simplify(&scene, voxel).0, &sheets);
    }
}

#[test]
fn winding_does_not_tear_a_sheet() {
    let (build, sheets) = in_a_room(|b| {
        let left = b.quad([v(-1.0, 0.0, 0.0), v(0.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(-1.0, 1.0, 0.0)], 0);
        let right = b.quad([v(0.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(1.0, 1.0, 0.0), v(1.0, 0.0, 0.0)], 0);
        vec![[left, right].concat()]
    });
    let (patches, _) = simplify(&build.scene(), 20.0);
    let own = patches_with(&patches, &sheets[0]);
    assert_eq!(own.iter().map(|&p| patches.area[p]).collect::<Vec<_>>(), [2.0, 2.0]);
}

/// Three quads meet at edges of different lengths, so no two of them share two vertices.
#[test]
fn t_junctions_do_not_tear_a_sheet() {
    let (build, sheets) = in_a_room(|b| {
        let square = |b: &mut Build, x: [f32; 2], y: [f32; 2]| {
            b.quad([v(x[0], y[0], 0.3), v(x[1], y[0], 0.3), v(x[1], y[1], 0.3), v(x[0], y[1], 0.3)], 0)
        };
        let all =
            [square(b, [0.0, 2.0], [0.0, 1.0]), square(b, [0.0, 0.7], [1.0, 2.0]), square(b, [0.7, 2.0], [1.0, 2.0])];
        vec![all.concat()]
    });
    let (patches, _) = simplify(&build.scene(), 20.0);
    let own = patches_with(&patches, &sheets[0]);
    assert_eq!(own.len(), 2, "one patch a side");
}

/// A partition without thickness stands where the floors of two rooms meet; its edge spans both of them or more.
#[test]
fn floors_on_both_sides_of_a_partition_never_share_a_patch() {
    for reach in [0.0, 0.3] {
        let mut build = Build::new();
        build.room(v(-5.0, -5.0, -5.0), v(5.0, 5.0, 5.0), 0);
        let left = build.quad([v(-2.0, -1.0, 0.0), v(0.1, -1.0, 0.0), v(0.1, 1.0, 0.0), v(-2.0, 1.0, 0.0)], 0);
        let right = build.quad([v(0.1, -1.0, 0.0), v(2.0, -1.0, 0.0), v(2.0, 1.0, 0.0), v(0.1, 1.0, 0.0)], 0);
        let low = -1.0 - reach;
        build.quad([v(0.1, low, 0.0), v(0.1, 1.0, 0.0), v(0.1, 1.0, 3.0), v(0.1, low, 3.0)], 0);
        for scene in [build.clone().scene(), build.tilted().scene()] {
            for voxel in [0.4, 1.0, 20.0] {
                never_shared(&simplify(&scene, voxel).0, &[left.to_vec(), right.to_vec()]);
            }
        }
    }
}

#[test]
fn a_repeated_triangle_counts_once_and_its_rays_find_the_same_patch() {
    for turned in [false, true] {
        let (mut build, sheets) = in_a_room(|b| vec![level(b, 0.1, 1.0)]);
        let (_, before) = simplify(&build.clone().scene(), 0.4);
        let again = level(&mut build, 0.1, 1.0);
        if turned {
            again.iter().for_each(|&t| build.mesh.triangles[t as usize].swap(0, 1));
        }
        let (patches, report) = simplify(&build.scene(), 0.4);
        assert_eq!(report.coincident_triangles, 2);
        assert_eq!(report.scene_area, before.scene_area);
        assert_eq!(report.patches, before.patches);
        let point = [0.1, 0.05, 0.1];
        for (&first, &second) in sheets[0].iter().zip(&again) {
            for side in 0..2 {
                let twin = 2 * second + if turned { 1 - side } else { side };
                let (a, b) = (patches.locator.patch_at(2 * first + side, point), patches.locator.patch_at(twin, point));
                assert!(a.is_some() && a == b, "{a:?} {b:?}, turned {turned}");
            }
        }
    }
}

/// A lamp is often modelled as a second copy of a piece of ceiling.
#[test]
fn light_of_a_repeated_triangle_is_not_lost() {
    let (mut build, _) = in_a_room(|b| vec![level(b, 0.1, 1.0)]);
    let lamp = build.material([0.0; 3], [1.0; 3]);
    let copy = level(&mut build, 0.1, 1.0);
    for t in copy {
        build.mesh.triangle_material[t as usize] = lamp;
        build.mesh.triangles[t as usize].swap(0, 1);
    }
    let (patches, report) = simplify(&build.scene(), 0.4);
    assert!((report.patch_flux[0] - std::f64::consts::PI).abs() < 1e-4, "{:?}", report.patch_flux);
    let shining = (0..patches.len()).filter(|&p| patches.emission[p][0] > 0.0);
    assert!(shining.map(|p| patches.normal[p]).all(|n| n[2] < -0.99), "it shines to the wrong side");
}

/// Cell planes of voxels of 0.5 m pass through many coordinates that walls like.
#[test]
fn a_sheet_in_a_plane_between_cells_is_in_one_layer_of_them() {
    let (build, _) = in_a_room(|_| vec![]);
    let (probe, _) = simplify(&build.clone().scene(), 0.5);
    let plane = probe.locator.grid_origin[2] + 10.0 * 0.5;
    let mut build = build;
    let sheet = level(&mut build, plane, 3.0);
    let (patches, report) = simplify(&build.scene(), 0.5);
    assert!(report.area_error < 1e-6);
    let own = patches_with(&patches, &sheet);
    let area: f32 = own.iter().map(|&p| patches.area[p]).sum();
    assert!((area - 18.0).abs() < 1e-4, "both sides hold {area} m², expected 18");
    for &p in &own {
        for piece in patches.pieces_of(p) {
            let [a, b, c] = piece.corners.map(Vec3::from);
            let near = ((a + b + c) / 3.0 + v(0.0, 0.0, -1e-6)).to_array();
            assert_eq!(patches.locator.patch_at(piece.face, near), Some(p as u32), "below the plane, at {near:?}");
        }
    }
}

#[test]
fn slivers_join_what_they_touch() {
    let mut build = Build::new();
    build.room(v(0.0, 0.0, 0.0), v(3.0, 3.0, 3.0), 0);
    // Pokes 5 mm into the next cell, wherever the planes are.
    for i in 0..20 {
        let x = 0.1 + 0.137 * i as f32;
        build.quad(
            [v(0.2, x, 1.0), v(0.2 + 0.13 * i as f32, x, 1.0), v(0.2 + 0.13 * i as f32, x, 1.7), v(0.2, x, 1.7)],
            0,
        );
    }
    let (patches, report) = simplify(&build.scene(), 0.4);
    assert!(report.merged > 0);
    let small = patches.area.iter().filter(|&&a| a < 0.04 * 0.16).count();
    assert_eq!(small, 0, "small patches with a neighbour to join are left");
}

#[test]
fn what_touches_nothing_shares_patches_only_where_a_number_is_asked_for() {
    let mut build = Build::new();
    build.room(v(0.0, 0.0, 0.0), v(4.0, 4.0, 4.0), 0);
    for i in 0..600u32 {
        let at = v(0.3 + 0.13 * (i % 25) as f32, 0.3 + 0.14 * (i / 25) as f32, 1.0 + 0.01 * (i % 7) as f32);
        build.solid(at, at + 0.03, 0);
    }
    let scene = build.scene();
    let (_, strict) = simplify(&scene, 1.0);
    assert_eq!(strict.gathered, 0);
    assert!(strict.patches > 3600, "each of 600 cubes has at least six patches, there are {}", strict.patches);
    let params = Params { resolution: Resolution::Patches(400), ..Params::default() };
    let (patches, report) = voxel_simplify(&scene, &params, &Quiet).expect("sound");
    assert!((360..=440).contains(&report.patches), "{} patches", report.patches);
    assert!(
        report.gathered > 0 && report.warnings.iter().any(|w| w.contains("need not touch")),
        "{:?}",
        report.warnings
    );
    assert!(report.area_error < 1e-6);
    // Pockets inside the cubes are dropped: no ray reaches them.
    let inside = patches.pieces.iter().filter(|p| p.face / 2 >= 12 && p.face % 2 == 1).count();
    assert_eq!(inside, 0);
}

#[test]
fn insides_of_solids_get_coarser_patches_where_a_number_is_asked_for() {
    let mut build = Build::new();
    build.room(v(0.0, 0.0, 0.0), v(4.0, 4.0, 3.0), 0);
    for i in 0..4u32 {
        let at = v(0.5 + 1.7 * (i % 2) as f32, 0.5 + 1.8 * (i / 2) as f32, 0.0);
        build.solid(at, at + v(1.2, 1.1, 2.0), 0);
    }
    let params = Params { resolution: Resolution::Patches(2000), ..Params::default() };
    let (patches, report) = voxel_simplify(&build.scene(), &params, &Quiet).expect("sound");
    assert!(report.coarsened > 0 && report.area_error < 1e-6, "{report:?}");
    let mean = |back: bool| {
        let which = || (0..patches.len()).filter(|&p| (patches.pieces_of(p)[0].face % 2 == 1) == back);
        which().map(|p| patches.area[p]).sum::<f32>() / which().count() as f32
    };
    // Voxels and blocks of them cut the solids at different places; uniform patches would be equally large.
    assert!(mean(true) > 1.8 * mean(false), "insides {} m², outsides {} m²", mean(true), mean(false));
}

/// Seen from inside, a room whose walls are wound the wrong way is all back sides.
#[test]
fn a_room_modelled_inside_out_is_not_taken_for_a_solid() {
    let mut build = Build::new();
    build.solid(v(0.0, 0.0, 0.0), v(4.0, 4.0, 3.0), 0);
    build.solid(v(1.0, 1.0, 0.0), v(1.5, 1.5, 0.7), 0);
    let params = Params { resolution: Resolution::Patches(1000), ..Params::default() };
    let (_, report) = voxel_simplify(&build.scene(), &params, &Quiet).expect("sound");
    assert_eq!(report.coarsened, 0);
}

/// Tiny cubes on both sides of a wall face the same way and lie in one voxel, but in different air.
#[test]
fn parts_behind_a_wall_never_share_a_patch_with_those_before_it() {
    let mut build = Build::new();
    build.room(v(0.0, 0.0, 0.0), v(4.0, 4.0, 2.0), 0);
    build.room(v(0.0, 0.0, 2.01), v(4.0, 4.0, 4.0), 0);
    let mut sides: [Vec<u32>; 2] = Default::default();
    for i in 0..900u32 {
        for (side, z) in [1.9, 2.05].into_iter().enumerate() {
            let first = build.mesh.triangles.len() as u32;
            let at = v(0.2 + 0.12 * (i % 30) as f32, 0.2 + 0.12 * (i / 30) as f32, z);
            build.solid(at, at + 0.03, 0);
            sides[side].extend(first..first + 12);
        }
    }
    let params = Params { resolution: Resolution::Patches(500), ..Params::default() };
    let (patches, report) = voxel_simplify(&build.scene(), &params, &Quiet).expect("sound");
    assert!(report.gathered > 0);
    for patch in 0..patches.len() {
        let own = triangles_of(&patches, patch);
        let [below, above] = [0, 1].map(|s: usize| own.iter().any(|t| sides[s].binary_search(t).is_ok()));
        assert!(!(below && above), "patch {patch} stands on both sides of the wall");
    }
}

#[test]
fn the_number_of_threads_does_not_change_a_byte() {
    let scene = furnished().tilted().scene();
    let run = |threads: usize, params: &Params| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| voxel_simplify(&scene, params, &Quiet).expect("sound"))
    };
    for params in [at_voxel(0.2), Params { resolution: Resolution::Patches(300), ..Params::default() }] {
        let (one, three) = (run(1, &params), run(3, &params));
        assert!(one.0 == three.0, "patches differ");
        assert_eq!(one.1, three.1);
    }
}
