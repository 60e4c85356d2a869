//! The last gather against closed forms.

mod common;

use std::f64::consts::PI;

use common::Maker;
use glam::Vec3;
use radfile::{Elements, Mesh, Patches, PointRows, Quiet, Rows, Side};
use scene::{NO_TRIANGLE, Rays, SurfacePoint};
use transfer::{GatherParams, Senders, gather_for_points, gather_memory_needed};

fn gather(mesh: &Mesh, patches: &Patches, points: &[SurfacePoint], rays: u32) -> (Rows, Vec<f32>) {
    let params = GatherParams { rays, ..GatherParams::default() };
    let senders = Senders { patches, elements: &Elements::whole(patches), rays: &Rays::new(mesh) };
    match gather_for_points(&senders, points, &params, &Quiet) {
        PointRows::Gathered { rows, sky } => (rows, sky),
        other => panic!("not gathered: {other:?}"),
    }
}

fn point(position: Vec3, normal: Vec3) -> SurfacePoint {
    SurfacePoint { position, normal, triangle: NO_TRIANGLE }
}

/// Form factor from a point to a rectangle a × b over it at distance 1, one corner on its normal
/// (Howell, configuration B-3).
fn corner_factor(a: f64, b: f64) -> f64 {
    let half = |a: f64, b: f64| a / (1.0 + a * a).sqrt() * (b / (1.0 + a * a).sqrt()).atan();
    (half(a, b) + half(b, a)) / (2.0 * PI)
}

#[test]
fn a_point_sees_of_a_square_what_the_closed_form_says_and_the_rest_is_sky() {
    let mut maker = Maker::new(0.5);
    maker.sheet(Vec3::new(-0.5, 1.0, -0.5), Vec3::X, Vec3::Z, [2, 2], &[Side::Front]);
    let (mesh, patches) = maker.finish();
    let (rows, sky) = gather(&mesh, &patches, &[point(Vec3::ZERO, Vec3::Y)], 1 << 14);
    assert_eq!(rows.row(0).count(), 4);
    for (patch, factor) in rows.row(0) {
        let expected = corner_factor(0.5, 0.5);
        assert!((f64::from(factor) - expected).abs() < 5e-4, "patch {patch}: {factor}, expected {expected}");
    }
    let sum: f64 = rows.row(0).map(|(_, f)| f64::from(f)).sum();
    assert!((sum + f64::from(sky[0]) - 1.0).abs() < 1e-6, "{sum} and the sky {}", sky[0]);
}

/// Rows of a closed room sum to 1; a room next door, behind a wall without thickness, is in none of them.
#[test]
fn a_point_in_a_room_sees_that_room_and_nothing_else() {
    let mut maker = Maker::new(0.5);
    maker.room(Vec3::ZERO, Vec3::ONE, [2; 3]);
    maker.room(Vec3::X, Vec3::ONE, [2; 3]);
    let (mesh, patches) = maker.finish();
    let points: Vec<SurfacePoint> = (0..50)
        .map(|i| point(Vec3::new(0.01 + 0.0199 * i as f32, 0.0, 0.5), Vec3::Y))
        .chain([point(Vec3::new(1.0, 0.5, 0.5), -Vec3::X)])
        .collect();
    let (rows, sky) = gather(&mesh, &patches, &points, 512);
    for (p, sky) in sky.iter().enumerate() {
        let sum: f64 = rows.row(p).map(|(_, f)| f64::from(f)).sum();
        assert!((sum - 1.0).abs() < 1e-6 && *sky == 0.0, "point {p}: {sum}");
        assert!(rows.row(p).all(|(patch, _)| patch < patches.len() / 2), "point {p} sees the other room");
    }
}

#[test]
fn rows_are_the_same_for_any_number_of_threads() {
    let mut maker = Maker::new(0.25);
    maker.room(Vec3::ZERO, Vec3::ONE, [4; 3]);
    let (mesh, patches) = maker.finish();
    let points: Vec<SurfacePoint> =
        (0..64).map(|i| point(Vec3::new(0.1, 0.0, 0.015 * i as f32 + 0.01), Vec3::Y)).collect();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| gather(&mesh, &patches, &points, 256))
    };
    let (one, four) = (with(1), with(4));
    assert_eq!(one, four);
    let entry = size_of::<u32>() + size_of::<f32>();
    let params = GatherParams { rays: 256, ..GatherParams::default() };
    assert!((one.0.sender.len() * entry) as u64 <= gather_memory_needed(points.len(), 2 * patches.len(), &params));
}

/// A box of outer walls that are seen from without and from within.
fn block(maker: &mut Maker, low: Vec3, size: Vec3) {
    let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
    for (u, v, w) in [(x, y, z), (y, z, x), (z, x, y)] {
        maker.sheet(low + w, u, v, [1, 1], &[Side::Front, Side::Back]);
        maker.sheet(low, v, u, [1, 1], &[Side::Front, Side::Back]);
    }
}

/// The inside of a solid has patches, and a floor runs on below it. Of a room that is wound the wrong way, which looks like
/// a solid from inside, no place is buried.
#[test]
fn a_floor_is_buried_where_a_solid_stands_on_it_and_not_for_being_in_a_room_of_backs() {
    let buried = |build: fn(&mut Maker)| {
        let mut maker = Maker::new(0.5);
        build(&mut maker);
        block(&mut maker, Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.8, 0.5, 0.6));
        let (mesh, patches) = maker.finish();
        let floor = [[1.02, 1.3], [1.4, 1.02], [1.79, 1.59], [0.98, 1.3], [1.4, 0.98], [1.81, 1.61], [0.2, 2.8]];
        let points = floor.map(|[x, z]| point(Vec3::new(x, 0.0, z), Vec3::Y));
        let (elements, rays) = (Elements::whole(&patches), Rays::new(&mesh));
        let senders = Senders { patches: &patches, elements: &elements, rays: &rays };
        let params = GatherParams { rays: 1024, ..GatherParams::default() };
        transfer::pack(&senders, &points, &params, 0.01, &Quiet).expect("sound").1.buried
    };
    assert_eq!(buried(|maker| maker.room(Vec3::ZERO, Vec3::splat(3.0), [1; 3])), [0, 1, 2]);
    assert_eq!(buried(|maker| block(maker, Vec3::ZERO, Vec3::splat(3.0))), [0u32; 0]);
}
