//! (e) Condition number of what Cholesky factors, measured, against its bound.
//!
//! I − R W R has its eigenvalues between 1 − ρ and 1 + ρ for the largest reflectance ρ, since those of W are between
//! −1 and 1 (docs/design.md §2). The upper end is reached only where light goes to and fro between two plates.

use plot::{Axis, Chart, Marker, Scale, Series, Stroke, Ticks};
use series::{Params, solve_raw};

use super::{
    Claim, Effort, Figure,
    monte_carlo::Random,
    place, reflectance_axis, reflectances,
    room::{Room, closer_at_the_ends},
    table::{Agreement, Cell, Column, Table},
};

struct Point {
    room: &'static str,
    rho: f64,
    /// As `series` reports it.
    reported: f64,
    /// From the eigenvalues of W, where one reflectance makes them enough.
    eigenvalues: Option<f64>,
}

impl Point {
    fn bound(&self) -> f64 {
        (1.0 + self.rho) / (1.0 - self.rho)
    }
}

/// Names of the rooms, as in the legend.
const ROOMS: [&str; 3] = ["gap between plates", "hall", "painted hall"];

pub fn figure(effort: Effort) -> Figure {
    let gap = Room::new([&closer_at_the_ends(4.0, 8, 0.0), &closer_at_the_ends(4.0, 8, 0.0), &[0.0, 0.2]]);
    let mut points = Vec::new();
    for (name, room) in ROOMS.into_iter().zip([gap, Room::hall(), Room::hall()]) {
        let f = room.form_factors();
        let painted = name == ROOMS[2];
        let lowest = lowest_eigenvalue(&room, &f);
        for &rho in reflectances(effort) {
            let mut random = Random(1);
            let paint: Vec<f64> =
                room.area.iter().map(|_| if painted { rho * random.uniform() } else { rho }).collect();
            let (_, report) = solve_raw(&f, &paint, &room.area, &Params::default()).expect("a physical room");
            let eigenvalues = (!painted).then(|| (1.0 - rho * lowest) / (1.0 - rho));
            points.push(Point { room: name, rho, reported: report.condition, eigenvalues });
        }
    }
    Figure {
        name: "condition",
        setting: "Condition number of I − R W R, which Cholesky factors, as `series` reports it: the closed hall of 320 \
                  patches with one reflectance ρ; the same with reflectances at random between 0 and ρ; a closed gap of \
                  0.2 m between two plates of 4 m × 4 m. The bound is (1 + ρ) / (1 − ρ)."
            .to_owned(),
        claims: claims(&points),
        table: table(&points),
        agreement: Agreement { factor: 1.001, floor: 0.0 },
        chart: chart(&points),
    }
}

/// Lowest eigenvalue of W = A^{1/2} F A^{-1/2} of a closed room: power iteration on I − W, whose largest is 1 − it.
fn lowest_eigenvalue(room: &Room, f: &[f64]) -> f64 {
    let n = room.len();
    let root: Vec<f64> = room.area.iter().map(|a| a.sqrt()).collect();
    let mut random = Random(7);
    let mut x: Vec<f64> = (0..n).map(|_| random.uniform() - 0.5).collect();
    let mut largest = 0.0;
    for _ in 0..3000 {
        let scaled: Vec<f64> = x.iter().zip(&root).map(|(x, r)| x / r).collect();
        let row = |i: usize| root[i] * f[i * n..][..n].iter().zip(&scaled).map(|(f, s)| f * s).sum::<f64>();
        let y: Vec<f64> = (0..n).map(|i| x[i] - row(i)).collect();
        let length = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
        largest = length(&y) / length(&x);
        let scale = 1.0 / length(&y);
        x = y.iter().map(|y| y * scale).collect();
    }
    1.0 - largest
}

fn claims(points: &[Point]) -> Vec<Claim> {
    let most = |value: &dyn Fn(&Point) -> f64| points.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
    let at =
        |room: &str, rho: f64| points.iter().find(|p| p.room == room && p.rho == rho).map_or(f64::NAN, |p| p.reported);
    let plates = points.iter().filter(|p| p.room == ROOMS[0]).map(|p| p.reported / p.bound());
    vec![
        Claim::at_most(most(&|p| p.reported / p.bound()), 1.0 + 1e-9, "The bound is never passed."),
        Claim::at_least(
            plates.fold(f64::INFINITY, f64::min),
            0.95,
            "Light between two near plates comes within 5 % of it.",
        ),
        Claim::within(
            at(ROOMS[1], 0.99),
            140.0..=145.0,
            "In the hall the condition is about 142 at ρ = 0.99, where the bound is 199.",
        ),
        Claim::within(
            at(ROOMS[1], 0.9999),
            14_000.0..=14_500.0,
            "It is about 14,300 at ρ = 0.9999, so that 4 of 16 digits are lost.",
        ),
        Claim::at_most(
            at(ROOMS[2], 0.9999),
            3.0,
            "In the painted hall it stays below 3, whatever the largest reflectance.",
        ),
        Claim::at_most(
            most(&|p| p.eigenvalues.map_or(0.0, |e| (p.reported / e - 1.0).abs())),
            1e-6,
            "What `series` reports agrees within 1e-6 with the extreme eigenvalues of W.",
        ),
    ]
}

fn table(points: &[Point]) -> Table {
    let row = |p: &Point| -> Vec<Cell> {
        vec![p.room.into(), p.rho.into(), p.reported.into(), p.eigenvalues.into(), p.bound().into()]
    };
    Table {
        about: "Condition number of I - R W R against reflectance.".to_owned(),
        columns: vec![
            Column { name: "room", meaning: "closed, exact form factors" },
            Column { name: "rho", meaning: "reflectance of every patch; of the painted hall, the largest" },
            Column { name: "reported", meaning: "condition number as `series` reports it" },
            Column {
                name: "eigenvalues",
                meaning: "the same from the extreme eigenvalues of W; empty for unequal reflectances",
            },
            Column { name: "bound", meaning: "(1 + rho) / (1 - rho)" },
        ],
        keys: 2,
        rows: points.iter().map(row).collect(),
    }
}

fn chart(points: &[Point]) -> Chart {
    let curve = |room: usize, marker: Marker| Series {
        name: ROOMS[room].to_owned(),
        points: points.iter().filter(|p| p.room == ROOMS[room]).map(|p| [place(p.rho), p.reported]).collect(),
        colour: room,
        stroke: Stroke::Solid,
        marker,
    };
    let bound = Series {
        name: "bound (1 + ρ) / (1 − ρ)".to_owned(),
        points: points.iter().filter(|p| p.room == ROOMS[1]).map(|p| [place(p.rho), p.bound()]).collect(),
        colour: 4,
        stroke: Stroke::Dotted,
        marker: Marker::None,
    };
    Chart {
        title: "Condition of the system that Cholesky factors".to_owned(),
        subtitle: "I − R W R, closed rooms, exact form factors".to_owned(),
        x: reflectance_axis(0.9999),
        y: Axis { label: "condition number".to_owned(), scale: Scale::Log, range: [1.0, 3e4], ticks: Ticks::Plain },
        series: vec![bound, curve(0, Marker::Circle), curve(1, Marker::Square), curve(2, Marker::Triangle)],
    }
}
