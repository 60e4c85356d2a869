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
