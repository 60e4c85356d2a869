//! Floors that run on under what stands on them: no patch is open floor and covered floor at once.

mod common;

use common::{Build, simplify, tilt, v};
use glam::{Quat, Vec3};
use radfile::{Patches, Quiet};
use scene::Scene;
use voxel_simplify::{Params, Report, Resolution, voxel_simplify};

const VOXELS: [f32; 5] = [0.17, 0.3, 0.7, 1.3, 20.0];
/// Patches that miss a border by less are in its place but for rounding, metres.
const NEAR: f32 = 2e-4;

/// A room of 4 m × 3 m × 2.5 m; its floor, two triangles, lies at z = 0.
fn room() -> Build {
    let mut build = Build::new();
    build.room(v(0.0, 0.0, 0.0), v(4.0, 3.0, 2.5), 0);
    build
}

/// Upper sides of the triangles of the floor.
fn floor(scene: &Scene, back: Quat) -> Vec<u32> {
    let at = |t: &[u32; 3]| t.map(|i| (back * Vec3::from(scene.mesh.positions[i as usize])).to_array());
    let level = |t: &[u32; 3]| at(t).iter().all(|p| p[2].abs() < 1e-5 && (p[0] < 1e-5 || p[0] > 3.9));
    (0..12).filter(|&t| level(&scene.mesh.triangles[t as usize])).map(|t| 2 * t).collect()
}

/// The scene as it is and tilted, and the turn back.
fn both_ways(build: Build) -> [(Scene, Quat); 2] {
    [(build.clone().scene(), Quat::IDENTITY), (build.tilted().scene(), tilt().inverse())]
}

/// Points inside a piece, away from its border.
fn inner_points(corners: [[f32; 3]; 3]) -> impl Iterator<Item = Vec3> {
    let [a, b, c] = corners.map(Vec3::from);
    let weights = [[1, 1, 1], [8, 1, 1], [1, 8, 1], [1, 1, 8], [4, 4, 1], [4, 1, 4], [1, 4, 4]];
    weights.into_iter().map(move |w| {
        let [x, y, z] = w.map(|w| w as f32);
        (x * a + y * b + z * c) / (x + y + z)
    })
}

/// Area of the patches on one side of a border, pieces of `faces` only; a patch on both sides fails.
///
/// `inside` gives the distance of a point from the border, positive inside, metres.
fn area_inside(patches: &Patches, faces: &[u32], inside: impl Fn(Vec3) -> f32) -> f64 {
    let mut sum = 0.0;
    for patch in 0..patches.len() {
        let own = patches.pieces_of(patch).iter().filter(|p| faces.contains(&p.face));
        let distances: Vec<f32> = own.clone().flat_map(|p| inner_points(p.corners)).map(&inside).collect();
        let [most_in, most_out] = [1.0, -1.0].map(|s: f32| distances.iter().fold(0.0f32, |m, d| m.max(s * d)));
        assert!(most_in.min(most_out) < NEAR, "patch {patch} reaches {most_in} m inside and {most_out} m outside");
        if most_in > most_out {
            let area = |p: &radfile::Piece| {
                let [a, b, c] = p.corners.map(|c| Vec3::from(c).as_dvec3());
                0.5 * (b - a).cross(c - a).length()
            };
            sum += own.map(area).sum::<f64>();
        }
    }
    sum
}

/// Distance from the sides of a footprint, positive inside.
fn in_rectangle(low: [f32; 2], high: [f32; 2]) -> impl Fn(Vec3) -> f32 {
    move |p| (p.x - low[0]).min(high[0] - p.x).min(p.y - low[1]).min(high[1] - p.y)
}

/// Points this far from the border on both sides find patches on their side.
fn lookups(patches: &Patches, faces: &[u32], border: &[[f32; 2]], inside: impl Fn(Vec3) -> f32, back: Quat) {
    for edge in border.windows(2) {
        let [a, b] = [edge[0], edge[1]].map(|p| v(p[0], p[1], 0.0));
        for step in 1..40 {
            let middle = a.lerp(b, step as f32 / 40.0);
            let aside = (b - a).normalize().cross(Vec3::Z);
            for point in [0.001, -0.001].map(|d| middle + d * aside) {
                // Which of the two triangles the point lies on, the diagonal through (0, 0) and (4, 3) says.
                let found = faces.iter().map(|&face| {
                    let patch = patches.locator.patch_at(face, (back.inverse() * point).to_array()).expect("a patch");
                    let pieces = patches.pieces_of(patch as usize).iter().filter(|p| p.face == face);
                    let off = pieces.map(|p| off_triangle(p.corners.map(|c| back * Vec3::from(c)), point));
                    off.fold(f32::INFINITY, f32::min)
                });
                let off = found.fold(f32::INFINITY, f32::min);
                assert!(off < 1e-4, "{point} is {off} m off the patch that it finds, {} m inside", inside(point));
            }
        }
    }
}

/// How far a point of its plane lies outside a triangle.
fn off_triangle([a, b, c]: [Vec3; 3], p: Vec3) -> f32 {
    let normal = (b - a).cross(c - a).normalize();
    let beyond = |q: Vec3, r: Vec3| -normal.cross((r - q).normalize()).dot(p - q);
    beyond(a, b).max(beyond(b, c)).max(beyond(c, a))
}

fn check_box(bottom: f32, voxels: &[f32]) {
    let (low, high) = ([1.13, 0.87], [2.06, 1.94]);
    let mut build = room();
    build.solid(v(low[0], low[1], bottom), v(high[0], high[1], 1.2), 0);
    let footprint = f64::from(high[0] - low[0]) * f64::from(high[1] - low[1]);
    for (scene, back) in both_ways(build) {
        let faces = floor(&scene, back);
        assert_eq!(faces.len(), 2, "the floor");
        for &voxel in voxels {
            let (patches, report) = simplify(&scene, voxel);
            assert!(report.cut > 0 && report.capped == 0 && report.area_error < 1e-6, "{report:?}");
            let inside = in_rectangle(low, high);
            let covered = area_inside(&patches, &faces, |p| inside(back * p));
            let open = area_inside(&patches, &faces, |p| -inside(back * p));
            // Under a sunk or hovering box rays may find nothing, then it is dropped.
            let whole = 12.0 - footprint;
            assert!((open - whole).abs() < 1e-4 * whole, "voxel {voxel}: {open} m² of {whole} are open");
            assert!(covered == 0.0 || (covered - footprint).abs() < 1e-4, "{covered} m² of {footprint} are covered");
            let border = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]], [low[0], low[1]]];
            lookups(&patches, &faces, &border, &inside, back);
        }
    }
}

#[test]
fn the_floor_under_a_box_shares_no_patch_with_the_floor_around_it() {
    check_box(0.0, &VOXELS);
}

#[test]
fn a_box_that_is_sunk_into_the_floor_parts_it_too() {
    check_box(-0.05, &VOXELS);
}

#[test]
fn a_box_that_hovers_by_rounding_parts_the_floor_too() {
    check_box(1e-6, &VOXELS);
}

#[test]
fn a_box_that_hovers_by_less_than_patches_parts_the_floor_too() {
    // Among the largest voxels its edges are details.
    check_box(0.001, &VOXELS[..4]);
}

#[test]
fn a_sheet_that_ends_above_the_floor_parts_it_unless_it_is_a_detail() {
    let cut_by = |wide: f32, voxel: f32| {
        let mut build = room();
        build.quad([v(1.87, 0.0, 0.05), v(1.87, wide, 0.05), v(1.87, wide, 1.2), v(1.87, 0.0, 1.2)], 0);
        let scene = build.scene();
        let (patches, report) = simplify(&scene, voxel);
        (floor(&scene, Quat::IDENTITY), patches, report)
    };
    for voxel in [0.7, 1.3] {
        let (faces, patches, report) = cut_by(3.0, voxel);
        let beyond = area_inside(&patches, &faces, |p| p.x - 1.87);
        assert!(
            (beyond - 3.0 * 2.13).abs() < 1e-4 && report.capped == 0,
            "voxel {voxel}: {beyond} m² beyond, {report:?}"
        );
        let (faces, patches, _) = cut_by(0.3, voxel);
        let straddles = |p: usize| {
            let xs = || {
                patches.pieces_of(p).iter().filter(|p| faces.contains(&p.face)).flat_map(|p| p.corners).map(|c| c[0])
            };
            xs().any(|x| x < 1.8) && xs().any(|x| x > 1.9)
        };
        assert!((0..patches.len()).any(straddles), "voxel {voxel}: a narrow sheet parts the floor");
    }
}

/// No patch of the scene has points on both sides of any of these planes; a thickness lies between.
fn keeps_apart(patches: &Patches, sides: &[(usize, f32, f32)], back: Quat) {
    for patch in 0..patches.len() {
        for &(axis, low, high) in sides {
            let points =
                || patches.pieces_of(patch).iter().flat_map(|p| p.corners).map(|c| (back * Vec3::from(c))[axis]);
            let (least, most) = (points().fold(f32::INFINITY, f32::min), points().fold(f32::NEG_INFINITY, f32::max));
            assert!(
                least > low - NEAR || most < high + NEAR,
                "patch {patch} reaches from {least} to {most} on axis {axis}"
            );
        }
    }
}

#[test]
fn a_wall_between_two_rooms_on_one_floor_keeps_their_patches_apart() {
    let standing = [(1.93, 2.05, 0.0), (1.93, 2.05, 0.02), (2.0, 2.0, 0.0), (2.0, 2.0, 0.02)];
    for (low, high, sunk) in standing {
        let mut build = room();
        let (from, to) = (v(low, -sunk, -sunk), v(high, 3.0 + sunk, 2.5 + sunk));
        match low < high {
            true => build.solid(from, to, 0),
            false => _ = build.quad([from, v(low, to.y, from.z), to, v(low, from.y, to.z)], 0),
        }
        for (scene, back) in both_ways(build) {
            for voxel in VOXELS {
                keeps_apart(&simplify(&scene, voxel).0, &[(0, low, high)], back);
            }
        }
    }
}

#[test]
fn two_walls_that_cross_keep_four_rooms_apart() {
    let mut build = room();
    build.quad([v(1.87, 0.0, 0.0), v(1.87, 3.0, 0.0), v(1.87, 3.0, 2.5), v(1.87, 0.0, 2.5)], 0);
    build.quad([v(0.0, 1.41, 0.0), v(4.0, 1.41, 0.0), v(4.0, 1.41, 2.5), v(0.0, 1.41, 2.5)], 0);
    for (scene, back) in both_ways(build) {
        for voxel in VOXELS {
            let (patches, report) = simplify(&scene, voxel);
            assert!(report.area_error < 1e-6, "{report:?}");
            keeps_apart(&patches, &[(0, 1.87, 1.87), (1, 1.41, 1.41)], back);
        }
    }
}

/// A floor just below a plane between layers of cells and a wall just above it have no cell in common.
#[test]
fn a_wall_parts_a_floor_that_lies_in_the_layer_below_it() {
    let mut build = Build::new();
    build.room(v(-5.0, -5.0, -5.0), v(5.0, 5.0, 5.0), 0);
    let (probe, _) = simplify(&build.clone().scene(), 0.5);
    let plane = probe.locator.grid_origin[2] + 10.0 * 0.5;
    let [low, high] = [plane - 4e-6, plane + 4e-6];
    let floor = build.quad([v(-1.5, -1.5, low), v(1.5, -1.5, low), v(1.5, 1.5, low), v(-1.5, 1.5, low)], 0);
    build.quad([v(0.1, -1.5, high), v(0.1, 1.5, high), v(0.1, 1.5, 2.0), v(0.1, -1.5, 2.0)], 0);
    let (patches, report) = simplify(&build.scene(), 0.5);
    assert!(report.cut > 0 && report.area_error < 1e-6, "{report:?}");
    for side in 0..2 {
        let faces = floor.map(|t| 2 * t + side);
        let right = area_inside(&patches, &faces, |p| p.x - 0.1);
        assert!((right - 3.0 * 1.4).abs() < 1e-4, "{right} m² lie behind the wall");
    }
}

/// Many small triangles without an edge under the wall must not link the rooms to each other.
#[test]
fn a_wall_parts_a_floor_of_small_triangles() {
    let mut build = Build::new();
    build.room(v(0.0, 0.0, -1.0), v(4.0, 3.0, 2.5), 0);
    let at = |i: u32, j: u32| v(4.0 * i as f32 / 37.0, 3.0 * j as f32 / 29.0, 0.0);
    for (i, j) in (0..37).flat_map(|i| (0..29).map(move |j| (i, j))) {
        build.quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], 0);
    }
    build.solid(v(1.93, 0.0, 0.0), v(2.05, 3.0, 2.5), 0);
    for (scene, back) in both_ways(build) {
        for voxel in [0.3, 1.0, 2.0] {
            let (patches, _) = simplify(&scene, voxel);
            let faces: Vec<u32> = (12..12 + 2 * 37 * 29).map(|t| 2 * t).collect();
            let wall = |p: Vec3| (p.x - 1.93).min(2.05 - p.x);
            let open = area_inside(&patches, &faces, |p| -wall(back * p));
            // Parts below 2 % of their triangle stay with it.
            assert!((open - 3.0 * 3.88).abs() < 0.01, "{open} m² are open");
        }
    }
}

/// A round column touches many cells with short sides; what straddles its border is a small part of it.
#[test]
fn the_foot_of_a_column_is_cut_out_of_the_floor() {
    let (sides, radius, centre) = (16, 0.31, [1.77, 1.36]);
    let mut build = room();
    let at = |k: u32, z: f32| {
        let angle = std::f32::consts::TAU * (k % sides) as f32 / sides as f32;
        v(centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin(), z)
    };
    for k in 0..sides {
        build.quad([at(k, 0.0), at(k + 1, 0.0), at(k + 1, 2.5), at(k, 2.5)], 0);
    }
    let foot = 0.5 * f64::from(sides) * f64::from(radius).powi(2) * (std::f64::consts::TAU / f64::from(sides)).sin();
    for (scene, back) in both_ways(build) {
        let faces = floor(&scene, back);
        for voxel in [0.3, 0.7, 1.3, 2.0] {
            let (patches, report) = simplify(&scene, voxel);
            assert!(report.area_error < 1e-6, "{report:?}");
            let beside = |p: Vec3| {
                let p = back * p;
                (p.x - centre[0]).hypot(p.y - centre[1]) - radius
            };
            let touches = |patch: usize, outside: bool| {
                let own = || patches.pieces_of(patch).iter().filter(|p| faces.contains(&p.face));
                own()
                    .flat_map(|p| inner_points(p.corners))
                    .any(|p| (beside(p) > 0.1 * radius) == outside && (outside || beside(p) < -0.3 * radius))
            };
            let covered: Vec<usize> = (0..patches.len()).filter(|&p| touches(p, false)).collect();
            assert!(covered.iter().all(|&p| !touches(p, true)), "voxel {voxel}: a patch straddles the border");
            let area: f64 = covered.iter().map(|&p| f64::from(patches.area[p])).sum();
            assert!((area - foot).abs() < 0.1 * foot, "voxel {voxel}: {area} m² of {foot} are covered");
        }
    }
}

#[test]
fn more_cuts_than_a_piece_may_have_are_counted_and_lose_nothing() {
    let mut build = room();
    for i in 0..60 {
        let at = v(0.2 + 0.35 * (i % 10) as f32, 0.3 + 0.41 * (i / 10) as f32, 0.0);
        build.solid(at, at + v(0.1, 0.13, 0.5), 0);
    }
    let (patches, report) = simplify(&build.scene(), 20.0);
    assert!(report.capped > 0 && report.area_error < 1e-6, "{report:?}");
    assert!(patches.locator.cuts.iter().all(|c| c.plane.iter().all(|x| x.is_finite())));
}

/// A chair's legs and a rug's rim are cut out, but they must not crowd out the rest.
#[test]
fn a_number_of_patches_counts_what_was_cut() {
    let mut build = room();
    build.solid(v(1.13, 0.87, 0.0), v(2.06, 1.94, 1.2), 0);
    build.solid(v(2.5, 0.4, 0.0), v(3.7, 2.2, 0.008), 0);
    for [x, y] in [[0.3, 0.3], [0.7, 0.3], [0.3, 0.7], [0.7, 0.7]] {
        build.solid(v(x, y, 0.0), v(x + 0.04, y + 0.04, 0.45), 0);
    }
    let scene = build.scene();
    for wanted in [400, 1500] {
        let params = Params { resolution: Resolution::Patches(wanted), ..Params::default() };
        let (patches, report): (Patches, Report) = voxel_simplify(&scene, &params, &Quiet).expect("sound");
        let off = patches.len() as f64 / f64::from(wanted) - 1.0;
        assert!(off.abs() <= 0.1 && report.cut > 0, "{} patches of {wanted}", patches.len());
        patches.check().expect("patches obey the format");
    }
}
