//! Rows of receivers that are no patches, in a closed room.

#[path = "../../dxt-pack/tests/common/mod.rs"]
mod common;

use common::some_patches;
use hmatrix::{
    Error, Params, Receivers, Rectangle, Row, RowsReport, Senders, compress_rows, rows_memory_needed, sparse,
};
use radfile::{Patches, Quiet, Rows};

/// Receivers on the walls of a room, and what they see of its patches.
struct Room {
    patches: Patches,
    position: Vec<[f32; 3]>,
    normal: Vec<[f32; 3]>,
    rows: Rows,
}

/// A room with `cells` × `cells` patches a wall and `fine` × `fine` receivers. Rows are differential form factors, made to
/// sum to 1.
fn room(cells: usize, fine: usize) -> Room {
    let (mut patches, receivers) = (some_patches(6 * cells * cells), some_patches(6 * fine * fine));
    for (i, rho) in patches.reflectance.iter_mut().enumerate() {
        *rho = [0.2 + 0.6 * ((i * 7) % 11) as f32 / 11.0; 3];
    }
    let (position, normal) = (receivers.position, receivers.normal);
    let mut rows = Rows { row_start: vec![0], ..Rows::default() };
    for (p, m) in position.iter().zip(&normal) {
        let weight = |j: usize| {
            let d: [f32; 3] = std::array::from_fn(|a| patches.position[j][a] - p[a]);
            let dot = |m: [f32; 3]| (0..3).map(|a| d[a] * m[a]).sum::<f32>();
            let cosines = dot(*m).max(0.0) * (-dot(patches.normal[j])).max(0.0);
            patches.area[j] * cosines / (dot(d) + 0.3 * patches.area[j]).powi(2)
        };
        let weights: Vec<(u32, f32)> =
            (0..patches.len()).map(|j| (j as u32, weight(j))).filter(|w| w.1 > 0.0).collect();
        let sum: f32 = weights.iter().map(|w| w.1).sum();
        rows.sender.extend(weights.iter().map(|w| w.0));
        rows.weight.extend(weights.iter().map(|w| w.1 / sum));
        rows.row_start.push(rows.sender.len() as u32);
    }
    Room { patches, position, normal, rows }
}

impl Room {
    fn receivers(&self) -> Receivers<'_> {
        Receivers { position: &self.position, normal: &self.normal }
    }

    fn pack(&self, params: &Params) -> hmatrix::Result<(Rectangle, RowsReport)> {
        let row = sparse(&self.rows, &self.receivers())?;
        compress_rows(&self.receivers(), &(&self.patches).into(), &row, params, &Quiet)
    }

    /// Its first receivers and patches; weights of other patches are lost.
    fn first(mut self, receivers: usize, patches: usize) -> Room {
        self.position.truncate(receivers);
        self.normal.truncate(receivers);
        let mut rows = Rows { row_start: vec![0], ..Rows::default() };
        for receiver in 0..receivers {
            for (patch, weight) in self.rows.row(receiver).filter(|(patch, _)| *patch < patches) {
                rows.sender.push(patch as u32);
                rows.weight.push(weight);
            }
            rows.row_start.push(rows.sender.len() as u32);
        }
        Room { rows, patches: some_patches(patches), ..self }
    }
}

fn light(n: usize) -> Vec<[f32; 3]> {
    let noise = |i: usize| ((i as u32).wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32;
    (0..n).map(|i| [noise(3 * i), noise(3 * i + 1).powi(8), noise(3 * i + 2) - 0.5]).collect()
}

fn received(packed: &Rectangle, x: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut y = vec![[f32::NAN; 3]; packed.receivers()];
    packed.multiply(x, &mut y, &mut packed.workspace());
    y
}

/// The product and what is read again, against the definition in f64.
fn assert_product(packed: &Rectangle) {
    let (m, n) = (packed.receivers(), packed.senders());
    let x = light(n);
    let y = received(packed, &x);
    let dense = packed.decode().expect("own bytes");
    for c in 0..3 {
        let dot = |i: usize| (0..n).map(|j| dense[i * n + j] * f64::from(x[j][c])).sum::<f64>();
        let size = |i: usize| (0..n).map(|j| (dense[i * n + j] * f64::from(x[j][c])).abs()).sum::<f64>();
        let mean = (0..m).map(size).sum::<f64>() / m as f64;
        for (i, y) in y.iter().enumerate() {
            assert!((f64::from(y[c]) - dot(i)).abs() <= 1e-5 * mean, "{i} {c}: {} and {}", y[c], dot(i));
        }
    }
    assert_eq!(received(&Rectangle::from_bytes(packed.to_bytes()).expect("own bytes"), &x), y);
}

#[test]
fn held_out_lights_have_the_error_that_was_asked_for_and_smaller_errors_cost_more() {
    // As many receivers as senders, many more, and many fewer.
    for (room, chunks) in [(room(10, 10), 1), (room(6, 18), 9), (room(14, 5), 1)] {
        let mut bytes = Vec::new();
        for error in [0.03, 0.01, 0.003] {
            let (packed, report) = room.pack(&Params::error(error)).expect("a room");
            assert_eq!(report.chunks, chunks);
            assert!(report.l2_mean <= 1.3 * error && report.l2_mean > 0.5 * error, "{report:?}");
            assert!(report.error_steered <= 1.001 * error && report.energy_bias.abs() < 0.1 * error, "{report:?}");
            assert_eq!(report.bytes, packed.to_bytes().len());
            assert_product(&packed);
            bytes.push(report.bytes);
        }
        assert!(bytes.is_sorted() && bytes[2] > 2 * bytes[0], "{bytes:?}");
        let entries = room.rows.sender.len();
        assert!(bytes[1] < entries / 2, "{bytes:?} of {entries} entries");
    }
}

/// Under even light every receiver of a closed room gets just that.
#[test]
fn rows_that_sum_to_one_still_do() {
    let room = room(8, 16);
    let (packed, report) = room.pack(&Params::error(0.01)).expect("a room");
    let y = received(&packed, &vec![[1.0, 2.0, 0.5]; room.patches.len()]);
    let deviation =
        |y: &[f32; 3]| f64::from((y[0] - 1.0).abs() + (y[1] / 2.0 - 1.0).abs() + (2.0 * y[2] - 1.0).abs()) / 3.0;
    let mean = y.iter().map(deviation).sum::<f64>() / y.len() as f64;
    assert!(mean < 5e-3, "mean deviation of a row: {mean}");
    assert!((mean - report.furnace).abs() < 1e-6, "{mean} and {}", report.furnace);
}

#[test]
fn receivers_without_a_row_and_sealed_rooms_stay_dark() {
    let one = room(6, 8);
    let (m, n) = (one.position.len(), one.patches.len());
    // The same room again behind its wall; in both every fifth receiver is blind.
    let mut both = room(6, 8);
    for i in 0..n {
        let p = one.patches.position[i];
        both.patches.position.push([p[0] + 4.01, p[1], p[2]]);
        both.patches.normal.push(one.patches.normal[i]);
        both.patches.area.push(one.patches.area[i]);
        both.patches.reflectance.push(one.patches.reflectance[i]);
    }
    both.rows = Rows { row_start: vec![0], ..Rows::default() };
    for receiver in 0..2 * m {
        let (own, offset) = (receiver % m, receiver / m * n);
        if receiver >= m {
            let p = one.position[own];
            both.position.push([p[0] + 4.01, p[1], p[2]]);
            both.normal.push(one.normal[own]);
        }
        for (patch, weight) in one.rows.row(own).filter(|_| receiver % 5 != 0) {
            both.rows.sender.push((patch + offset) as u32);
            both.rows.weight.push(weight);
        }
        both.rows.row_start.push(both.rows.sender.len() as u32);
    }
    let (packed, report) = both.pack(&Params::error(0.03)).expect("two rooms");
    assert_eq!(report.dark, (2 * m).div_ceil(5));
    assert!(report.l2_mean < 0.04, "{report:?}");
    assert_product(&packed);
    for lit in [0, 1] {
        let x: Vec<[f32; 3]> = (0..2 * n).map(|i| if i / n == lit { [3.0, 1.0, 0.1] } else { [0.0; 3] }).collect();
        for (receiver, y) in received(&packed, &x).iter().enumerate() {
            let expected = receiver / m == lit && receiver % 5 != 0;
            assert_eq!(*y != [0.0; 3], expected, "receiver {receiver} has {y:?}");
        }
    }
}

#[test]
fn the_same_input_gives_the_same_bytes_on_any_number_of_threads() {
    let room = room(6, 14);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let (packed, report) = room.pack(&Params::error(0.01)).expect("a room");
            (packed.to_bytes().to_vec(), report, received(&packed, &light(room.patches.len())))
        })
    };
    let one = with(1);
    assert!([2, 4].into_iter().all(|threads| with(threads) == one));
}

#[test]
fn few_receivers_and_few_patches_are_packed_as_well() {
    for (receivers, patches) in [(1, 216), (2, 216), (5, 216), (60, 216), (384, 1), (384, 2), (384, 23), (1, 1), (3, 2)]
    {
        let small = room(6, 8).first(receivers, patches);
        for leaf in [4, 24, 64] {
            let (packed, report) = small.pack(&Params { leaf, ..Params::error(0.01) }).expect("few");
            assert!(report.l2_mean <= 0.02, "{receivers} receivers, {patches} patches: {report:?}");
            assert_product(&packed);
        }
    }
}

/// Half of every weight twice, the last sender first: the same bytes.
#[test]
fn a_row_may_name_its_senders_in_any_order_and_again() {
    let room = room(5, 9);
    let (packed, report) = room.pack(&Params::error(0.01)).expect("a room");
    let twice = |receiver: usize, out: &mut Row| {
        out.extend(room.rows.row(receiver).map(|(sender, weight)| (sender as u32, weight / 2.0)));
        out.extend_from_within(..);
        out.reverse();
    };
    let again = compress_rows(&room.receivers(), &(&room.patches).into(), &twice, &Params::error(0.01), &Quiet)
        .expect("a room");
    assert!(again.0.to_bytes() == packed.to_bytes() && again.1 == report);
}

#[test]
fn nothing_stays_nothing() {
    let mut dark = room(4, 5);
    dark.rows.weight.fill(0.0);
    let (packed, report) = dark.pack(&Params::default()).expect("zeros");
    assert_eq!((report.dark, report.l2_max, report.furnace), (150, 0.0, 0.0));
    assert_eq!(received(&packed, &light(96)), vec![[0.0; 3]; 150]);
    assert_eq!(
        received(&Rectangle::from_bytes(packed.to_bytes()).expect("own bytes"), &light(96)),
        vec![[0.0; 3]; 150]
    );
}

#[test]
fn what_is_no_row_is_refused() {
    let refused = |change: &dyn Fn(&mut Room)| {
        let mut changed = room(3, 4);
        change(&mut changed);
        changed.pack(&Params::default()).map(|_| ()).expect_err("refused")
    };
    for bad in [f32::NAN, -0.1, f32::INFINITY] {
        let error = refused(&|room| room.rows.weight[room.rows.row_start[7] as usize] = bad);
        assert!(matches!(error, Error::Weight { receiver: 7, .. }), "{error}");
    }
    let error = refused(&|room| room.rows.weight[room.rows.row_start[9] as usize] += 0.1);
    assert!(matches!(error, Error::RowSum { receiver: 9, .. }), "{error}");
    let error = refused(&|room| room.rows.sender[5] = 54);
    assert!(matches!(error, Error::Sender { receiver: 0, sender: 54, senders: 54 }), "{error}");
    assert!(matches!(refused(&|room| room.rows.row_start[1] = u32::MAX), Error::ReceiverCount { .. }));
    assert!(matches!(refused(&|room| room.rows.row_start.truncate(5)), Error::ReceiverCount { rows: 4, .. }));
    assert!(matches!(refused(&|room| room.normal.truncate(5)), Error::ReceiverCount { normals: 5, .. }));
    let none = refused(&|room| {
        (room.position, room.normal, room.rows) =
            (Vec::new(), Vec::new(), Rows { row_start: vec![0], ..Rows::default() });
    });
    assert!(matches!(none, Error::NoReceivers), "{none}");
    let of =
        |senders: &Senders| compress_rows(&room(2, 2).receivers(), senders, &|_, _| (), &Params::default(), &Quiet);
    let none = Patches::default();
    assert!(matches!(of(&(&none).into()).map(|_| ()), Err(Error::NoSenders)));
    let patches = some_patches(24);
    let uneven = Senders { area: &patches.area[..5], ..(&patches).into() };
    assert!(matches!(of(&uneven).map(|_| ()), Err(Error::SenderCount { counts: [24, 24, 5, 24] })));
    let error = room(2, 2).pack(&Params::error(f64::NAN)).map(|_| ()).expect_err("no error");
    assert!(matches!(error, Error::Option { option: "error", .. }), "{error}");
}

/// Rows are never dense all at once.
#[test]
fn memory_is_far_below_that_of_dense_rows() {
    let need = |receivers: usize, senders: usize| rows_memory_needed(receivers, senders, &Params::default());
    assert!(need(65_536, 12_000) < 3 << 29, "{}", need(65_536, 12_000));
    // The packed rows and the light of probes at least.
    assert!(need(50_000, 2_600) > 50_000 * (100 + 40 * 8));
    assert!(need(1, 1) < 2 << 20 && need(100, 40_000) < 1 << 28);
}
