//! Ray queries: sides, distances, and that no light slips between triangles.

mod rooms;

use glam::Vec3;
use radfile::Side;
use rayon::prelude::*;
use rooms::{ClosedRoom, unit};
use scene::{NO_TRIANGLE, Rays, hash};

/// Right-angled triangle in the plane z = 0 whose front looks along +z.
const FLOOR: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn rays(triangles: &[[[f32; 3]; 3]]) -> Rays {
    Rays::from_triangles(triangles.len(), |t| triangles[t])
}

fn raised(triangle: [[f32; 3]; 3], z: f32) -> [[f32; 3]; 3] {
    triangle.map(|[x, y, _]| [x, y, z])
}

#[test]
fn corners_turn_counter_clockwise_on_the_front_whatever_the_axis() {
    for axis in 0..3 {
        let turn = |p: [f32; 3]| -> [f32; 3] { std::array::from_fn(|i| p[(i + axis) % 3]) };
        let rays = rays(&[FLOOR.map(turn)]);
        let (above, below) = (Vec3::from(turn([0.2, 0.3, 2.0])), Vec3::from(turn([0.2, 0.3, -2.0])));
        let down = Vec3::from(turn([0.0, 0.0, -1.0]));
        let front = rays.closest(above, down, f32::INFINITY, NO_TRIANGLE).expect("seen from above");
        let back = rays.closest(below, -down, f32::INFINITY, NO_TRIANGLE).expect("seen from below");
        assert_eq!((front.side, back.side), (Side::Front, Side::Back), "axis {axis}");
    }
}

#[test]
fn a_hit_tells_where_it_is_in_lengths_of_the_direction() {
    let rays = rays(&[FLOOR]);
    for length in [1e-6f32, 0.3, 1.0, 7.0, 1e6] {
        let direction = length * Vec3::new(0.1, 0.2, -1.0);
        let hit = rays.closest(Vec3::new(0.1, 0.1, 1.0), direction, f32::INFINITY, NO_TRIANGLE).expect("aimed at it");
        assert!((hit.t * length - 1.0).abs() < 1e-6, "distance {} of length {length}", hit.t);
        assert!((hit.u - 0.2).abs() < 1e-6 && (hit.v - 0.3).abs() < 1e-6, "weights {} {}", hit.u, hit.v);
    }
}

#[test]
fn the_nearest_triangle_answers_unless_it_is_ignored_or_beyond_the_limit() {
    let rays = rays(&[FLOOR, raised(FLOOR, 0.5), raised(FLOOR, 0.25)]);
    let closest = |limit, ignore| rays.closest(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z, limit, ignore);
    assert_eq!(closest(f32::INFINITY, NO_TRIANGLE).map(|h| h.triangle), Some(1));
    assert_eq!(closest(f32::INFINITY, 1).map(|h| h.triangle), Some(2));
    assert_eq!(closest(0.6, 1), None);
    let t = closest(f32::INFINITY, NO_TRIANGLE).expect("the nearest").t;
    assert!((t - 0.5).abs() < 1e-6);
    assert_eq!(closest(t, NO_TRIANGLE), None, "the limit itself is out of reach");
    assert_eq!(closest(t.next_up(), NO_TRIANGLE).map(|h| h.triangle), Some(1));
}

#[test]
fn a_wall_is_found_however_near_it_is() {
    for scale in [1e-3f32, 1.0, 1e3] {
        let rays = rays(&[FLOOR.map(|p| p.map(|x| x * scale))]);
        for distance in [1e-2f32, 1e-4, 1e-5, 1e-6, 2e-7] {
            let origin = scale * Vec3::new(0.2, 0.2, distance);
            for length in [1.0f32, 1e-3, 1e3, 2.0 * scale * distance] {
                let hit = rays.closest(origin, Vec3::new(0.0, 0.0, -length), f32::INFINITY, NO_TRIANGLE);
                let t = hit.expect("in front of the wall").t * length;
                assert!((t / (scale * distance) - 1.0).abs() < 1e-5, "{t} at scale {scale}, length {length}");
                let behind = origin - Vec3::new(0.0, 0.0, 2.0 * scale * distance);
                assert!(!rays.visible(origin, behind, NO_TRIANGLE), "seen through at {distance}, scale {scale}");
            }
        }
    }
}

/// Rays along the axes have components of +0 and -0, whose inverses are infinite.
#[test]
fn rays_along_the_axes_hit_the_walls_of_a_box() {
    let room = ClosedRoom::regular(8);
    let rays = room.rays();
    for k in 0..3 {
        for sign in [-1.0f32, 1.0] {
            for zero in [0.0f32, -0.0] {
                let mut direction = [zero; 3];
                direction[k] = sign;
                for i in 0..64 {
                    // On the planes of the grid and between them.
                    let a = i as f32 / 64.0 - 0.5;
                    let mut origin = [a, 0.25 - a * 0.5, a * 0.5];
                    origin[k] = 0.0;
                    let hit = rays.closest(origin.into(), direction.into(), f32::INFINITY, NO_TRIANGLE);
                    let t = hit.expect("a closed box").t;
                    assert!((t - 1.0).abs() < 1e-6, "{t} from {origin:?} along {direction:?}");
                }
            }
        }
    }
}

/// What happened to rays from inside a closed room.
#[derive(Debug, Default, PartialEq)]
struct Fate {
    /// Met nothing.
    leaked: u32,
    /// Met the outside of a wall first.
    outside: u32,
    /// `closest` and `escapes` said different things.
    torn: u32,
}

/// Aims `count` rays from inside at corners, edges and insides of triangles.
fn fate(room: &ClosedRoom, count: u32, seed: u32) -> Fate {
    let rays = room.rays();
    let one = |i: u32| {
        let random = |k: u32| unit(hash(hash(seed, i), k));
        let origin = room.place(std::array::from_fn(|a| 0.8 * random(a as u32) - 0.4));
        let [a, b, c] = room.corners((random(3) * room.triangles.len() as f32) as usize).map(Vec3::from);
        let target = match i % 4 {
            0 => a,
            1 => a + random(4) * (b - a),
            2 => b.midpoint(c),
            _ => a + random(4) * 0.5 * (b - a) + random(5) * 0.5 * (c - a),
        };
        let direction = if i % 8 < 4 { target - origin } else { (target - origin).normalize() };
        let hit = rays.closest(origin, direction, f32::INFINITY, NO_TRIANGLE);
        Fate {
            leaked: u32::from(hit.is_none()),
            outside: u32::from(hit.is_some_and(|h| h.side == Side::Back)),
            torn: u32::from(rays.escapes(origin, direction, NO_TRIANGLE) != hit.is_none()),
        }
    };
    let add =
        |a: Fate, b: Fate| Fate { leaked: a.leaked + b.leaked, outside: a.outside + b.outside, torn: a.torn + b.torn };
    (0..count).into_par_iter().map(one).reduce(Fate::default, add)
}

#[test]
fn no_ray_aimed_at_corners_and_edges_leaves_a_closed_room() {
    assert_eq!(fate(&ClosedRoom::irregular(24, 1.0, Vec3::ZERO), 1_600_000, 1), Fate::default());
    assert_eq!(fate(&ClosedRoom::regular(16), 400_000, 2), Fate::default());
}

#[test]
fn closed_rooms_of_any_size_and_place_are_closed() {
    for (scale, offset) in [(1e-3, Vec3::ZERO), (1e3, Vec3::ZERO), (1.0, Vec3::new(900.0, -350.0, 120.0))] {
        let room = ClosedRoom::irregular(20, scale, scale * offset);
        assert_eq!(fate(&room, 400_000, 3), Fate::default(), "scale {scale}, offset {offset}");
    }
}

#[test]
fn what_is_visible_is_what_the_closest_hit_lets_through() {
    let room = ClosedRoom::irregular(12, 1.0, Vec3::ZERO);
    let panels: Vec<_> = (0..room.triangles.len()).map(|t| room.corners(t).map(|p| p.map(|x| 0.3 * x))).collect();
    let rays = rays(&panels);
    let mut blocked = 0;
    for i in 0..100_000 {
        let point = |k: u32| Vec3::from_array(std::array::from_fn(|a| unit(hash(i, k + a as u32)) - 0.5));
        let (from, to) = (point(0), point(3));
        let hit = rays.closest(from, to - from, 1.0, NO_TRIANGLE);
        assert_eq!(rays.visible(from, to, NO_TRIANGLE), hit.is_none(), "from {from} to {to}");
        blocked += u32::from(hit.is_some());
    }
    assert!((30_000..90_000).contains(&blocked), "{blocked} of 100000 blocked: not a test");
}

/// A chain of triangles, each twice as large as the one before, makes a search tree as deep as it can be.
#[test]
fn nested_triangles_of_all_sizes_are_all_found() {
    let nested: Vec<_> =
        (0..120).map(|k| raised(FLOOR, 1.0).map(|p| p.map(|x| x * (k as f32 - 60.0).exp2()))).collect();
    let rays = rays(&nested);
    for k in 0..120 {
        let z = (k as f32 - 60.0).exp2();
        let origin = z * Vec3::new(0.1, 0.1, 1.2);
        let hit = rays.closest(origin, Vec3::NEG_Z, f32::INFINITY, NO_TRIANGLE).expect("triangles below");
        assert_eq!(hit.triangle, k);
        let other_side = origin - 0.3 * z * Vec3::Z;
        assert!(!rays.visible(origin, other_side, NO_TRIANGLE), "seen through triangle {k}");
        assert!(rays.visible(origin, other_side, k), "only triangle {k} stands between");
    }
}

#[test]
fn coincident_and_degenerate_triangles_do_no_harm() {
    let mut triangles = vec![FLOOR; 5000];
    triangles.extend([[[0.1; 3]; 3], [[0.0; 3], [1.0; 3], [2.0; 3]]]);
    let rays = rays(&triangles);
    let hit = rays.closest(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z, f32::INFINITY, NO_TRIANGLE).expect("the floor");
    assert!((hit.t - 1.0).abs() < 1e-6 && hit.triangle == 0, "{hit:?}");
    assert!(rays.escapes(Vec3::new(0.2, 0.2, 1.0), Vec3::Z, NO_TRIANGLE));
}

#[test]
fn without_triangles_everything_is_sky() {
    let rays = rays(&[]);
    assert!(rays.escapes(Vec3::ZERO, Vec3::X, NO_TRIANGLE));
    assert_eq!(rays.closest(Vec3::ZERO, Vec3::X, f32::INFINITY, NO_TRIANGLE), None);
}

/// Two rooms on one floor, parted by a sheet without thickness that stands on the edge between their floors and
/// ends at an edge of their ceilings. Rays aimed at those edges meet three triangles at one place; none may
/// end in the other room.
#[test]
fn a_ray_to_the_foot_of_a_thin_wall_stays_in_its_room() {
    for trial in 0..200 {
        let vector = |k: u32| Vec3::from([0, 1, 2].map(|d| 2.0 * unit(hash(hash(trial, k), d)) - 1.0));
        let turn = glam::Quat::from_axis_angle(vector(7).normalize(), trial as f32);
        let shift = 3.0 * vector(8);
        let place = |x: f32, y: f32, z: f32| (turn * Vec3::new(x, y, z) + shift).to_array();
        let mut triangles = Vec::new();
        let mut quad = |p: [[f32; 3]; 4]| triangles.extend([[p[0], p[1], p[2]], [p[0], p[2], p[3]]]);
        for y in [0.0, 1.0] {
            for x in [-1.0, 0.0] {
                quad([place(x, y, 0.0), place(x, y, 1.0), place(x + 1.0, y, 1.0), place(x + 1.0, y, 0.0)]);
            }
        }
        quad([place(0.0, 0.0, 0.0), place(0.0, 0.0, 1.0), place(0.0, 1.0, 1.0), place(0.0, 1.0, 0.0)]);
        let rays = rays(&triangles);
        // Quads 0 and 2 are floor and ceiling of the room at x < 0; 1 and 3 those of the other.
        let across = |triangle: u32, x: f32| matches!((triangle / 2, x < 0.0), (1 | 3, true) | (0 | 2, false));
        for k in 0..500u32 {
            let number = |d: u32| unit(hash(hash(trial, d), k));
            let x = (0.05 + 0.9 * number(0)) * if k % 2 == 0 { -1.0 } else { 1.0 };
            let origin = Vec3::from(place(x, 0.05 + 0.9 * number(1), 0.1 + 0.8 * number(2)));
            let edge = Vec3::from(place(0.0, (k / 2 % 2) as f32, 0.1 + 0.8 * number(3)));
            let hit = rays.closest(origin, edge - origin, f32::INFINITY, NO_TRIANGLE);
            if let Some(hit) = hit.filter(|h| (h.t - 1.0).abs() < 1e-4) {
                assert!(
                    !across(hit.triangle, x),
                    "trial {trial}, ray {k} from x = {x} ends on triangle {}",
                    hit.triangle
                );
            }
        }
    }
}
