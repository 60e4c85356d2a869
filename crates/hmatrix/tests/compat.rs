//! Streams that earlier versions wrote are read for ever, with the meaning that they had.

#[path = "../../radfile/tests/fixture/mod.rs"]
mod fixture;

use std::path::Path;

use fixture::{cube, form_factors};
use hmatrix::Rectangle;
use radfile::{Container, Gathered, Lightmap, Record, Transfer, Volume, Weights};

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

/// Form factors of three sets of receivers, packed to 0.05 % when version 1.3 was new.
#[test]
fn the_rows_of_version_1_3_are_those_that_were_packed() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/compat/1.3/gathered.rad");
    let c = Container::open(&file).expect("the file is there");
    let Weights::Gathered(vertices) = Transfer::read(&c).expect("legal").weights else { panic!("they are gathered") };
    let texels = Gathered::read(&c, Lightmap::PREFIX, 6).expect("legal");
    let probes = Gathered::read(&c, Volume::PREFIX, 30).expect("legal");
    for (gathered, receivers) in [(vertices, 24), (texels, 6), (probes, 30)] {
        let rows = Rectangle::from_bytes(&gathered.stream).expect("a stream");
        assert_eq!([rows.receivers(), rows.senders()], [receivers, 27]);
        // Each sender alone, in red; all of them in green; the last half in blue.
        let exact = form_factors(receivers);
        for alone in 0..27 {
            let shine = |s: usize| [f32::from(s == alone), 1.0, f32::from(s > 13)];
            let sent: Vec<[f32; 3]> = (0..27).map(shine).collect();
            let mut light = vec![[0.0; 3]; receivers];
            rows.multiply(&sent, &mut light, &mut rows.workspace());
            for (r, (found, expected)) in light.iter().zip(exact.gather(&sent)).enumerate() {
                // The largest form factor is 6/128; codes and scales of packed entries have finite steps.
                let off = (0..3).map(|k| (found[k] - expected[k]).abs()).fold(0.0, f32::max);
                assert!(off < 1e-3, "receiver {r} gets {found:?} of sender {alone}, expected {expected:?}");
            }
        }
    }
}
