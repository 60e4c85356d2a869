//! (c) How many bounces a truncated sum needs.
//!
//! In a closed room of one reflectance each bounce carries ρ times the flux of the one before, so that after k of
//! them the share ρ^k of all indirect light is missing: k = ln ε / ln ρ for a share ε.

use plot::{Axis, Chart, Marker, Scale, Series, Stroke, Ticks};
use series::Params;

use super::{
    Claim, Effort, Figure, judge, place, reflectance_axis,
    room::Room,
    solvers::{LAMP, solve},
    table::{Agreement, Cell, Column, Table},
};

/// Shares that may be missing.
const TAILS: [f64; 2] = [0.01, 0.001];

struct Point {
    rho: f64,
    tail: f64,
    /// ln ε / ln ρ.
    theory: f64,
    /// Fewest bounces with an error, RMS over the area, of at most ε.
    measured: u32,
    /// Doublings of `series --method doubling` for as many.
    doublings: u32,
}

fn reflectances(effort: Effort) -> &'static [f64] {
    match effort {
        Effort::Full => &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 0.98, 0.99, 0.995, 0.998, 0.999],
        Effort::Quick => &[0.1, 0.5, 0.8, 0.9, 0.95, 0.99],
    }
}

pub fn figure(effort: Effort) -> Figure {
    let room = Room::hall();
    let f = room.form_factors();
    let direct = room.lit_from(LAMP);
    let mut points = Vec::new();
    let mut doubling_agrees = true;
    for &rho in reflectances(effort) {
        let truth = judge::all_bounces(&f, rho, &direct).light;
        for (tail, measured) in TAILS.into_iter().zip(gathers(&room, &f, rho, &direct, &truth)) {
            let theory = (tail.ln() / rho.ln()).max(1.0);
            points.push(Point { rho, tail, theory, measured, doublings: doublings(measured) });
            doubling_agrees &= doubling_needs(&room, &f, rho, &direct, &truth, tail, measured);
        }
    }
    Figure {
        name: "bounces",
        setting: format!(
            "Fewest bounces that bring indirect light within 1 % and 0.1 % of all bounces (RMS over the area), for a point \
             lamp in the closed hall of {} patches with exact form factors, counted by plain gathering.",
            room.len()
        ),
        claims: claims(&points, doubling_agrees),
        table: table(&points),
        agreement: Agreement { factor: 1.0 + 1e-5, floor: 0.0 },
        chart: chart(&points),
    }
}

/// Gathers, H ← F ρ (H + H⁰), until the smallest tail is reached; the number of them at each tail.
fn gathers(room: &Room, f: &[f64], rho: f64, direct: &[f64], truth: &[f64]) -> [u32; 2] {
    let n = room.len();
    let mut light = vec![0.0; n];
    let mut count = 0;
    TAILS.map(|tail| {
        while count == 0 || room.error(&light, truth) > tail {
            let sent: Vec<f64> = light.iter().zip(direct).map(|(h, d)| rho * (h + d)).collect();
            light = f.chunks_exact(n).map(|row| row.iter().zip(&sent).map(|(f, s)| f * s).sum()).collect();
            count += 1;
        }
        count
    })
}

/// Steps of doubling from one bounce to `bounces`.
fn doublings(bounces: u32) -> u32 {
    bounces.next_power_of_two().ilog2()
}

/// Whether `series` needs just `count` bounces: its sum is within the tail, and that of one bounce less is not.
fn doubling_needs(room: &Room, f: &[f64], rho: f64, direct: &[f64], truth: &[f64], tail: f64, count: u32) -> bool {
    let error = |bounces| {
        let light = solve(room, f, rho, direct, &Params::first_bounces(bounces)).expect("a physical room").light;
        room.error(&light, truth)
    };
    let enough = error(count) <= tail * (1.0 + 1e-9);
    enough && (count == 1 || error(count - 1) > tail * (1.0 - 1e-9))
}

fn claims(points: &[Point], doubling_agrees: bool) -> Vec<Claim> {
    let difference = |p: &Point| (f64::from(p.measured) - p.theory).abs();
    let excess = |p: &Point| f64::from(p.measured) - p.theory.ceil();
    let at = |rho: f64| points.iter().find(|p| p.rho == rho && p.tail == 0.001);
    let measured = |rho| at(rho).map_or(f64::NAN, |p| f64::from(p.measured));
    let steps = |rho| at(rho).map_or(f64::NAN, |p| f64::from(p.doublings));
    let share = |p: &Point| difference(p) / p.theory.max(20.0);
    vec![
        Claim::at_most(
            points.iter().map(share).fold(0.0, f64::max),
            0.05,
            "Bounces follow ln ε / ln ρ within 5 %, or within one bounce where they are fewer than twenty.",
        ),
        Claim::at_most(
            points.iter().map(excess).fold(f64::NEG_INFINITY, f64::max),
            0.0,
            "They are never more than ln ε / ln ρ, rounded up.",
        ),
        Claim::within(measured(0.5), 10.0..=10.0, "0.1 % takes 10 bounces at ρ = 0.5."),
        Claim::within(measured(0.9), 65.0..=66.0, "It takes 66 at ρ = 0.9."),
        Claim::within(measured(0.99), 687.0..=688.0, "It takes 688 at ρ = 0.99."),
        Claim::within(steps(0.99), 10.0..=10.0, "Doubling sums as many in 10 steps."),
        Claim::fact(
            doubling_agrees,
            "`series --method doubling` needs just as many bounces as plain gathering, at every ρ of this chart.",
        ),
    ]
}

fn table(points: &[Point]) -> Table {
    let row = |p: &Point| -> Vec<Cell> {
        let (measured, doublings) = (f64::from(p.measured), f64::from(p.doublings));
        vec![p.rho.into(), p.tail.into(), p.theory.into(), measured.into(), doublings.into()]
    };
    Table {
        about: "Bounces that a truncated sum needs, closed hall, one lamp.".to_owned(),
        columns: vec![
            Column { name: "rho", meaning: "reflectance of every patch" },
            Column { name: "tail", meaning: "error that is allowed, RMS over the area relative to all bounces" },
            Column { name: "theory", meaning: "ln tail / ln rho, at least 1" },
            Column { name: "measured", meaning: "fewest bounces within the tail" },
            Column { name: "doublings", meaning: "steps of doubling that sum as many" },
        ],
        keys: 2,
        rows: points.iter().map(row).collect(),
    }
}

fn chart(points: &[Point]) -> Chart {
    let curve = |name: &str, tail: f64, colour: usize, line: (Stroke, Marker), y: &dyn Fn(&Point) -> f64| Series {
        name: name.to_owned(),
        points: points.iter().filter(|p| p.tail == tail).map(|p| [place(p.rho), y(p)]).collect(),
        colour,
        stroke: line.0,
        marker: line.1,
    };
    let (line, dots) = ((Stroke::Solid, Marker::None), (Stroke::None, Marker::Circle));
    Chart {
        title: "Bounces that a truncated sum needs".to_owned(),
        subtitle: "closed hall, 320 patches, one lamp; error RMS over the area".to_owned(),
        x: reflectance_axis(0.999),
        y: Axis { label: "bounces".to_owned(), scale: Scale::Log, range: [1.0, 1e4], ticks: Ticks::Plain },
        series: vec![
            curve("0.1 %: ln ε / ln ρ", 0.001, 0, line, &|p| p.theory),
            curve("0.1 %: measured", 0.001, 0, dots, &|p| f64::from(p.measured)),
            curve("1 %: ln ε / ln ρ", 0.01, 1, line, &|p| p.theory),
            curve("1 %: measured", 0.01, 1, dots, &|p| f64::from(p.measured)),
            curve("0.1 %: steps of doubling", 0.001, 2, (Stroke::Dashed, Marker::Square), &|p| f64::from(p.doublings)),
        ],
    }
}
