//! Bytes that are no operator, symmetric or not, give an error or a finite operator, never a panic.

#[path = "../../dxt-pack/tests/common/mod.rs"]
mod common;

use common::room;
use hmatrix::{Error, HMatrix, Params, Receivers, Rectangle, Row, compress, compress_rows};
use radfile::Quiet;

/// A symmetric operator and the rectangle of its rows, of which the last receivers get nothing.
fn streams() -> [Vec<u8>; 2] {
    let room = room(7, 3);
    let params = Params { leaf: 8, ..Params::error(0.02) };
    let symmetric = compress(&room.operator, &room.patches, &params, &Quiet).expect("a room").0;
    let n = room.patches.len();
    let receivers = Receivers { position: &room.patches.position, normal: &room.patches.normal };
    let row = |i: usize, out: &mut Row| {
        let row = room.operator.channel(0)[i * n..][..n].iter().map(|k| k / 30.0);
        out.extend((0..).zip(row).filter(|_| i < n - 9));
    };
    let rectangle =
        compress_rows(&receivers, &(&room.patches).into(), &row, &params, &Quiet).expect("rows of a room").0;
    [symmetric.to_bytes().to_vec(), rectangle.to_bytes().to_vec()]
}

/// Whether they are read; what is read has to work.
fn is_read(bytes: &[u8]) -> bool {
    let light = |n: usize| vec![[1.0, 0.5, 0.25]; n];
    let y = if let Ok(matrix) = HMatrix::from_bytes(bytes) {
        let mut y = light(matrix.patches());
        matrix.multiply(&light(matrix.patches()), &mut y, &mut matrix.workspace());
        y
    } else if let Ok(rectangle) = Rectangle::from_bytes(bytes) {
        let mut y = light(rectangle.receivers());
        rectangle.multiply(&light(rectangle.senders()), &mut y, &mut rectangle.workspace());
        y
    } else {
        return false;
    };
    assert!(y.as_flattened().iter().all(|y| y.is_finite()), "an operator that is not finite");
    true
}

#[test]
fn every_truncation_is_refused() {
    for bytes in streams() {
        assert!(is_read(&bytes));
        for end in (0..200).chain((200..bytes.len()).step_by(97)).chain(bytes.len() - 20..bytes.len()) {
            assert!(!is_read(&bytes[..end]), "the first {end} bytes");
        }
    }
    let [symmetric, rectangle] = streams();
    let cut = |bytes: &[u8]| bytes[..bytes.len() - 1].to_vec();
    let error = HMatrix::from_bytes(&cut(&symmetric)).map(|_| ()).expect_err("cut off");
    assert!(matches!(error, Error::Short { .. }), "{error}");
    let error = Rectangle::from_bytes(&cut(&rectangle)).map(|_| ()).expect_err("cut off");
    assert!(matches!(error, Error::Short { .. }), "{error}");
    let error = HMatrix::from_bytes(&[&symmetric[..], &[0]].concat()).map(|_| ()).expect_err("too long");
    assert!(matches!(error, Error::Damaged { what: "the end", .. }), "{error}");
    let error = Rectangle::from_bytes(&[&rectangle[..], &[0]].concat()).map(|_| ()).expect_err("too long");
    assert!(matches!(error, Error::Damaged { what: "the end", .. }), "{error}");
    assert!(HMatrix::from_bytes(&rectangle).is_err() && Rectangle::from_bytes(&symmetric).is_err());
}

#[test]
fn flipped_bits_are_refused_or_finite() {
    let mut state = 1u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for whole in streams() {
        let mut read = [0; 2];
        for trial in 0..4000 {
            let mut bytes = whole.clone();
            // Half of them where the structure is.
            let within = if trial % 2 == 0 { 1000 } else { bytes.len() };
            for _ in 0..1 + random(3) {
                bytes[random(within)] ^= 1 << random(8);
            }
            read[usize::from(is_read(&bytes))] += 1;
        }
        assert!(read[0] > 400 && read[1] > 400, "refused and read: {read:?}");
    }
}

/// Headers that promise much.
#[test]
fn nothing_is_allocated_for_promises() {
    for n in [0u32, 1, 2, 1 << 20, u32::MAX] {
        for (depth, channels, planes) in [(0u8, 1u8, 1u8), (20, 3, 3), (31, 1, 1), (255, 3, 1), (0, 2, 2), (0, 1, 0)] {
            let mut bytes = b"HMX1".to_vec();
            bytes.extend(n.to_le_bytes());
            bytes.extend([depth, channels, planes]);
            bytes.extend([0; 64]);
            assert!(!is_read(&bytes), "{n} patches, depth {depth}");
        }
    }
    assert!(!is_read(b"") && !is_read(b"HMX2") && !is_read(b"HMR1"));
    // One patch of weight 127, then receivers without end.
    let one_patch = [b"HMR1".as_slice(), &1u32.to_le_bytes(), &[0, 1, 1, 127]].concat();
    for [receivers, lit, trees] in [[u32::MAX, u32::MAX, u32::MAX], [u32::MAX, 0, 0], [9, 9, 10], [9, 10, 1], [0, 0, 0]]
    {
        let numbers = [receivers, lit, trees].map(u32::to_le_bytes);
        assert!(!is_read(&[&one_patch[..], numbers.as_flattened(), &[0; 64]].concat()), "{receivers} receivers");
    }
}
