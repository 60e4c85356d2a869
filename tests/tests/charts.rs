//! Captions of `docs/charts/` are true, and its numbers are what the code finds.

use std::sync::LazyLock;

use allbounce_tests::{
    charts::{
        Claim, Effort, Figure, all, judge,
        monte_carlo::closed_form_factors,
        page,
        rectangles::{Rectangle, exchange_area},
        room::Room,
        table::{Cell, rows},
    },
    root,
};

static FIGURES: LazyLock<Vec<Figure>> = LazyLock::new(|| all(Effort::Quick));

fn committed(name: &str) -> String {
    std::fs::read_to_string(root().join("docs/charts").join(name)).expect("run `make charts`")
}

#[test]
fn every_caption_is_true() {
    for figure in FIGURES.iter() {
        for claim in &figure.claims {
            assert!(claim.holds, "{}: \"{}\" Measured: {:?}.", figure.name, claim.says, claim.measured);
        }
    }
}

/// Kinds of processors round differently, so numbers may lie apart as far as the figure says.
#[test]
fn committed_numbers_are_what_the_code_finds() {
    for figure in FIGURES.iter() {
        let keys = figure.table.keys;
        let written = rows(&committed(&format!("{}.csv", figure.name)));
        for row in &figure.table.rows {
            // As in the file: with its digits.
            let row: Vec<Cell> = rows(&format!("header\n{}\n", line(row))).remove(0);
            let same = written.iter().find(|other| other[..keys] == row[..keys]);
            let other = same.unwrap_or_else(|| panic!("{}.csv has no row {row:?}; run `make charts`", figure.name));
            let agree = row.iter().zip(other).all(|(a, b)| figure.agreement.holds(a, b));
            assert!(agree && row.len() == other.len(), "{}: {row:?}, committed {other:?}", figure.name);
        }
    }
}

fn line(row: &[Cell]) -> String {
    row.iter().map(Cell::text).collect::<Vec<_>>().join(",")
}

#[test]
fn the_page_shows_every_chart_with_its_caption() {
    let page = committed("README.md");
    assert!(page.starts_with(&format!("{}\n## ", page::HEAD)), "other words before the figures; run `make charts`");
    for figure in FIGURES.iter() {
        let claims = figure.claims.iter().map(|claim| claim.says.as_str());
        for words in claims.chain([figure.setting.as_str(), figure.chart.title.as_str()]) {
            assert!(page.contains(words), "the page does not say \"{words}\"; run `make charts`");
        }
        for ending in ["png", "svg", "csv"] {
            let name = format!("{}.{ending}", figure.name);
            assert!(page.contains(&format!("({name})")), "the page does not show {name}");
            assert!(root().join("docs/charts").join(&name).exists(), "{name} is missing");
        }
        assert!(committed(&format!("{}.svg", figure.name)).contains(&figure.chart.title), "{}.svg", figure.name);
    }
}

#[test]
fn a_claim_that_is_not_so_is_seen() {
    assert!(Claim::within(1.0, 0.5..=1.5, "").holds && Claim::at_most(1.0, 1.0, "").holds);
    let wrong = [Claim::within(2.0, 0.5..=1.5, ""), Claim::at_most(2.0, 1.0, ""), Claim::at_least(0.0, 1.0, "")];
    let no_number = [Claim::at_most(f64::NAN, 1.0, ""), Claim::at_least(f64::NAN, 1.0, "")];
    assert!(wrong.iter().chain(&no_number).all(|claim| !claim.holds));
}

fn unit_square(axis: usize, plane: f64, facing: f64) -> Rectangle {
    let mut corners = [[0.0; 3], [1.0; 3]];
    (corners[0][axis], corners[1][axis]) = (plane, plane);
    Rectangle { corners, axis, facing }
}

/// Values of Howell's catalogue (C-11, C-14) for unit squares, and the sum of a cube's row.
#[test]
fn closed_forms_are_those_of_the_catalogue() {
    let floor = unit_square(2, 0.0, 1.0);
    let (opposed, beside) = (unit_square(2, 1.0, -1.0), unit_square(0, 0.0, 1.0));
    assert!((exchange_area(&floor, &opposed) - 0.199824895698387).abs() < 1e-14);
    assert!((exchange_area(&floor, &beside) - 0.200043776075403).abs() < 1e-14);
    assert!((exchange_area(&beside, &floor) - 0.200043776075403).abs() < 1e-14);
}

/// Unequal patches of a closed room see each other and nothing else, before anything is scaled.
#[test]
fn closed_forms_of_a_room_sum_to_its_areas() {
    let room = Room::hall();
    for (patch, area) in room.patches.iter().zip(&room.area) {
        let sum: f64 = room.patches.iter().map(|other| exchange_area(patch, other)).sum();
        assert!((sum / area - 1.0).abs() < 1e-11, "{patch:?} sums to {sum}");
    }
    let f = room.form_factors();
    for row in f.chunks_exact(room.len()) {
        assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }
}

/// Everything lit with 1 stays equally lit: ρ / (1 − ρ) after all bounces, and the judge knows how well it knows it.
#[test]
fn the_judge_is_right_where_the_answer_is_known() {
    let room = Room::hall();
    let f = room.form_factors();
    for rho in [0.5, 0.99, 0.9999] {
        let judged = judge::all_bounces(&f, rho, &vec![1.0; room.len()]);
        let expected = rho / (1.0 - rho);
        for light in &judged.light {
            // Rows of F sum to 1 within rounding, which 1 / (1 − ρ) magnifies.
            assert!((light / expected - 1.0).abs() < 1e-15 / (1.0 - rho), "{light}, expected {expected}");
        }
        assert!(judged.bound < 1e-15 / (1.0 - rho), "ρ = {rho}: {}", judged.bound);
    }
}

/// Plain Monte Carlo has no bias: the mean of many runs is nearer to the closed forms than one run.
#[test]
fn plain_monte_carlo_is_unbiased() {
    let cuts = [0.0, 0.4, 1.0];
    let room = Room::new([&cuts, &cuts, &cuts]);
    let exact = room.form_factors();
    let error = |f: &[f64]| f.iter().zip(&exact).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    let runs: Vec<Vec<f64>> = (1..=100).map(|seed| closed_form_factors(&room, 1 << 10, seed)).collect();
    let mean: Vec<f64> = (0..exact.len()).map(|at| runs.iter().map(|run| run[at]).sum::<f64>() / 100.0).collect();
    let one = runs.iter().map(|run| error(run)).sum::<f64>() / 100.0;
    assert!(error(&mean) < 0.15 * one, "{} of one run, {} of their mean", one, error(&mean));
}
