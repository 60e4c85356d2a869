//! (a) How far each solver is from the truth, against reflectance.

use plot::{Axis, Chart, Marker, Scale, Series, Stroke, Ticks};
use series::{ChannelReport, Method, Params, Precision, solve_raw};

use super::{
    Claim, Effort, Figure, judge, place, reflectance_axis, reflectances,
    room::Room,
    table::{Agreement, Cell, Column, Table},
};

/// Bounces after which nothing is left to sum at ρ = 0.9999: 0.9999^(2^18) is 4e-12.
const ALL: u32 = 1 << 18;
/// Where the lamp of the hall hangs, metres.
pub const LAMP: [f64; 3] = [1.3, 1.1, 2.1];

/// A solver as it is run here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    pub method: Method,
    pub bounces: Option<u32>,
    pub precision: Precision,
}

impl Run {
    pub fn params(&self) -> Params {
        Params { method: self.method, bounces: self.bounces, precision: self.precision, ..Params::default() }
    }

    /// As the legend calls it.
    pub fn name(&self) -> String {
        let bounces = match self.bounces {
            Some(ALL) => ", 2¹⁸ bounces".to_owned(),
            Some(bounces) => format!(", {bounces} bounces"),
            None => String::new(),
        };
        format!("{}{bounces}, {}", self.method.name(), precision(self.precision))
    }
}

pub fn precision(precision: Precision) -> &'static str {
    match precision {
        Precision::F32 => "f32",
        Precision::F64 => "f64",
    }
}

/// What a solver made of a room.
pub struct Solved {
    /// Indirect irradiance, W/m².
    pub light: Vec<f64>,
    /// Largest relative error of the furnace identity: emitters of 1 − ρ light every patch of a closed room with 1.
    pub furnace_error: f64,
    pub report: ChannelReport,
}

/// Light and report of a solver, or why it gave none.
pub fn solve(room: &Room, f: &[f64], rho: f64, direct: &[f64], params: &Params) -> Result<Solved, series::Error> {
    let n = room.len();
    let (k, report) = solve_raw(f, &vec![rho; n], &room.area, params)?;
    let root: Vec<f64> = room.area.iter().map(|a| a.sqrt()).collect();
    // H = A^{-1/2} K A^{1/2} ρ H⁰ (docs/design.md §2).
    let sent: Vec<f64> = (0..n).map(|j| root[j] * rho * direct[j]).collect();
    let row = |i: usize, x: &[f64]| k[i * n..][..n].iter().zip(x).map(|(k, x)| k * x).sum::<f64>() / root[i];
    let light = (0..n).map(|i| row(i, &sent)).collect();
    let glow: Vec<f64> = root.iter().map(|a| a * (1.0 - rho)).collect();
    let furnace_error = (0..n).map(|i| (row(i, &glow) - 1.0).abs()).fold(0.0, f64::max);
    Ok(Solved { light, furnace_error, report })
}

/// Methods and bounces of the chart; the place in this list is the colour.
const SOLVERS: [(Method, Option<u32>); 7] = [
    (Method::Cholesky, None),
    (Method::PaperInverse, None),
    (Method::Cg, None),
    (Method::Doubling, Some(ALL)),
    (Method::Neumann, Some(3)),
    (Method::Neumann, Some(8)),
    (Method::Neumann, Some(64)),
];

/// All of them in f64, then in f32, with their colours.
fn runs() -> Vec<(Run, usize)> {
    let in_precision = |precision| SOLVERS.map(|(method, bounces)| Run { method, bounces, precision });
    [Precision::F64, Precision::F32].into_iter().flat_map(|p| in_precision(p).into_iter().zip(0..)).collect()
}

struct Point {
    run: Run,
    rho: f64,
    error: f64,
    furnace: f64,
    /// How far the truth may be off at most.
    certain: f64,
}

pub fn figure(effort: Effort) -> Figure {
    let room = Room::hall();
    let f = room.form_factors();
    let direct = room.lit_from(LAMP);
    let mut points = Vec::new();
    for &rho in reflectances(effort) {
        let truth = judge::all_bounces(&f, rho, &direct);
        for (run, _) in runs() {
            let solved = solve(&room, &f, rho, &direct, &run.params()).expect("a physical room");
            let error = room.error(&solved.light, &truth.light);
            points.push(Point { run, rho, error, furnace: solved.furnace_error, certain: truth.bound });
        }
    }
    Figure {
        name: "solvers",
        setting: format!(
            "Indirect light of a point lamp in a closed hall (5 m × 3 m × 2.5 m, {} unequal patches, exact form factors, \
             one reflectance everywhere), by every solver of `allbounce series` in both precisions.",
            room.len()
        ),
        claims: claims(&points),
        table: table(&points),
        agreement: Agreement { factor: 30.0, floor: 1e-10 },
        chart: chart(&points),
    }
}

fn claims(points: &[Point]) -> Vec<Claim> {
    let worst = |of: &dyn Fn(&Point) -> bool, value: &dyn Fn(&Point) -> f64| {
        points.iter().filter(|p| of(p)).map(value).fold(0.0, f64::max)
    };
    let complete = |p: &Point| p.run.method != Method::Neumann;
    let f64s = |p: &Point| complete(p) && p.run.precision == Precision::F64;
    let f32s = |p: &Point| complete(p) && p.run.precision == Precision::F32;
    let tail = |bounces: u32, rho: f64| {
        let is = |p: &&Point| p.run.bounces == Some(bounces) && p.rho == rho && p.run.precision == Precision::F64;
        points.iter().find(is).map_or(f64::NAN, |p| p.error)
    };
    vec![
        Claim::at_most(
            points.iter().map(|p| p.certain).fold(0.0, f64::max),
            5e-12,
            "The light that all are held to is certain to 5e-12 of the brightest patch.",
        ),
        Claim::at_most(
            worst(&f64s, &|p| p.error),
            1e-10,
            "In f64 cholesky, paper-inverse, cg and doubling are within 1e-10 of it up to ρ = 0.9999.",
        ),
        Claim::at_most(worst(&f64s, &|p| p.furnace), 1e-10, "So is the furnace identity."),
        Claim::at_most(
            worst(&|p| f64s(p) && p.run.method == Method::PaperInverse, &|p| p.error),
            1e-11,
            "The inverse of I − F ρ is as stable as any, within 1e-11, while rows of F sum to 1.",
        ),
        Claim::at_most(worst(&f32s, &|p| p.error), 2e-3, "In f32 they stay within 0.2 %."),
        Claim::at_most(
            worst(&|p| f32s(p) && p.rho <= 0.9, &|p| p.error),
            2e-6,
            "In f32 and up to ρ = 0.9 they stay within 2e-6.",
        ),
        Claim::within(
            tail(3, 0.9),
            0.7..=0.75,
            "Three bounces, as in the paper, miss more than 70 % of the light at ρ = 0.9.",
        ),
        Claim::within(tail(64, 0.99), 0.5..=0.55, "64 bounces miss more than half of it at ρ = 0.99."),
    ]
}

fn table(points: &[Point]) -> Table {
    let row = |p: &Point| -> Vec<Cell> {
        vec![
            p.run.method.name().into(),
            p.run.bounces.map(f64::from).into(),
            precision(p.run.precision).into(),
            p.rho.into(),
            p.error.into(),
            p.furnace.into(),
            p.certain.into(),
        ]
    };
    Table {
        about: "Error of each solver against reflectance, closed hall, exact form factors.".to_owned(),
        columns: vec![
            Column { name: "method", meaning: "as `allbounce series --method` calls it" },
            Column { name: "bounces", meaning: "of a truncated sum; empty for all" },
            Column { name: "precision", meaning: "of the matrices" },
            Column { name: "rho", meaning: "reflectance of every patch" },
            Column {
                name: "error",
                meaning: "of indirect irradiance, RMS over the area relative to that of the truth",
            },
            Column { name: "furnace", meaning: "largest relative error of the furnace identity" },
            Column {
                name: "certain",
                meaning: "bound of the error of the truth itself, relative to its brightest patch",
            },
        ],
        keys: 4,
        rows: points.iter().map(row).collect(),
    }
}

fn chart(points: &[Point]) -> Chart {
    let curve = |(run, colour): (Run, usize)| {
        let truncated = run.method == Method::Neumann;
        let of: Vec<[f64; 2]> = points.iter().filter(|p| p.run == run).map(|p| [place(p.rho), p.error]).collect();
        let single = run.precision == Precision::F32;
        Series {
            name: run.name(),
            points: of,
            colour,
            stroke: if single { Stroke::Dashed } else { Stroke::Solid },
            marker: if truncated { Marker::Square } else { Marker::Circle },
        }
    };
    // In f32 a truncated sum has the error of its truncation: its curve would hide the other.
    let seen = |(run, _): &(Run, usize)| run.method != Method::Neumann || run.precision == Precision::F64;
    Chart {
        title: "Error of each solver against reflectance".to_owned(),
        subtitle: "closed hall, 320 patches, exact form factors; truth: refined solution with an error bound"
            .to_owned(),
        x: reflectance_axis(0.9999),
        y: Axis {
            label: "error of indirect irradiance (RMS, relative)".to_owned(),
            scale: Scale::Log,
            range: [1e-16, 3.0],
            ticks: Ticks::Plain,
        },
        series: runs().into_iter().filter(seen).map(curve).collect(),
    }
}
