//! Solvers side by side: where they must agree, and where they fail.

mod common;

use common::{every_way, room};
use series::{ChannelReport, Error, Method, Params, Precision, solve_raw};

fn of(method: Method) -> Params {
    Params { method, ..Params::default() }
}

/// A random room as raw f64, with `rho` of its own.
struct Room {
    f: Vec<f64>,
    rho: Vec<f64>,
    area: Vec<f64>,
}

impl Room {
    fn new(n: usize, sky: f64, brightest: f64, seed: u64) -> Room {
        let (area, factors) = room(n, sky, seed);
        let mut random = common::Random(seed + 1000);
        Room {
            f: factors.values.iter().map(|&v| f64::from(v)).collect(),
            rho: (0..n).map(|_| brightest * random.next()).collect(),
            area: area.iter().map(|&a| f64::from(a)).collect(),
        }
    }

    fn solve(&self, params: &Params) -> (Vec<f64>, ChannelReport) {
        solve_raw(&self.f, &self.rho, &self.area, params).unwrap_or_else(|e| panic!("{params:?}: {e}"))
    }
}

/// Largest difference relative to the largest value.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let largest = b.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

/// Σ_{b≤bounces} (F ρ)^{b−1} F, scaled by areas, with F neither averaged nor repaired.
fn explicit(room: &Room, bounces: usize) -> Vec<f64> {
    let n = room.rho.len();
    let mut sum = room.f.clone();
    for _ in 1..bounces {
        let mut next = room.f.clone();
        for i in 0..n {
            for k in 0..n {
                let back = room.f[i * n + k] * room.rho[k];
                (0..n).for_each(|j| next[i * n + j] += back * sum[k * n + j]);
            }
        }
        sum = next;
    }
    (0..n * n).map(|at| sum[at] * (room.area[at / n] / room.area[at % n]).sqrt()).collect()
}

#[test]
fn all_methods_agree_to_their_precision_in_a_room_of_several_tiles() {
    // Light keeps at most 0.7 · 0.9 of itself: 80 bounces leave 1e-16.
    let room = Room::new(420, 0.3, 0.9, 51);
    let (expected, _) = room.solve(&Params::default());
    assert!(difference(&explicit(&room, 80), &expected) < 1e-6, "F is reciprocal to f32 only");
    for params in every_way(80) {
        let (k, report) = room.solve(&params);
        let error = difference(&k, &expected);
        let bound = match (params.method, params.precision) {
            // Its F is not made reciprocal, and is so to f32 only.
            (Method::PaperInverse, _) | (_, Precision::F32) => 1e-6,
            (Method::Cg, _) => 1e-11,
            _ => 1e-14,
        };
        assert!(error < bound, "{params:?}: {error:e}");
        let exact = if params.precision == Precision::F32 { 1e-6 } else { 1e-11 };
        assert!(report.residual < exact && report.furnace_max_error < exact, "{report:?}");
        assert!(report.contracts && report.spectral_radius < 0.63, "{report:?}");
        assert_eq!((report.method, report.precision), (params.method, params.precision));
    }
}

#[test]
fn all_methods_find_the_light_between_two_plates() {
    // F_01 = 0.6 from 1 m² to 3 m², so F_10 = 0.2; each round trip keeps ρ₀ ρ₁ F_01 F_10.
    let room = Room { f: vec![0.0, 0.6, 0.2, 0.0], rho: vec![0.9, 0.8], area: vec![1.0, 3.0] };
    let trip: f64 = 0.9 * 0.8 * 0.12;
    let x = [0.12 * 0.8, 0.6, 0.6, 0.36 * 0.9].map(|x| x / (1.0 - trip));
    let expected = [x[0], x[1] / 3f64.sqrt(), x[2] / 3f64.sqrt(), x[3] / 3.0];
    for params in every_way(64) {
        let (k, report) = room.solve(&params);
        let bound = if params.precision == Precision::F32 { 3e-7 } else { 1e-14 };
        assert!(difference(&k, &expected) < bound, "{params:?}: {k:?}");
        assert!((report.spectral_radius - trip.sqrt()).abs() < 1e-12, "{report:?}");
        // The eigenvalues of I − R W R are 1 ± radius. The paper's matrix is not symmetric, so its singular values differ.
        if params.method != Method::PaperInverse {
            let condition = (1.0 + trip.sqrt()) / (1.0 - trip.sqrt());
            assert!((report.condition / condition - 1.0).abs() < 1e-9, "{report:?}");
        }
    }
}

#[test]
fn truncated_sums_are_the_explicit_ones() {
    let mut room = Room::new(60, 0.1, 0.95, 52);
    // Exactly reciprocal, so that nothing is averaged: equal areas and a symmetric F.
    room.area.fill(2.0);
    for i in 0..60 {
        for j in 0..i {
            room.f[j * 60 + i] = room.f[i * 60 + j];
        }
        // Rows that may now sum to more than 1 stay contracting.
        room.rho[i] *= 0.1;
    }
    for k in 1..=9 {
        let expected = explicit(&room, k as usize);
        for params in every_way(k).into_iter().filter(|p| p.bounces.is_some()) {
            let (sum, report) = room.solve(&params);
            let bound = if params.precision == Precision::F32 { 5e-7 } else { 1e-14 };
            assert!(difference(&sum, &expected) < bound, "{params:?}");
            let steps = (params.method == Method::Neumann).then_some(u64::from(k) - 1);
            assert_eq!(report.iterations, steps);
        }
    }
}

#[test]
fn the_papers_inverse_follows_factors_that_are_not_reciprocal_and_says_so() {
    let mut room = Room::new(200, 0.3, 0.9, 53);
    let mut random = common::Random(54);
    room.f.iter_mut().for_each(|f| *f *= 0.7 + 0.6 * random.next());
    let (k, report) = room.solve(&of(Method::PaperInverse));
    assert!(difference(&k, &explicit(&room, 120)) < 1e-12);
    assert!(report.asymmetry > 0.1 && report.residual < 1e-13 && report.negative == 0, "{report:?}");

    let (symmetric, averaged) = room.solve(&Params::default());
    assert_eq!(averaged.asymmetry, 0.0);
    assert!(difference(&k, &symmetric) > 0.05, "the mean of both directions is another scene");
}

#[test]
fn the_papers_inverse_exchanges_rows_across_tiles() {
    // Every column is largest a hundred rows below the diagonal, in three panels of 168 rows.
    let n = 500;
    let mut room = Room { f: vec![0.001; n * n], rho: vec![0.9; n], area: vec![1.0; n] };
    (0..n).for_each(|i| room.f[(i + 100) % n * n + i] = 3.0);
    let (_, report) = room.solve(&of(Method::PaperInverse));
    assert!(!report.contracts && report.residual < 1e-12 && report.furnace_max_error < 1e-10, "{report:?}");
}

/// Row sums above 1, as the point-to-disc formula gives them near contacts: patch 2 sees 0.9 of both others.
fn overestimated() -> Room {
    Room { f: vec![0.0, 0.1, 0.9, 0.1, 0.0, 0.9, 0.9, 0.9, 0.0], rho: vec![0.9; 3], area: vec![1.0; 3] }
}

#[test]
fn where_light_grows_cholesky_and_conjugate_gradients_name_the_patch() {
    let room = overestimated();
    for params in every_way(1).into_iter().filter(|p| matches!(p.method, Method::Cholesky | Method::Cg)) {
        let error = solve_raw(&room.f, &room.rho, &room.area, &params).map(|_| ()).expect_err("must be refused");
        let Error::NotContracting { patch, row_sum, radius, .. } = error else { panic!("{params:?}: {error}") };
        assert_eq!(patch, 2);
        assert!((row_sum - 1.62).abs() < 1e-12 && radius > 1.1, "{row_sum} {radius}");
    }
}

#[test]
fn where_light_grows_the_inverse_has_negative_light_and_a_short_sum_hides_it() {
    let room = overestimated();
    for precision in [Precision::F64, Precision::F32] {
        let (k, report) = room.solve(&Params { precision, ..of(Method::PaperInverse) });
        assert!(!report.contracts && report.spectral_radius > 1.1, "{report:?}");
        // It inverts what it was asked to invert, and that is not light.
        assert!(report.residual < 1e-5, "{report:?}");
        let negative = k.iter().filter(|&&v| v < 0.0).count() as u64;
        let lowest = k.iter().fold(0.0_f64, |l, &v| l.min(v));
        assert!(negative > 0 && lowest < -1.0, "{k:?}");
        assert_eq!((report.negative, report.lowest), (negative, lowest));
        assert_eq!(report.negative_share, negative as f64 / 9.0);

        for method in [Method::Doubling, Method::Neumann] {
            let sum = |bounces| room.solve(&Params { bounces: Some(bounces), precision, ..of(method) });
            let (three, report) = sum(3);
            assert!(!report.contracts && report.negative == 0, "{report:?}");
            assert!(three.iter().all(|&v| v < 3.0), "three bounces look like light: {three:?}");
            let (many, _) = sum(200);
            assert!(many[1] > 1e6, "two hundred do not: {many:?}");
        }
    }
}

#[test]
fn a_sum_that_overflows_says_that_it_is_no_number() {
    let room = overestimated();
    let params = Params { bounces: Some(65536), precision: Precision::F32, ..of(Method::Doubling) };
    let (k, report) = room.solve(&params);
    assert!(k.iter().all(|v| !v.is_finite()) && !report.residual.is_finite() && !report.contracts, "{report:?}");
}

#[test]
fn every_method_keeps_the_furnace_at_a_reflectance_of_0_999() {
    for sky in [0.0, 0.2] {
        let mut room = Room::new(450, sky, 0.0, 55);
        room.rho.fill(0.999);
        for params in every_way(16384) {
            if params.method == Method::Neumann {
                continue; // 16383 products; the next test takes a darker room
            }
            let (_, report) = room.solve(&params);
            // The condition number times what the precision leaves.
            let bound = if params.precision == Precision::F32 { 1e-3 } else { 1e-6 };
            println!(
                "{:>13} {:?} sky {sky}: furnace {:.1e}, residual {:.1e}, condition {:.0}",
                params.method.name(),
                params.precision,
                report.furnace_max_error,
                report.residual,
                report.condition
            );
            assert!(report.furnace_max_error < bound, "{report:?}");
        }
    }
}

#[test]
fn one_bounce_after_the_other_reaches_the_furnace_in_a_darker_room() {
    let mut room = Room::new(210, 0.0, 0.0, 56);
    room.rho.fill(0.9);
    let (_, report) = room.solve(&Params { bounces: Some(300), ..of(Method::Neumann) });
    // 0.9³⁰⁰ = 2e-14.
    assert!(report.furnace_max_error < 1e-12, "{report:?}");
}

#[test]
fn the_condition_of_a_closed_room_is_that_of_its_darkest_and_brightest_light() {
    // (1 − λ_min) / (1 − ρ) with λ_min ≥ −ρ, so (1 + ρ) / (1 − ρ) bounds it; two facing plates reach the bound.
    for rho in [0.5, 0.9, 0.99, 0.9999] {
        let plates = Room { f: vec![0.0, 1.0, 1.0, 0.0], rho: vec![rho; 2], area: vec![1.0; 2] };
        let (_, report) = plates.solve(&Params::default());
        assert!((report.condition * (1.0 - rho) / (1.0 + rho) - 1.0).abs() < 1e-9, "{report:?}");
        // Symmetric here, so the paper's matrix has the same one, found by singular values.
        let (_, paper) = plates.solve(&of(Method::PaperInverse));
        assert!((paper.condition / report.condition - 1.0).abs() < 1e-6, "{paper:?}");
    }
}

#[test]
fn conjugate_gradients_stop_at_the_tolerance_that_was_asked_for() {
    let mut room = Room::new(300, 0.0, 0.0, 57);
    room.rho.fill(0.95);
    let (exact, _) = room.solve(&Params::default());
    let mut steps = 0;
    for tolerance in [1e-2, 1e-4, 1e-8] {
        let (k, report) = room.solve(&Params { tolerance: Some(tolerance), ..of(Method::Cg) });
        let error = difference(&k, &exact);
        // K is one bounce more than X, and errors of X grow by at most the condition number 39.
        assert!(error < 39.0 * tolerance && report.residual < 39.0 * tolerance, "{tolerance:e}: {error:e} {report:?}");
        assert!(report.iterations.unwrap() > steps, "{report:?}");
        steps = report.iterations.unwrap();
    }
}

#[test]
fn f32_that_cannot_tell_a_scene_from_one_that_never_fades_is_refused_with_a_remedy() {
    // 1 − ρ = 1e-9 is nothing in f32.
    let plates = Room { f: vec![0.0, 1.0, 1.0, 0.0], rho: vec![1.0 - 1e-9; 2], area: vec![1.0; 2] };
    for method in [Method::Cholesky, Method::Cg] {
        let params = Params { precision: Precision::F32, ..of(method) };
        let error = solve_raw(&plates.f, &plates.rho, &plates.area, &params).map(|_| ()).expect_err("must be refused");
        assert!(error.to_string().contains("use --precision f64"), "{error}");
        let (_, report) = plates.solve(&of(method));
        assert!(report.residual < 1e-6, "{report:?}");
    }
}

#[test]
fn bounces_and_tolerances_belong_to_their_methods() {
    let room = overestimated();
    let refusal = |params: Params| {
        solve_raw(&room.f, &room.rho, &room.area, &params).map(|_| ()).expect_err("must be refused").to_string()
    };
    for method in [Method::Cholesky, Method::Cg, Method::PaperInverse] {
        let text = refusal(Params { bounces: Some(3), ..of(method) });
        assert!(text.starts_with(&format!("{} solves for all bounces", method.name())), "{text}");
    }
    for method in [Method::Doubling, Method::Neumann] {
        let text = refusal(of(method));
        assert!(text.starts_with(&format!("{} sums a number of bounces", method.name())), "{text}");
        let text = refusal(Params { bounces: Some(0), ..of(method) });
        assert!(text.starts_with("0 bounces were asked for"), "{text}");
    }
    for tolerance in [0.0, 1e-300, 1.0, f64::NAN] {
        let text = refusal(Params { tolerance: Some(tolerance), ..of(Method::Cg) });
        assert!(text.starts_with("tolerance ") && text.contains("between 2.3e-16 and 1"), "{text}");
    }
    let text = refusal(Params { tolerance: Some(1e-3), ..Params::default() });
    assert!(text.contains("for cholesky: only cg has one"), "{text}");
}

#[test]
fn raw_numbers_that_mean_nothing_are_refused() {
    let refusal = |f: &[f64], rho: &[f64], area: &[f64]| {
        solve_raw(f, rho, area, &Params::default()).map(|_| ()).expect_err("must be refused").to_string()
    };
    assert!(refusal(&[], &[], &[]).starts_with("the scene has no patches"));
    assert!(refusal(&[0.0; 3], &[0.5; 2], &[1.0; 2]).starts_with("form factors of 2 patches (3 values)"));
    assert!(refusal(&[0.0; 4], &[0.5; 3], &[1.0; 2]).starts_with("form factors of 3 patches"));
    assert!(refusal(&[0.0, -0.5, 0.5, 0.0], &[0.5; 2], &[1.0; 2]).starts_with("a form factor of patch 0 is -0.5"));
    assert!(refusal(&[0.0, 0.5, f64::INFINITY, 0.0], &[0.5; 2], &[1.0; 2]).starts_with("a form factor of patch 1"));
    assert!(refusal(&[0.0; 4], &[0.5, 1.0], &[1.0; 2]).starts_with("reflectance of patch 1 is 1"));
    assert!(refusal(&[0.0; 4], &[0.5; 2], &[1.0, 0.0]).starts_with("area of patch 1 is 0"));
}
