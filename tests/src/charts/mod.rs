//! The stability laboratory: where methods hold and where they fail, as charts whose captions are checked.
//!
//! A [`Figure`] is a table, a picture of it, and claims about it with the figures that were found. `make charts`
//! writes them to `docs/charts/`; `tests/charts.rs` makes them again with fewer points, asserts the claims and
//! compares the committed tables.
//!
//! Nothing here believes a solver or a sampler of ours: rooms are empty boxes with form factors in closed form
//! (`rectangles`, `room`), and light is judged by a solution with a certificate (`judge`). Charts of `operators` are
//! drawn from a record of `make bench`.

pub mod adaptive;
pub mod bounces;
pub mod condition;
pub mod judge;
pub mod kernels;
pub mod monte_carlo;
pub mod operators;
pub mod page;
pub mod rays;
pub mod rectangles;
pub mod room;
pub mod solvers;
pub mod table;
pub mod unnormalised;

use std::ops::RangeInclusive;

use plot::{Axis, Chart, Scale, Ticks};
use table::{Agreement, Table};

use crate::root;

/// How many points a chart gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// For the page.
    Full,
    /// Some of them, for a test.
    Quick,
}

/// A chart, what it shows, and its numbers.
pub struct Figure {
    /// Of its files, without ending.
    pub name: &'static str,
    /// What was done.
    pub setting: String,
    /// What it shows.
    pub claims: Vec<Claim>,
    pub table: Table,
    /// How far the numbers of two machines may lie apart.
    pub agreement: Agreement,
    pub chart: Chart,
}

/// A sentence of a caption and whether it is so.
#[derive(Debug)]
pub struct Claim {
    pub says: String,
    pub holds: bool,
    /// The number that decides, if one does.
    pub measured: Option<f64>,
}

impl Claim {
    /// `measured` lies in `limits`; what is no number lies nowhere.
    pub fn within(measured: f64, limits: RangeInclusive<f64>, says: &str) -> Claim {
        Claim { says: says.to_owned(), holds: limits.contains(&measured), measured: Some(measured) }
    }

    /// `measured` is `limit` or less.
    pub fn at_most(measured: f64, limit: f64, says: &str) -> Claim {
        Claim::within(measured, f64::NEG_INFINITY..=limit, says)
    }

    /// `measured` is `limit` or more.
    pub fn at_least(measured: f64, limit: f64, says: &str) -> Claim {
        Claim::within(measured, limit..=f64::INFINITY, says)
    }

    /// What is so or not.
    pub fn fact(holds: bool, says: &str) -> Claim {
        Claim { says: says.to_owned(), holds, measured: None }
    }
}

/// The record of adaptive patches that is shown.
const ADAPTIVE: &str = "bench/record/epyc-2c/2026-11-22-adaptive.csv";

/// Every figure, in the order of the page.
pub fn all(effort: Effort) -> Vec<Figure> {
    let [centre, disc] = unnormalised::figures(effort);
    let mut figures = vec![
        solvers::figure(effort),
        centre,
        disc,
        bounces::figure(effort),
        rays::squares(effort),
        rays::room(effort),
        condition::figure(effort),
    ];
    figures.extend(operators::figures(&operators::Record::shown()));
    figures.push(adaptive::figure(&root().join(ADAPTIVE)));
    figures
}

/// Reflectances from 0.1 to 0.9999.
fn reflectances(effort: Effort) -> &'static [f64] {
    match effort {
        Effort::Full => &[
            0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 0.98, 0.99, 0.995, 0.998, 0.999, 0.9995, 0.9998,
            0.9999,
        ],
        Effort::Quick => &[0.1, 0.5, 0.9, 0.99, 0.999, 0.9999],
    }
}

/// Where a reflectance is on its axis: the axis is that of 1 / (1 − ρ), the sum of all bounces.
fn place(rho: f64) -> f64 {
    1.0 / (1.0 - rho)
}

/// The axis of reflectances from 0 to `last`.
fn reflectance_axis(last: f64) -> Axis {
    // Ticks are powers of ten, so what is left below 1 is short: digits beyond the sixth are rounding.
    let words = |place: f64| format!("{}", (1e6 * (1.0 - 1.0 / place)).round() / 1e6);
    Axis {
        label: "reflectance ρ, drawn at 1 / (1 − ρ)".to_owned(),
        scale: Scale::Log,
        range: [1.0, 1.15 * place(last)],
        ticks: Ticks::Words(words),
    }
}
