//! A counted number of bounces.

mod common;

use common::{colours, patches, room, solve};

#[test]
fn doubling_gives_exactly_the_bounces_that_were_asked_for() {
    let n = 40;
    let (area, factors) = room(n, 0.1, 21);
    let colours = colours(n, 22);
    for bounces in 1..=9 {
        let (k, report) = solve(&patches(area.clone(), colours.clone()), &factors, Some(bounces));
        assert_eq!((k.bounces, report.bounces), (Some(bounces), Some(bounces)));
        for colour in 0..3 {
            let rho: Vec<f64> = colours.iter().map(|c| f64::from(c[colour])).collect();
            let expected = common::naive(&area, &rho, &factors, bounces as usize);
            let error = common::difference(k.channel(colour), &expected);
            assert!(error < 1e-7, "{bounces} bounces: {error}");
        }
    }
}

#[test]
fn doubling_works_across_tiles() {
    let n = 450;
    let (area, factors) = room(n, 0.0, 23);
    for bounces in [6, 7] {
        let (k, _) = solve(&patches(area.clone(), vec![[0.9; 3]; n]), &factors, Some(bounces));
        let expected = common::naive(&area, &vec![f64::from(0.9_f32); n], &factors, bounces as usize);
        assert!(common::difference(&k.values, &expected) < 1e-7, "{bounces} bounces");
    }
}

#[test]
fn very_many_bounces_are_all_bounces() {
    let (area, factors) = room(250, 0.0, 24);
    let room = patches(area, vec![[0.9; 3]; 250]);
    let (all, _) = solve(&room, &factors, None);
    let expected: Vec<f64> = all.values.iter().map(|&v| f64::from(v)).collect();
    for bounces in [300, 1023, u32::MAX] {
        let (many, _) = solve(&room, &factors, Some(bounces));
        // 0.9³⁰⁰ = 2e-14; both were rounded to f32.
        assert!(common::difference(&many.values, &expected) < 2e-7, "{bounces}");
    }
}

#[test]
fn the_report_of_three_bounces_tells_what_later_ones_would_bring() {
    // A closed room of one reflectance: bounce b + 1 carries ρ^b of the furnace's light,
    // so three leave ρ³ out: 87.5 %, 48.8 % and 27.1 % at 0.5, 0.8, 0.9 are in.
    let (area, factors) = room(100, 0.0, 25);
    for (rho, inside) in [(0.5, 0.875), (0.8, 0.488), (0.9, 0.271)] {
        let (_, report) = solve(&patches(area.clone(), vec![[rho; 3]; 100]), &factors, Some(3));
        let c = &report.channel[0];
        assert!((1.0 - c.furnace_mean_error - inside).abs() < 1e-5, "{c:?}");
        assert!(c.residual > 0.0 && c.residual < 1.0, "{c:?}");
    }
}
