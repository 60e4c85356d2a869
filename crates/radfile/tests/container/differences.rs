//! The differ knows numbers from bytes, and says where they differ most.

use radfile::{Builder, Container, Report, Tolerance, Verdict, diff};

use crate::fixture::{cube, every_feature, open, step};

const LOOSE: Tolerance = Tolerance { abs: 1e-3, rms: 1e-3 };

fn numbers(values: &[f32]) -> Container {
    let mut builder = Builder::new();
    builder.array("x", 0, &[2, values.len() / 2], values.to_vec());
    open(&builder)
}

fn verdict(report: &Report, name: &str) -> Verdict {
    report.sections.iter().find(|s| s.name == name).expect("compared").verdict
}

#[test]
fn a_file_equals_itself() {
    let report = diff(&open(&cube().builder()), &open(&cube().builder()), Tolerance::EXACT);
    assert!(report.equal && report.sections.iter().all(|s| s.verdict == Verdict::Same));
}

#[test]
fn the_largest_difference_is_found_with_its_index() {
    let (a, b) = (numbers(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), numbers(&[1.0, 2.5, 3.0, 4.0, 4.0, 6.0]));
    let report = diff(&a, &b, Tolerance { abs: 2.0, rms: 0.2 });
    let x = &report.sections[0];
    assert_eq!((x.differing, x.index.as_deref(), x.largest), (2, Some(&[1, 1][..]), 1.0));
    // Differences 0.5 and 1 against 1² + … + 6² = 91.
    assert!((x.relative_rms - (1.25f64 / 91.0).sqrt()).abs() < 1e-15);
    assert!(report.equal && x.verdict == Verdict::Within);
    assert!(!diff(&a, &b, Tolerance { abs: 0.9, rms: 0.2 }).equal);
    assert!(!diff(&a, &b, Tolerance { abs: 2.0, rms: 0.1 }).equal);
}

#[test]
fn what_is_no_number_is_infinitely_far_from_every_number_but_not_from_itself() {
    let nan = f32::NAN;
    let report = diff(&numbers(&[nan, 1.0]), &numbers(&[nan, 1.0 + 1e-6]), LOOSE);
    assert!(report.equal, "{report:?}");
    let report = diff(&numbers(&[1.0, 1.0]), &numbers(&[1.0, nan]), LOOSE);
    assert!(!report.equal && report.sections[0].largest == f64::INFINITY);
    assert_eq!(report.sections[0].index.as_deref(), Some(&[1, 0][..]));
    assert!(diff(&numbers(&[f32::INFINITY, 0.0]), &numbers(&[f32::INFINITY, -0.0]), Tolerance::EXACT).equal);
    assert!(!diff(&numbers(&[0.0, 0.0]), &numbers(&[0.0, 1e-9]), LOOSE).equal, "relative to nothing is infinite");
}

#[test]
fn tolerances_are_for_floating_point_numbers_only() {
    let (a, mut b) = (cube(), cube());
    b.order = radfile::Permutation::identity(6);
    b.packed.blocks.to_mut()[9] ^= 1;
    b.patches.area[3] += 1e-6;
    let report = diff(&open(&a.builder()), &open(&b.builder()), Tolerance { abs: 1e9, rms: 1e9 });
    assert!(!report.equal);
    assert_eq!(verdict(&report, "permute.new_to_old"), Verdict::Beyond);
    assert_eq!(verdict(&report, "patches.area"), Verdict::Within);
    let blocks = report.sections.iter().find(|s| s.name == "pack.blocks").expect("compared");
    assert_eq!((blocks.verdict, blocks.differing, blocks.index.as_deref()), (Verdict::Beyond, 1, Some(&[0, 9][..])));
}

#[test]
fn missing_extra_and_misshapen_sections_are_reported() {
    let a = open(&every_feature());
    let mut other = Builder::from_input(&a, |s| s.name != "x-rank.1");
    other.array::<u32>("x-rank.2", 0, &[3, 2], (0..6).collect::<Vec<u32>>());
    other.array::<f64>("x-scalar", 2, &[], vec![-0.5]);
    other.array::<u8>("x-new", 0, &[1], vec![1]);
    let report = diff(&a, &open(&other), LOOSE);
    let verdicts = ["x-rank.1", "x-rank.2", "x-scalar", "x-new", "x-rank.3"].map(|name| verdict(&report, name));
    assert_eq!(verdicts, [Verdict::Missing, Verdict::Shape, Verdict::Shape, Verdict::Extra, Verdict::Same]);
    let misshapen = report.sections.iter().find(|s| s.name == "x-rank.2").expect("compared");
    assert_eq!((misshapen.a.as_deref(), misshapen.b.as_deref()), (Some("u32 [2, 3]"), Some("u32 [3, 2]")));
    assert!(!report.equal);
}

#[test]
fn metadata_must_be_equal_but_provenance_is_not_judged() {
    let a = open(&every_feature());
    let mut other = Builder::from_input(&a, |_| true);
    other.provenance(Some(&a), step("another")).expect("readable");
    let report = diff(&a, &open(&other), Tolerance::EXACT);
    assert!(report.equal);
    assert_eq!(verdict(&report, "provenance"), Verdict::Unjudged);
    other.meta("x-note", 0, &"a section that no version knows!");
    let report = diff(&a, &open(&other), LOOSE);
    assert_eq!((report.equal, verdict(&report, "x-note")), (false, Verdict::Beyond));
}

#[test]
fn limits_that_are_not_given_do_not_bind() {
    assert_eq!(Tolerance::new(None, None), Tolerance::EXACT);
    assert_eq!(Tolerance::new(Some(0.5), None), Tolerance { abs: 0.5, rms: f64::INFINITY });
    assert_eq!(Tolerance::new(None, Some(0.5)), Tolerance { abs: f64::INFINITY, rms: 0.5 });
}
