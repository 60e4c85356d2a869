//! Rooms whose light can be written down.

mod common;

use common::{patches, solve};
use radfile::FormFactors;

#[test]
fn light_between_two_plates_of_different_size_is_a_geometric_series() {
    // F_01 = 0.6 from 1 m² to 3 m², so F_10 = 0.2. Each round trip keeps ρ₀ ρ₁ F_01 F_10.
    let factors = FormFactors { values: vec![0.0, 0.6, 0.2, 0.0].into(), sky: vec![0.4, 0.8].into() };
    let room = patches(vec![1.0, 3.0], vec![[0.9, 0.5, 0.0], [0.8, 0.25, 0.7]]);
    let (k, report) = solve(&room, &factors, None);
    assert_eq!((k.n, k.channels, k.bounces), (2, 3, None));
    for colour in 0..3 {
        let [r0, r1] = [0, 1].map(|i| f64::from(room.reflectance[i][colour]));
        let trips = 1.0 / (1.0 - r0 * r1 * 0.12);
        // X_01 = A_0 F_01 · trips; X_00 goes to plate 1 and back; K = X / √(A A).
        let x = [0.6 * 0.2 * r1 * trips, 0.6 * trips, 0.6 * trips, 3.0 * 0.2 * 0.6 * r0 * trips];
        let expected = [x[0], x[1] / 3f64.sqrt(), x[2] / 3f64.sqrt(), x[3] / 3.0];
        // 0.6 and 0.2 are f32 in the input: relative error 2⁻²⁴ each, and the store adds one more.
        let error = common::difference(k.channel(colour), &expected);
        assert!(error < 2e-7, "{error}");
        let radius = (r0 * r1 * 0.12).sqrt();
        assert!((report.channel[colour].spectral_radius - radius).abs() < 1e-6, "{report:?}");
        // The eigenvalues of I − R W R are 1 ± radius.
        assert!((report.channel[colour].condition - (1.0 + radius) / (1.0 - radius)).abs() < 1e-3, "{report:?}");
    }
}

#[test]
fn light_in_a_cube_follows_the_three_symmetries_of_its_faces() {
    // Faces opposed and adjacent (Howell C-11, C-14), closed: opposite + 4 adjacent = 1.
    let opposite = 0.199_824_9;
    let adjacent = (1.0 - opposite) / 4.0;
    let face = |i: usize, j: usize| match i.abs_diff(j) {
        0 => 0.0,
        1 if i / 2 == j / 2 => opposite,
        _ => adjacent,
    };
    let values: Vec<f32> = (0..36).map(|at| face(at / 6, at % 6) as f32).collect();
    let factors = FormFactors { values: values.into(), sky: vec![0.0; 6].into() };
    let rho = 0.75;
    let (k, report) = solve(&patches(vec![4.0; 6], vec![[rho; 3]; 6]), &factors, None);
    assert_eq!(k.channels, 1, "a grey cube needs one channel");

    // F has eigenvalue 1 (uniform), −opposite (odd, 3 times), opposite − 2 adjacent (even, 2 times).
    let all = |f: f64| f / (1.0 - f64::from(rho) * f);
    let (uniform, odd, even) = (all(1.0), all(-opposite), all(opposite - 2.0 * adjacent));
    let expected: Vec<f64> = (0..36_usize)
        .map(|at| match (at / 6).abs_diff(at % 6) {
            0 => (uniform + 3.0 * odd + 2.0 * even) / 6.0,
            1 if at / 12 == at % 6 / 2 => (uniform - 3.0 * odd + 2.0 * even) / 6.0,
            _ => (uniform - even) / 6.0,
        })
        .collect();
    // f32 factors: row sums are off by 1e-7, which 1/(1 − ρ) makes 4e-7.
    assert!(common::difference(&k.values, &expected) < 1e-6, "{:?} {expected:?}", k.values);
    assert!((report.channel[0].spectral_radius - 0.75).abs() < 1e-6);
}

#[test]
fn a_single_patch_that_sees_itself_sums_its_own_light() {
    let factors = FormFactors { values: vec![0.5].into(), sky: vec![0.5].into() };
    let (k, report) = solve(&patches(vec![2.0], vec![[0.5; 3]]), &factors, None);
    assert!((f64::from(k.values[0]) - 0.5 / 0.75).abs() < 1e-7);
    assert!(report.channel[0].furnace_max_error < 1e-12);
}

#[test]
fn without_reflection_all_bounces_are_the_first() {
    let (area, factors) = common::room(300, 0.1, 5);
    let (k, report) = solve(&patches(area.clone(), vec![[0.0; 3]; 300]), &factors, None);
    let w = common::naive(&area, &[0.0; 300], &factors, 1);
    assert!(k.values.iter().zip(&w).all(|(&k, &w)| k == w as f32), "K must be W exactly");
    assert!(report.channel[0].residual < 1e-14 && report.channel[0].spectral_radius < 1e-12);
}

#[test]
fn patches_that_see_nothing_exchange_nothing() {
    let factors = FormFactors { values: vec![0.0; 9].into(), sky: vec![1.0; 3].into() };
    let (k, report) = solve(&patches(vec![1.0; 3], vec![[0.9; 3]; 3]), &factors, None);
    assert!(k.values.iter().all(|&v| v == 0.0));
    let c = &report.channel[0];
    assert_eq!((c.residual, c.furnace_max_error, c.condition), (0.0, 0.0, 1.0));
}
