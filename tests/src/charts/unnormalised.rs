//! (b) What form factors that are not normalised do to each solver.
//!
//! Where a row of F sums to more than 1 / ρ a patch gives back more light than arrives. Once the spectral radius of
//! F ρ passes 1 there is no sum of bounces: (I − F ρ)⁻¹ still is a matrix, but its light is negative, and a sum that
//! stops early is a number like any other.

use plot::{Axis, Chart, Marker, Scale, Series, Stroke, Ticks};
use series::{Method, Params};

use super::{
    Claim, Effort, Figure, judge,
    kernels::{self, Kernel},
    place, reflectance_axis,
    room::{Room, closer_at_the_ends},
    solvers::{LAMP, solve},
    table::{Agreement, Cell, Column, Table},
};

/// First and last error on the axis.
const ERRORS: [f64; 2] = [1e-2, 300.0];

/// Solvers and bounces of a chart; the last is held against exact form factors, the others against the kernel's.
const RUNS: [(Method, Option<u32>); 6] = [
    (Method::PaperInverse, None),
    (Method::Cholesky, None),
    (Method::Neumann, Some(3)),
    (Method::Neumann, Some(8)),
    (Method::Neumann, Some(16)),
    (Method::Neumann, Some(64)),
];

/// What a method made of the light.
struct Point {
    /// "exact", or the kernel's name.
    factors: &'static str,
    method: Method,
    bounces: Option<u32>,
    rho: f64,
    /// RMS error relative to the truth; none if the solver refused.
    error: Option<f64>,
    /// Lowest irradiance relative to the true mean.
    lowest: Option<f64>,
    /// Share of patches with negative light.
    negative: Option<f64>,
}

/// A kernel in a room.
struct Trial {
    kernel: &'static str,
    points: Vec<Point>,
    patches: usize,
    largest_row: f64,
    radius: f64,
}

/// The centre kernel in a room that suits it, and the disc formula in one that does not.
pub fn figures(effort: Effort) -> [Figure; 2] {
    [centre(effort), disc(effort)]
}

/// Nearly square patches of nearly equal size.
fn cells() -> Room {
    let even = |length, count| closer_at_the_ends(length, count, 0.0);
    Room::new([&even(4.0, 6), &even(3.0, 5), &even(2.5, 4)])
}

/// Patches up to ten times longer than wide, as of boards, beams and panels.
fn boards() -> Room {
    Room::new([&[0.0, 1.5, 3.0, 5.0], &closer_at_the_ends(2.0, 8, 0.3), &closer_at_the_ends(2.4, 8, 0.3)])
}

fn reflectances(effort: Effort) -> &'static [f64] {
    match effort {
        Effort::Full => &[
            0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.83, 0.85, 0.87, 0.88, 0.89, 0.9, 0.91, 0.92, 0.925, 0.93,
            0.935, 0.94, 0.95, 0.96, 0.97, 0.98, 0.985, 0.99,
        ],
        Effort::Quick => &[0.3, 0.5, 0.8, 0.85, 0.87, 0.9, 0.95, 0.99],
    }
}

impl Trial {
    fn run(room: &Room, kernel: Kernel, name: &'static str, effort: Effort) -> Trial {
        let (exact, rough) = (room.form_factors(), kernels::form_factors(room, kernel));
        let direct = room.lit_from(LAMP);
        let mut points = Vec::new();
        for &rho in reflectances(effort) {
            let truth = judge::all_bounces(&exact, rho, &direct).light;
            let mean = room.mean(&truth);
            let runs = RUNS.iter().map(|run| (name, &rough, run)).chain([("exact", &exact, &RUNS[3])]);
            for (factors, f, &(method, bounces)) in runs {
                let solved = solve(room, f, rho, &direct, &Params { method, bounces, ..Params::default() });
                let light = solved.ok().map(|s| s.light);
                let lowest = |light: &Vec<f64>| light.iter().copied().fold(f64::INFINITY, f64::min) / mean;
                let negative =
                    |light: &Vec<f64>| light.iter().filter(|h| **h < 0.0).count() as f64 / light.len() as f64;
                points.push(Point {
                    factors,
                    method,
                    bounces,
                    rho,
                    error: light.as_ref().map(|light| room.error(light, &truth)),
                    lowest: light.as_ref().map(lowest),
                    negative: light.as_ref().map(negative),
                });
            }
        }
        let n = room.len();
        Trial {
            kernel: name,
            points,
            patches: n,
            largest_row: kernels::largest_row(&rough, n),
            radius: kernels::radius(&rough, n),
        }
    }

    /// The point of a method with the kernel's form factors.
    fn at(&self, method: Method, bounces: Option<u32>, rho: f64) -> &Point {
        let is = |p: &&Point| p.method == method && p.bounces == bounces && p.rho == rho && p.factors == self.kernel;
        self.points.iter().find(is).expect("a reflectance of both efforts")
    }

    fn error(&self, method: Method, bounces: Option<u32>, rho: f64) -> f64 {
        self.at(method, bounces, rho).error.unwrap_or(f64::NAN)
    }

    fn sum_error(&self, bounces: u32, rho: f64) -> f64 {
        self.error(Method::Neumann, Some(bounces), rho)
    }

    fn inverse_error(&self, rho: f64) -> f64 {
        self.error(Method::PaperInverse, None, rho)
    }

    /// Reflectance above which light grows from bounce to bounce.
    fn threshold(&self) -> f64 {
        1.0 / self.radius
    }

    /// Whether at these reflectances the inverse gives every patch negative light.
    fn all_negative(&self, reflectances: &[f64]) -> bool {
        reflectances.iter().all(|&rho| self.at(Method::PaperInverse, None, rho).negative == Some(1.0))
    }

    /// Whether Cholesky answered below the threshold and refused above it. It takes the mean of both directions,
    /// whose threshold is another one by a little: reflectances within 0.01 do not count.
    fn cholesky_is_right(&self) -> bool {
        let far = |p: &&Point| p.method == Method::Cholesky && (p.rho - self.threshold()).abs() > 0.01;
        self.points.iter().filter(far).all(|p| p.error.is_some() == (p.rho < self.threshold()))
    }

    fn table(&self) -> Table {
        let row = |p: &Point| -> Vec<Cell> {
            vec![
                p.factors.into(),
                p.method.name().into(),
                p.bounces.map(f64::from).into(),
                p.rho.into(),
                p.error.into(),
                p.lowest.into(),
                p.negative.into(),
            ]
        };
        Table {
            about: format!("Form factors of the {} formula, not normalised: error against reflectance.", self.kernel),
            columns: vec![
                Column { name: "form_factors", meaning: "the formula, or exact" },
                Column { name: "method", meaning: "as `allbounce series --method` calls it" },
                Column { name: "bounces", meaning: "of a truncated sum; empty for all" },
                Column { name: "rho", meaning: "reflectance of every patch" },
                Column {
                    name: "error",
                    meaning: "of indirect irradiance, RMS over the area, relative; empty: refused",
                },
                Column { name: "lowest", meaning: "lowest indirect irradiance, relative to the true mean" },
                Column { name: "negative", meaning: "share of patches with negative light" },
            ],
            keys: 4,
            rows: self.points.iter().map(row).collect(),
        }
    }

    fn chart(&self, title: &str, room: &str) -> Chart {
        let curve = |name: &str, colour: usize, stroke: Stroke, marker: Marker, of: &dyn Fn(&Point) -> bool| {
            let points = self.points.iter().filter(|p| of(p)).map(|p| [place(p.rho), p.error.unwrap_or(f64::NAN)]);
            Series { name: name.to_owned(), points: points.collect(), colour, stroke, marker }
        };
        let rough = |run: usize| move |p: &Point| (p.method, p.bounces) == RUNS[run] && p.factors != "exact";
        let dark = |p: &Point| p.negative.is_some_and(|share| share > 0.0);
        let series = vec![
            curve("paper-inverse", 1, Stroke::Solid, Marker::Circle, &rough(0)),
            curve("its light is negative", 4, Stroke::None, Marker::Cross, &|p| rough(0)(p) && dark(p)),
            curve("cholesky, until it refuses", 0, Stroke::Dashed, Marker::None, &rough(1)),
            curve("3 bounces", 2, Stroke::Solid, Marker::None, &rough(2)),
            curve("8 bounces", 5, Stroke::Solid, Marker::None, &rough(3)),
            curve("16 bounces", 3, Stroke::Solid, Marker::None, &rough(4)),
            curve("64 bounces", 6, Stroke::Solid, Marker::None, &rough(5)),
            curve("8 bounces, exact F", 4, Stroke::Dashed, Marker::None, &|p| p.factors == "exact"),
            Series {
                name: format!("no sum beyond ρ = {:.2}", self.threshold()),
                points: ERRORS.map(|error| [place(self.threshold()), error]).to_vec(),
                colour: 4,
                stroke: Stroke::Dotted,
                marker: Marker::None,
            },
        ];
        Chart {
            title: title.to_owned(),
            subtitle: format!(
                "{room} of {} patches; largest row sum {:.2}, spectral radius {:.3}",
                self.patches, self.largest_row, self.radius
            ),
            x: reflectance_axis(0.99),
            y: Axis {
                label: "error of indirect irradiance (RMS, relative)".to_owned(),
                scale: Scale::Log,
                range: ERRORS,
                ticks: Ticks::Percent,
            },
            series,
        }
    }
}

fn centre(effort: Effort) -> Figure {
    let trial = Trial::run(&cells(), Kernel::Centre, "centre", effort);
    let exact = trial.points.iter().find(|p| p.factors == "exact" && p.rho == 0.9);
    let same_bounces = exact.and_then(|p| p.error).unwrap_or(f64::NAN);
    Figure {
        name: "unnormalised-centre",
        setting: format!(
            "Form factors by the kernel cos θ cos θ' A / (π r²) from centre to centre, in a closed room (4 m × 3 m × 2.5 m) \
             of {} nearly square, nearly equal patches, which suit it. The truth is that of exact form factors. \
             `paper-inverse` takes F as it is, the others the mean of both directions.",
            trial.patches
        ),
        claims: vec![
            Claim::within(trial.largest_row, 1.2..=1.3, "The largest row of this F sums to more than 1.2."),
            Claim::within(trial.threshold(), 0.89..=0.90, "Light grows from bounce to bounce above ρ = 0.89."),
            Claim::at_least(trial.inverse_error(0.3), 0.15, "Even at ρ = 0.3 the light is more than 15 % off."),
            Claim::at_least(trial.inverse_error(0.85), 2.0, "At ρ = 0.85 it is more than 200 % off."),
            Claim::fact(
                trial.all_negative(&[0.9, 0.95, 0.99]),
                "From ρ = 0.9 on the inverse leaves no patch whose light is not negative.",
            ),
            Claim::fact(trial.cholesky_is_right(), "Cholesky solves below that and refuses above it."),
            Claim::at_most(
                trial.sum_error(8, 0.9),
                0.2,
                "A truncated sum hides it: 8 bounces at ρ = 0.9 are within 20 % of the truth.",
            ),
            Claim::at_least(
                same_bounces / trial.sum_error(8, 0.9),
                2.0,
                "The same 8 bounces with exact form factors are more than twice as far off, since light that F invents \
                 makes up for light that is left out.",
            ),
            Claim::at_least(trial.sum_error(64, 0.9), 5.0, "64 bounces are more than 500 % off."),
        ],
        table: trial.table(),
        agreement: Agreement { factor: 1.01, floor: 1e-9 },
        chart: trial.chart("Rows above 1: the kernel from centre to centre", "closed room"),
    }
}

fn disc(effort: Effort) -> Figure {
    let trial = Trial::run(&boards(), Kernel::Disc, "point-to-disc", effort);
    Figure {
        name: "unnormalised-disc",
        setting: format!(
            "Form factors by the point-to-disc formula, cos θ cos θ' A / (π r² + A), from centre to centre, in a closed \
             hall (5 m × 2 m × 2.4 m) of {} patches up to ten times longer than wide. The truth is that of exact form \
             factors. `paper-inverse` takes F as it is, the others the mean of both directions.",
            trial.patches
        ),
        claims: vec![
            Claim::within(trial.largest_row, 1.25..=1.30, "The largest row of this F sums to more than 1.25."),
            Claim::within(trial.threshold(), 0.925..=0.935, "Light grows from bounce to bounce above ρ = 0.93."),
            Claim::within(trial.inverse_error(0.85), 0.6..=0.8, "At ρ = 0.85 the inverse is 60–80 % off."),
            Claim::fact(
                trial.all_negative(&[0.95, 0.99]),
                "At ρ = 0.95 and 0.99 it leaves no patch whose light is not negative.",
            ),
            Claim::fact(
                trial.cholesky_is_right(),
                "Cholesky solves as long as there is an answer, and refuses beyond instead of returning numbers.",
            ),
            Claim::at_most(
                trial.sum_error(16, 0.95),
                0.25,
                "A truncated sum hides it: at ρ = 0.95 16 bounces are within 25 % of the truth.",
            ),
            Claim::at_least(
                trial.sum_error(64, 0.95),
                3.0,
                "64 bounces, which should be better, are more than 300 % off.",
            ),
        ],
        table: trial.table(),
        agreement: Agreement { factor: 1.01, floor: 1e-9 },
        chart: trial.chart("Rows above 1: the point-to-disc formula", "hall of boards"),
    }
}
