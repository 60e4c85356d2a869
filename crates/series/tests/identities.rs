//! What holds for every room: docs/theory.md (4.2), (7.1), (7.3), (8.4).

mod common;

use common::{colours, patches, room, solve};

#[test]
fn a_furnace_is_equally_bright_everywhere_however_well_it_reflects() {
    // 450 patches are three tiles a side; areas differ by a hundred times.
    for sky in [0.0, 0.2] {
        let (area, factors) = room(450, sky, 11);
        for rho in [0.5, 0.9, 0.99, 0.999] {
            let (_, report) = solve(&patches(area.clone(), vec![[rho; 3]; 450]), &factors, None);
            let c = &report.channel[0];
            // f64: 1e-16 · condition 2000 · n at worst.
            assert!(c.furnace_max_error < 1e-6, "rho {rho}: {c:?}");
            assert!(c.furnace_mean_error <= c.furnace_max_error);
            assert!(c.furnace_max_error_stored < 1e-5, "rho {rho}: {c:?}");
            assert!(c.residual < 1e-10, "rho {rho}: {c:?}");
        }
    }
}

#[test]
fn a_coloured_furnace_is_equally_bright_in_every_channel() {
    let n = 400;
    let (area, factors) = room(n, 0.05, 12);
    let (k, report) = solve(&patches(area, colours(n, 3)), &factors, None);
    assert_eq!(k.channels, 3);
    let names: Vec<&str> = report.channel.iter().map(|c| c.name).collect();
    assert_eq!(names, ["red", "green", "blue"]);
    for c in &report.channel {
        assert!(c.furnace_max_error < 1e-10 && c.furnace_max_error_stored < 1e-5, "{c:?}");
    }
}

#[test]
fn in_a_closed_room_of_one_reflectance_everyone_receives_what_everyone_reflects_and_absorbs() {
    // Σ_j X_ij = A_i / (1 − ρ): no sky, one ρ.
    let (area, factors) = room(250, 0.0, 13);
    let (k, _) = solve(&patches(area.clone(), vec![[0.8; 3]; 250]), &factors, None);
    for (i, row) in k.values.chunks_exact(250).enumerate() {
        let sum: f64 = row.iter().zip(&area).map(|(&k, &a)| f64::from(k) * f64::from(a).sqrt()).sum();
        let total = sum / f64::from(area[i]).sqrt();
        // Rows of the f32 factors sum to 1 within 1e-6; 1/(1 − ρ) = 5 twice over.
        assert!((total - 5.0).abs() < 5e-5, "patch {i}: {total}");
    }
}

#[test]
fn light_goes_both_ways_alike() {
    let n = 420;
    let (area, factors) = room(n, 0.1, 14);
    for bounces in [None, Some(5)] {
        let (k, _) = solve(&patches(area.clone(), colours(n, 4)), &factors, bounces);
        for colour in 0..3 {
            let k = k.channel(colour);
            assert!((0..n * n).all(|at| k[at].to_bits() == k[at % n * n + at / n].to_bits()), "{bounces:?}");
        }
    }
}

#[test]
fn more_bounces_and_brighter_walls_only_add_light() {
    let n = 210;
    let (area, factors) = room(n, 0.0, 15);
    let direct = common::naive(&area, &vec![0.0; n], &factors, 1);
    let mut darker: Vec<f32> = direct.iter().map(|&v| v as f32).collect();
    for rho in [0.1, 0.5, 0.8, 0.95] {
        let (k, _) = solve(&patches(area.clone(), vec![[rho; 3]; n]), &factors, None);
        assert!(k.values.iter().all(|v| v.is_finite()));
        assert!(k.values.iter().zip(&darker).all(|(new, old)| new >= old), "rho {rho}");
        darker = k.values.into_owned();
    }
}

#[test]
fn random_rooms_agree_with_the_plain_sum_of_bounces() {
    for seed in 0..6 {
        let n = 5 + 37 * seed as usize;
        let (area, factors) = room(n, 0.3, seed);
        let colours = colours(n, seed + 100);
        let (k, _) = solve(&patches(area.clone(), colours.clone()), &factors, None);
        for colour in 0..3 {
            let rho: Vec<f64> = colours.iter().map(|c| f64::from(c[colour])).collect();
            // 0.7 · 0.95 per bounce: 60 bounces leave 2e-11.
            let expected = common::naive(&area, &rho, &factors, 60);
            let error = common::difference(k.channel(colour), &expected);
            assert!(error < 1e-7, "seed {seed}: {error}");
        }
    }
}

#[test]
fn factors_that_are_not_reciprocal_are_averaged_and_reported() {
    let factors = radfile::FormFactors { values: vec![0.0, 0.5, 0.3, 0.0].into(), sky: vec![0.5, 0.6].into() };
    let (k, report) = solve(&patches(vec![1.0; 2], vec![[0.0; 3]; 2]), &factors, None);
    assert_eq!(k.values[..], [0.0, 0.4, 0.4, 0.0]);
    assert!((report.asymmetry - 0.5).abs() < 1e-6);
    assert!((report.closure_error - 0.1).abs() < 1e-6);
}

#[test]
fn a_row_that_sums_to_more_than_one_is_solved_while_light_fades_and_is_reported() {
    // Row 0 sums to 1.1, but ρ = 0.5 keeps the series convergent.
    let values = vec![0.0, 0.6, 0.5, 0.6, 0.0, 0.3, 0.5, 0.3, 0.0];
    let factors = radfile::FormFactors { values: values.into(), sky: vec![0.0, 0.1, 0.2].into() };
    let (_, report) = solve(&patches(vec![1.0; 3], vec![[0.95; 3]; 3]), &factors, None);
    assert_eq!((report.rows_above_one, report.largest_view.patch), (1, 0));
    assert!((report.largest_view.sum - 1.1).abs() < 1e-6);
    let c = &report.channel[0];
    assert!(c.largest_row.sum > 1.0 && c.spectral_radius < 1.0 && c.residual < 1e-12, "{c:?}");
}
