//! What packing does to light, on a room with coloured walls.

#[path = "../../dxt-pack/tests/common/mod.rs"]
mod common;

use common::{Room, room};
use hmatrix::{HMatrix, Params, Report, compress};
use radfile::{Operator, Patches, Quiet};

fn packed(room: &Room, error: f64) -> (HMatrix, Report) {
    compress(&room.operator, &room.patches, &Params::error(error), &Quiet).expect("a room")
}

/// Lights that did not steer agree with those that did: nothing was fitted to the lights.
#[test]
fn held_out_lights_have_the_error_that_was_asked_for_and_smaller_errors_cost_more() {
    let room = room(10, 3);
    let mut bytes = Vec::new();
    for error in [0.03, 0.01, 0.003] {
        let (matrix, report) = packed(&room, error);
        assert!(report.l2_mean <= 1.2 * error && report.l2_mean > 0.5 * error, "{report:?}");
        assert!(report.error_steered <= error && report.l2_max < 2.5 * error, "{report:?}");
        assert!(report.energy_bias.abs() < 0.1 * error, "{report:?}");
        assert_eq!((report.bytes, report.probes), (matrix.to_bytes().len(), 20));
        let sizes = &report.sizes;
        assert!(sizes.structure + sizes.low_rank + sizes.tiles + sizes.mean_or_split < report.bytes + 64);
        bytes.push(report.bytes);
    }
    assert!(bytes.is_sorted() && bytes[2] > 2 * bytes[0], "{bytes:?}");
    // 1 % of the bytes of three dense f32 channels would be 43 kB.
    assert!(bytes[1] < 60_000, "{bytes:?}");
}

/// Identity 2 of docs/design.md §2: Σ_j X_ij (1 − ρ_j) = A_i, row by row.
#[test]
fn the_furnace_keeps_its_temperature() {
    let room = room(10, 3);
    let (matrix, _) = packed(&room, 0.01);
    let n = room.patches.len();
    let root: Vec<f32> = room.patches.area.iter().map(|a| a.sqrt()).collect();
    let x: Vec<[f32; 3]> =
        (0..n).map(|i| std::array::from_fn(|c| root[i] * (1.0 - room.patches.reflectance[i][c]))).collect();
    let mut y = vec![[0.0; 3]; n];
    matrix.multiply(&x, &mut y, &mut matrix.workspace());
    let deviation = |i: usize| y[i].iter().map(|y| f64::from(y / root[i] - 1.0)).sum::<f64>() / 3.0;
    let mean = (0..n).map(deviation).sum::<f64>() / n as f64;
    let spread = (0..n).map(|i| deviation(i).abs()).sum::<f64>() / n as f64;
    assert!(mean.abs() < 5e-4, "light that is gained or lost: {mean}");
    assert!(spread < 5e-3, "mean deviation of a row: {spread}");
}

/// The first `count` patches again, moved along x.
fn append_copy(p: &mut Patches, count: usize, distance: f32) {
    for i in 0..count {
        p.position.push([p.position[i][0] + distance, p.position[i][1], p.position[i][2]]);
        p.normal.push(p.normal[i]);
        p.area.push(p.area[i]);
        p.reflectance.push(p.reflectance[i]);
        p.emission.push(p.emission[i]);
        p.pieces.push(p.pieces[i]);
        p.piece_start.push(p.pieces.len() as u32);
    }
}

/// Two rooms that share no light, wall to wall, and a patch that sees nothing: so clusters hold patches of several.
fn two_rooms(cells: usize, distance: f32, leak: f32) -> Room {
    let (mut both, n) = (room(cells, 3), 6 * cells * cells);
    let single = both.operator.clone();
    append_copy(&mut both.patches, n, distance);
    append_copy(&mut both.patches, 1, 9.0);
    let size = 2 * n + 1;
    let mut values = vec![0.0; 3 * size * size];
    for c in 0..3 {
        for (at, value) in single.channel(c).iter().enumerate() {
            let (i, j) = (at / n, at % n);
            for (half, brightness) in [(0, 1.0), (n, 0.25)] {
                values[(c * size + half + i) * size + half + j] = brightness * value;
            }
        }
    }
    for c in 0..3 {
        for (i, j) in (0..n).flat_map(|i| (n..2 * n).map(move |j| (i, j))) {
            values[(c * size + i) * size + j] = leak;
            values[(c * size + j) * size + i] = leak;
        }
    }
    both.operator = Operator { n: size, channels: 3, bounces: None, values: values.into() };
    both
}

#[test]
fn no_light_gets_from_a_sealed_room_to_another() {
    let rooms = two_rooms(7, 4.01, 0.0);
    let n = rooms.patches.len();
    let (matrix, report) = packed(&rooms, 0.01);
    assert!(report.l2_mean < 0.013, "{report:?}");
    for lit in [0..n / 2, n / 2..n - 1] {
        let x: Vec<[f32; 3]> = (0..n).map(|i| if lit.contains(&i) { [3.0, 1.0, 0.1] } else { [0.0; 3] }).collect();
        let mut y = vec![[0.0; 3]; n];
        matrix.multiply(&x, &mut y, &mut matrix.workspace());
        for (i, y) in y.iter().enumerate() {
            assert!(lit.contains(&i) || *y == [0.0; 3], "patch {i} of the dark room has {y:?}");
            assert!(!lit.contains(&i) || y[0] > 0.0, "patch {i} of the lit room has {y:?}");
        }
    }
}

/// Rooms in the same place, as the inside of a solid and what is around it, with a gap between them or without.
#[test]
fn a_gap_between_rooms_costs_next_to_nothing() {
    let bytes = |leak: f32| packed(&two_rooms(8, 0.01, leak), 0.01).1.bytes as f64;
    let (sealed, leaking) = (bytes(0.0), bytes(1e-7));
    assert!(leaking < 1.15 * sealed, "{leaking} bytes instead of {sealed}");
}

#[test]
fn a_grey_room_has_no_colour() {
    let (grey, report) = packed(&room(8, 1), 0.01);
    assert_eq!((grey.channels(), report.sizes.colour), (1, 0));
    let mut room = room(8, 3);
    let red = room.operator.channel(0).to_vec();
    room.operator.values = [&red[..], &red[..], &red[..]].concat().into();
    let (_, report) = packed(&room, 0.01);
    assert_eq!((report.channels, report.sizes.colour), (3, 0), "equal channels");
}

#[test]
fn the_same_input_gives_the_same_bytes_on_any_number_of_threads() {
    let room = room(8, 3);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let x: Vec<[f32; 3]> = (0..room.patches.len()).map(|i| [i as f32, 1.0, 1.0 / (i + 1) as f32]).collect();
        let mut y = vec![[0.0; 3]; x.len()];
        pool.install(|| {
            let (matrix, report) = packed(&room, 0.01);
            matrix.multiply(&x, &mut y, &mut matrix.workspace());
            (matrix.to_bytes().to_vec(), report, y)
        })
    };
    assert!(with(1) == with(4));
}
