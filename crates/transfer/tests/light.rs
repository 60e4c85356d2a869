//! What light may and may not do between patches and receivers.

mod common;

use common::Maker;
use glam::Vec3;
use radfile::{Elements, Mesh, NO_RECEIVER, Patches, Quiet, Rows, Side, Transfer, Weights};
use scene::{NO_TRIANGLE, Rays, SurfacePoint};
use transfer::{Interpolated, Mode, Params, Senders, interpolate_for_points, transfer};

const BOTH: &[Side] = &[Side::Front, Side::Back];

/// The receivers of a scene, their weights, and what is said of these.
fn make(mesh: &Mesh, patches: &Patches) -> (Transfer, Rows, Interpolated) {
    let senders = Senders { patches, elements: &Elements::whole(patches), rays: &Rays::new(mesh) };
    let params = Params { mode: Mode::Interpolate, ..Params::default() };
    let (made, report) = transfer(mesh, &senders, &params, &Quiet).expect("it is small");
    made.check(patches.len(), mesh.triangles.len()).expect("the record keeps its rules");
    let Weights::Interpolated(rows) = made.weights.clone() else { panic!("weights were asked for") };
    (made, rows, report.interpolated.expect("they were made"))
}

/// A point that looks up.
fn point(position: Vec3) -> SurfacePoint {
    SurfacePoint { position, normal: Vec3::Y, triangle: NO_TRIANGLE }
}

/// A floor of 8 × 8 patches of half a metre in free space.
fn floor() -> (Mesh, Patches) {
    let mut maker = Maker::new(0.5);
    maker.sheet(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0, [8, 8], &[Side::Front]);
    maker.finish()
}

/// Sums of at most twenty weights that add up to 1 with single rounding.
#[test]
fn a_flat_floor_under_uniform_light_stays_flat() {
    let (mesh, patches) = floor();
    let (made, rows, report) = make(&mesh, &patches);
    assert_eq!(made.receivers(), 145, "9 × 9 corners and the middles of 8 × 8 diagonals");
    assert_eq!((report.empty_rows, report.fallback_rows, report.widened_rows), (0, 0, 0), "{report:?}");
    for light in rows.gather(&vec![[1.0, 2.0, 4.0]; patches.len()]) {
        for (found, wanted) in light.iter().zip([1.0, 2.0, 4.0]) {
            assert!((found / wanted - 1.0).abs() < 1e-6, "{light:?}");
        }
    }
}

/// Light that grows along x; half a patch in from the border every receiver has patches all around it.
#[test]
fn light_that_grows_evenly_across_a_floor_does_so_after_the_transfer() {
    let (mesh, patches) = floor();
    let rays = Rays::new(&mesh);
    let light: Vec<[f32; 3]> = patches.position.iter().map(|p| [p[0], p[2], p[0] - p[2]]).collect();
    let places: Vec<SurfacePoint> = (0..100)
        .map(|i| Vec3::new(0.6 + 0.03 * (i % 10 * 9) as f32, 0.0, 0.6 + 0.03 * (i / 10 * 9) as f32))
        .map(point)
        .collect();
    let rows = interpolate_for_points(&patches, &rays, &places, &Params::default(), &Quiet);
    for (place, found) in places.iter().zip(rows.gather(&light)) {
        // 0.5 % of a voxel: what the ridge of the fit leaves.
        assert!((found[0] - place.position.x).abs() < 0.01, "{place:?}: {found:?}");
        assert!((found[1] - place.position.z).abs() < 0.01, "{place:?}: {found:?}");
    }
}

/// Two rooms of 2 m that share a wall of the given thickness; floors and ceilings are continuous sheets.
fn two_rooms(thickness: f32) -> (Mesh, Patches) {
    let mut maker = Maker::new(0.25);
    for low in [0.0, 2.0 + thickness] {
        maker.room(Vec3::new(low, 0.0, 0.0), Vec3::splat(2.0), [8, 8, 8]);
    }
    maker.finish()
}

#[test]
fn no_light_passes_a_wall_whatever_its_thickness() {
    for thickness in [0.0, 1e-3, 0.15] {
        let (mesh, patches) = two_rooms(thickness);
        let (made, rows, report) = make(&mesh, &patches);
        assert_eq!((report.empty_rows, report.fallback_rows), (0, 0), "{report:?}");
        let middle = 2.0 + 0.5 * thickness;
        for (receiver, position) in made.position.iter().enumerate() {
            // A receiver stands for the room that its face belongs to; in the wall's plane the patch normals tell.
            let own = room_of(*position, made.normal[receiver], middle);
            for (patch, _) in rows.row(receiver) {
                let theirs = room_of(patches.position[patch], patches.normal[patch], middle);
                assert_eq!(own, theirs, "thickness {thickness}: {position:?} takes light of patch {patch}");
            }
        }
    }
}

/// Which side of the wall between the rooms a point of a surface belongs to.
fn room_of(position: [f32; 3], normal: [f32; 3], middle: f32) -> bool {
    position[0] + 1e-4 * normal[0] > middle
}

/// A wall without thickness stands across an undivided floor; its foot is an edge of the floor.
#[test]
fn a_floor_vertex_under_a_sheet_receives_on_either_side_of_it_apart() {
    let mut maker = Maker::new(0.5);
    maker.sheet(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0, [8, 8], &[Side::Front]);
    maker.sheet(Vec3::new(2.0, 0.0, 0.0), Vec3::Y * 2.0, Vec3::Z * 4.0, [4, 8], BOTH);
    let (mesh, patches) = maker.finish();
    let (made, rows, _) = make(&mesh, &patches);
    let lit: Vec<[f32; 3]> = patches
        .position
        .iter()
        .zip(&patches.normal)
        .map(|(p, n)| if room_of(*p, *n, 2.0) { [1.0; 3] } else { [0.0; 3] })
        .collect();
    let floor = 2 * 8 * 8;
    let received = rows.gather(&lit);
    for (t, triangle) in made.fine.triangle.iter().enumerate().filter(|(t, _)| (made.fine.source[*t] as usize) < floor)
    {
        let right = triangle.iter().map(|&v| made.fine.vertex[v as usize][0]).sum::<f32>() > 6.0;
        for &receiver in &made.fine.receiver[t][0] {
            assert!((received[receiver as usize][0] - f32::from(right)).abs() < 1e-6, "fine triangle {t}");
        }
    }
}

/// A point under a bowl that hides every patch within reach keeps the light of the patch below it.
#[test]
fn a_point_that_sees_no_patch_takes_the_one_it_lies_on() {
    let mut maker = Maker::new(0.5);
    maker.sheet(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0, [8, 8], &[Side::Front]);
    let (low, size) = (Vec3::new(0.55, 0.0, 0.55), 0.1);
    maker.sheet(low, Vec3::X * size, Vec3::Y * size, [1, 1], &[]);
    maker.sheet(low + Vec3::Z * size, Vec3::X * size, Vec3::Y * size, [1, 1], &[]);
    maker.sheet(low, Vec3::Z * size, Vec3::Y * size, [1, 1], &[]);
    maker.sheet(low + Vec3::X * size, Vec3::Z * size, Vec3::Y * size, [1, 1], &[]);
    maker.sheet(low + Vec3::Y * size, Vec3::Z * size, Vec3::X * size, [1, 1], &[]);
    let (mesh, patches) = maker.finish();
    let points = [point(low + Vec3::new(0.05, 0.0, 0.05))];
    let rows = interpolate_for_points(&patches, &Rays::new(&mesh), &points, &Params::default(), &Quiet);
    // Second row and second column of the sheet, whose rows run along z.
    assert_eq!(rows.row(0).collect::<Vec<_>>(), [(9, 1.0)]);
    let in_the_air = [point(Vec3::new(2.0, 50.0, 2.0))];
    let rows = interpolate_for_points(&patches, &Rays::new(&mesh), &in_the_air, &Params::default(), &Quiet);
    assert_eq!(rows.row(0).count(), 0, "a point in the air lies on no patch");
}

/// A column of 18 sides: neighbours bend by 20 degrees, so light is smooth around it and there are no seams.
#[test]
fn light_goes_smoothly_around_a_round_column() {
    let sides = 18;
    let at = |i: usize| {
        let angle = std::f32::consts::TAU * (i % sides) as f32 / sides as f32;
        Vec3::new(angle.cos(), 0.0, angle.sin())
    };
    let mut maker = Maker::new(0.35);
    for i in 0..sides {
        maker.sheet(at(i), Vec3::Y * 2.0, at(i + 1) - at(i), [6, 1], &[Side::Front]);
    }
    let (mesh, patches) = maker.finish();
    let (made, rows, report) = make(&mesh, &patches);
    assert_eq!((report.widened_rows, report.fallback_rows), (0, 0), "{report:?}");
    let light: Vec<[f32; 3]> = patches.normal.iter().map(|n| [1.0 + n[0]; 3]).collect();
    for (receiver, found) in rows.gather(&light).iter().enumerate() {
        // The kernel reaches 35 degrees with a variance of an eighth of that squared: it takes cos down by 2.5 %.
        let [x, _, z] = made.position[receiver];
        let wanted = 1.0 + x / x.hypot(z);
        assert!((found[0] - wanted).abs() < 0.05, "{x} {z}: {found:?}");
        let first = rows.row(receiver).next().expect("the report has no empty row").0;
        let sees_around = rows.row(receiver).any(|(p, _)| patches.normal[p] != patches.normal[first]);
        assert!(sees_around, "{x} {z} has light of one side of the column only");
    }
}

#[test]
fn sides_that_see_nothing_have_no_receivers() {
    let (mut mesh, patches) = floor();
    let (made, ..) = make(&mesh, &patches);
    assert!(made.fine.receiver.iter().all(|r| r[1] == [NO_RECEIVER; 3] && !r[0].contains(&NO_RECEIVER)));
    let mut maker = Maker::new(0.5);
    maker.sheet(Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0, [8, 8], BOTH);
    let two_sided = maker.finish().1;
    assert_eq!(make(&mesh, &two_sided).0.receivers(), 2 * 145);
    mesh.one_sided = true;
    assert_eq!(make(&mesh, &two_sided).0.receivers(), 145);
}

/// A receiver at a corner of a room lies inside the room on its own surface, not in the walls beside it.
#[test]
fn receivers_lie_on_their_surface_inside_the_room() {
    let (mesh, patches) = two_rooms(0.0);
    let (made, ..) = make(&mesh, &patches);
    for (p, n) in made.position.iter().zip(&made.normal) {
        let axis = (0..3).find(|&a| n[a].abs() > 0.999).expect("walls are along axes");
        let wall = |x: f32| x.abs().min((x - 2.0).abs()).min((x - 4.0).abs());
        assert!(wall(p[axis]) < 1e-6, "{p:?} facing {n:?} is off its wall");
        assert!((0..3).all(|a| a == axis || wall(p[a]) > 1e-3), "{p:?} facing {n:?} touches another wall");
    }
}
