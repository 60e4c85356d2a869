//! The stage between two containers, and the same bytes for any number of threads.

mod common;

use radfile::{
    Builder, Container, FormFactors, Operator, PatchLocator, Patches, Piece, Provenance, Quiet, Record, Step,
};
use series::{Error, Params, memory_needed, run};

fn step() -> Step {
    Step { stage: "series".into(), version: "0".into(), options: String::new(), inputs: vec![] }
}

/// A container as `formfactor` leaves it, with an old operator and a section that nobody knows.
fn input(n: usize) -> Container {
    let (area, factors) = common::room(n, 0.1, 31);
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let patches = Patches {
        position: vec![[0.0; 3]; n],
        normal: vec![[0.0, 0.0, 1.0]; n],
        reflectance: common::colours(n, 32),
        emission: vec![[0.0; 3]; n],
        piece_start: (0..=n as u32).collect(),
        pieces: vec![Piece { corners, face: 0 }; n],
        locator: PatchLocator {
            cell_size: 1.0,
            face_start: vec![0, 1, 1],
            cell_key: vec![0],
            cell_patch: vec![0],
            ..PatchLocator::default()
        },
        area,
    };
    let old = Operator { n: 1, channels: 1, bounces: None, values: vec![9.0].into() };
    let mut builder = Builder::new();
    patches.write(&mut builder);
    factors.write(&mut builder);
    old.write(&mut builder);
    builder.array("someone.else", 0, &[1], vec![7u8]);
    builder.array("pack.blocks", 0, &[1], vec![0u8]);
    builder.finish().unwrap()
}

fn output(input: &Container, params: &Params) -> Container {
    let mut out = None;
    let mut sink = |builder: &Builder<'_>| {
        out = Some(builder.finish()?);
        Ok(())
    };
    run(input, params, step(), &Quiet, &mut sink).unwrap();
    out.unwrap()
}

#[test]
fn the_stage_adds_the_operator_and_hands_the_rest_through() {
    let input = input(30);
    let out = output(&input, &Params::first_bounces(4));
    let operator = Operator::read(&out).unwrap();
    assert_eq!((operator.n, operator.channels, operator.bounces), (30, 3, Some(4)));
    assert_eq!(Patches::read(&out).unwrap(), Patches::read(&input).unwrap());
    assert_eq!(FormFactors::read(&out).unwrap(), FormFactors::read(&input).unwrap());
    assert!(out.has("someone.else"), "unknown sections are handed through");
    assert!(!out.has("pack.blocks"), "what was packed from the old operator is gone");
    assert_eq!(Provenance::read(&out).unwrap().steps.len(), 1);
}

#[test]
fn a_container_without_form_factors_is_refused() {
    let input = input(3);
    let without = Builder::from_input(&input, |s| s.name != "formfactor.values").finish().unwrap();
    let error = run(&without, &Params::default(), step(), &Quiet, &mut |_| Ok(())).unwrap_err();
    assert!(matches!(error, Error::Container(_)));
    assert!(error.to_string().contains("written by `allbounce formfactor`"), "{error}");
}

#[test]
fn any_number_of_threads_writes_the_same_bytes() {
    let input = input(700);
    for params in common::every_way(7) {
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let (mut bytes, mut report) = (vec![], None);
            pool.install(|| {
                let mut sink = |builder: &Builder<'_>| {
                    bytes = builder.to_bytes();
                    Ok(())
                };
                report = Some(run(&input, &params, step(), &Quiet, &mut sink).unwrap());
            });
            let mut report = report.unwrap();
            report.channel.iter_mut().for_each(|c| (c.seconds, c.peak_bytes) = (0.0, 0));
            (bytes, format!("{report:?}"))
        };
        let one = with(1);
        for threads in [2, 5] {
            let many = with(threads);
            assert!(one.0 == many.0, "{threads} threads wrote other bytes: {params:?}");
            assert_eq!(one.1, many.1, "{threads} threads reported other numbers: {params:?}");
        }
    }
}

#[test]
fn progress_reaches_exactly_its_total() {
    use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
    struct Count(AtomicU64, AtomicU64);
    impl radfile::Progress for Count {
        fn begin(&self, _: &str, total: u64) {
            self.0.fetch_add(total, Relaxed);
        }
        fn advance(&self, units: u64) {
            self.1.fetch_add(units, Relaxed);
        }
    }
    let input = input(400);
    for params in [1, 2, 5, 6, 11].into_iter().flat_map(common::every_way) {
        let count = Count(0.into(), 0.into());
        run(&input, &params, step(), &count, &mut |_| Ok(())).unwrap();
        assert_eq!(count.0.into_inner(), count.1.into_inner(), "{params:?}");
    }
}

#[test]
fn eight_thousand_coloured_patches_fit_in_six_gibibytes() {
    let factors = 4 * 8000_u64.pow(2);
    let all = memory_needed(8000, 3) + factors;
    assert!(all < 6 << 30, "{all}");
    assert!(Params::first_bounces(3).memory_needed(8000, 3) + factors < 6 << 30);
    // The result alone is 3 · 4 · n² bytes; the solver's matrices come on top.
    assert!(all > 12 * 8000_u64.pow(2) + factors);
}
