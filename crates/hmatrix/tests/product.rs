//! The product against the decoded operator in f64, and small operators.

#[path = "../../dxt-pack/tests/common/mod.rs"]
mod common;

use common::{Room, room, some_patches};
use hmatrix::{Error, HMatrix, Params, compress, memory_needed};
use radfile::{Operator, Quiet};

fn noise(i: usize) -> f32 {
    ((i as u32).wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32
}

fn light(n: usize) -> Vec<[f32; 3]> {
    (0..n).map(|i| [noise(3 * i), noise(3 * i + 1).powi(8), noise(3 * i + 2) - 0.5]).collect()
}

/// y = K x through the product and by the definition.
fn assert_product(matrix: &HMatrix) {
    let n = matrix.patches();
    let x = light(n);
    let mut y = vec![[f32::NAN; 3]; n];
    let mut workspace = matrix.workspace();
    matrix.multiply(&x, &mut y, &mut workspace);
    for c in 0..3 {
        let dense = matrix.decode(c.min(matrix.channels() - 1)).expect("own bytes");
        let dot = |i: usize| (0..n).map(|j| dense[i * n + j] * f64::from(x[j][c])).sum::<f64>();
        let size = |i: usize| (0..n).map(|j| (dense[i * n + j] * f64::from(x[j][c])).abs()).sum::<f64>();
        let mean = (0..n).map(size).sum::<f64>() / n as f64;
        for (i, y) in y.iter().enumerate() {
            assert!((f64::from(y[c]) - dot(i)).abs() <= 1e-5 * mean, "{i} {c}: {} and {}", y[c], dot(i));
        }
        for i in 0..n {
            for j in 0..i {
                let (there, back) = (dense[i * n + j], dense[j * n + i]);
                assert!((there - back).abs() <= 1e-12 * there.abs(), "K[{i}, {j}] is {there} and {back}");
            }
        }
    }
    let mut again = vec![[0.0; 3]; n];
    matrix.multiply(&x, &mut again, &mut workspace);
    assert_eq!(y, again, "nothing is left in the workspace");
    let read = HMatrix::from_bytes(matrix.to_bytes()).expect("own bytes");
    read.multiply(&x, &mut again, &mut read.workspace());
    assert_eq!(y, again, "bytes are all there is");
}

#[test]
fn the_product_is_that_of_the_decoded_operator() {
    for (channels, error, leaf) in [(3, 0.01, 24), (3, 0.1, 5), (1, 0.001, 60), (3, 0.001, 24)] {
        let Room { patches, operator } = room(9, channels);
        let params = Params { leaf, ..Params::error(error) };
        let (matrix, _) = compress(&operator, &patches, &params, &Quiet).expect("a room");
        assert_product(&matrix);
    }
}

/// K_ij = 1 / (1 + |i − j|), so that every entry matters.
fn made_up(n: usize, channels: usize) -> Operator<'static> {
    let value = |at: usize| 1.0 / (1.0 + (at / n % n).abs_diff(at % n) as f32 + (at / (n * n)) as f32);
    Operator { n, channels, bounces: None, values: (0..channels * n * n).map(value).collect() }
}

#[test]
fn few_patches_are_packed_as_well() {
    for n in (1..=9).chain([23, 24, 25, 49]) {
        for channels in [1, 3] {
            let operator = made_up(n, channels);
            let (matrix, report) =
                compress(&operator, &some_patches(n), &Params::error(0.01), &Quiet).expect("a small operator");
            assert!(report.l2_mean <= 0.03, "{n} patches: {report:?}");
            assert_product(&matrix);
        }
    }
}

#[test]
fn nothing_stays_nothing() {
    for channels in [1, 3] {
        let operator = Operator { values: vec![0.0; channels * 2500].into(), ..made_up(50, channels) };
        let (matrix, report) = compress(&operator, &some_patches(50), &Params::default(), &Quiet).expect("zeros");
        assert_eq!((report.l2_max, report.vis99, report.energy_bias), (0.0, 0.0, 0.0));
        let mut y = vec![[1.0; 3]; 50];
        matrix.multiply(&light(50), &mut y, &mut matrix.workspace());
        assert_eq!(y, [[0.0; 3]; 50]);
    }
}

#[test]
fn what_is_no_operator_is_refused() {
    let pack = |operator: &Operator, patches: usize, params: &Params| {
        compress(operator, &some_patches(patches), params, &Quiet).map(|_| ()).expect_err("refused")
    };
    let params = Params::default();
    for bad in [f32::NAN, -1.0, f32::INFINITY] {
        let mut operator = made_up(6, 3);
        operator.values.to_mut()[36 + 8] = bad;
        let error = pack(&operator, 6, &params).to_string();
        assert!(error.contains("K[1, 2] of channel 1 is"), "{error}");
    }
    let error = pack(&made_up(6, 3), 5, &params).to_string();
    assert!(error.contains("has 6 patches, the patch list 5"), "{error}");
    assert!(matches!(pack(&Operator { n: 7, ..made_up(6, 1) }, 7, &params), Error::Shape { values: 36, .. }));
    assert!(matches!(pack(&Operator { channels: 2, ..made_up(6, 1) }, 6, &params), Error::Shape { channels: 2, .. }));
    let error = pack(&made_up(0, 1), 0, &params).to_string();
    assert!(error.contains("no patches"), "{error}");
    for error in [f64::NAN, 0.0, -1.0, 0.6] {
        assert!(matches!(pack(&made_up(6, 1), 6, &Params::error(error)), Error::Option { option: "error", .. }));
    }
    for leaf in [0, 3, 65] {
        let params = Params { leaf, ..Params::default() };
        assert!(matches!(pack(&made_up(6, 1), 6, &params), Error::Option { option: "leaf", .. }));
    }
    let none = Params { probes: 0, ..Params::default() };
    assert!(matches!(pack(&made_up(6, 1), 6, &none), Error::Option { option: "probes", .. }));
}

#[test]
fn memory_grows_with_the_entries() {
    assert!(memory_needed(5000, 3) > 4 * 5000 * 5000 && memory_needed(5000, 3) > memory_needed(5000, 1));
    assert!(memory_needed(5000, 3) < 2 << 30);
}

/// Files that were packed once are read for ever, and the same operator gives the same file. The digest is that of the
/// processors and the mathematical library of Linux; elsewhere a probe light may differ in its last bit.
#[test]
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
fn the_bytes_of_an_operator_stay() {
    let Room { patches, operator } = room(7, 3);
    let (matrix, _) = compress(&operator, &patches, &Params::error(0.01), &Quiet).expect("a room");
    assert_eq!(radfile::digest(matrix.to_bytes()), "36abf667594d4a8a9e3bc4fe46070681597cd8dc5b54b7319f0a72991fb4d399");
}
