//! Bytes that are no operator give an error or a finite operator, never a panic.

#[path = "../../dxt-pack/tests/common/mod.rs"]
mod common;

use common::room;
use hmatrix::{Error, HMatrix, Params, compress};
use radfile::Quiet;

fn bytes() -> Vec<u8> {
    let room = room(7, 3);
    let params = Params { leaf: 8, ..Params::error(0.02) };
    compress(&room.operator, &room.patches, &params, &Quiet).expect("a room").0.to_bytes().to_vec()
}

/// Whether they are read; what is read has to work.
fn is_read(bytes: &[u8]) -> bool {
    let Ok(matrix) = HMatrix::from_bytes(bytes) else { return false };
    let n = matrix.patches();
    let mut y = vec![[0.0; 3]; n];
    matrix.multiply(&vec![[1.0, 0.5, 0.25]; n], &mut y, &mut matrix.workspace());
    assert!(y.as_flattened().iter().all(|y| y.is_finite()), "an operator that is not finite");
    true
}

#[test]
fn every_truncation_is_refused() {
    let bytes = bytes();
    assert!(is_read(&bytes));
    for end in (0..200).chain((200..bytes.len()).step_by(97)).chain(bytes.len() - 20..bytes.len()) {
        assert!(!is_read(&bytes[..end]), "the first {end} bytes");
    }
    let error = HMatrix::from_bytes(&bytes[..bytes.len() - 1]).map(|_| ()).expect_err("cut off");
    assert!(matches!(error, Error::Short { .. }), "{error}");
    let longer = [&bytes[..], &[0]].concat();
    assert!(matches!(HMatrix::from_bytes(&longer).map(|_| ()), Err(Error::Damaged { what: "the end", .. })));
}

#[test]
fn flipped_bits_are_refused_or_finite() {
    let whole = bytes();
    let mut state = 1u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let mut read = [0; 2];
    for trial in 0..4000 {
        let mut bytes = whole.clone();
        // Half of them where the structure is.
        let within = if trial % 2 == 0 { 700 } else { bytes.len() };
        for _ in 0..1 + random(3) {
            bytes[random(within)] ^= 1 << random(8);
        }
        read[usize::from(is_read(&bytes))] += 1;
    }
    assert!(read[0] > 400 && read[1] > 400, "refused and read: {read:?}");
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
    assert!(!is_read(b"") && !is_read(b"HMX2"));
}
