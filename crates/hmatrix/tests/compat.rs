//! Streams that earlier versions wrote are read for ever, with the meaning that they had.

#[path = "../../radfile/tests/fixture/mod.rs"]
mod fixture;

use std::path::Path;

use fixture::cube;
use radfile::Container;

/// The cube's operator, packed to 0.1 % when version 1.2 was new.
#[test]
fn the_operator_of_version_1_2_is_the_one_that_was_packed() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/compat/1.2/operators.rad");
    let (matrix, certificate) = hmatrix::read(&Container::open(&file).expect("the file is there")).expect("legal");
    let exact = cube().operator;
    assert_eq!((matrix.patches(), certificate.n, matrix.channels()), (6, 6, 3));
    for c in 0..3 {
        let decoded = matrix.decode(c).expect("legal");
        let square = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
        let exact: Vec<f64> = exact.channel(c).iter().map(|&v| f64::from(v)).collect();
        let error = square(&mut decoded.iter().zip(&exact).map(|(d, e)| d - e)) / square(&mut exact.iter().copied());
        assert!(error.sqrt() < 5e-3, "channel {c} is off by {}", error.sqrt());
    }
}
