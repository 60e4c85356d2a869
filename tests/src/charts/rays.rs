//! (d) Error of form factors against rays per patch: our gather, plain Monte Carlo, and 1 / √N.
//!
//! Plain Monte Carlo falls as N^(−1/2). A Sobol sequence of d numbers that counts hits and misses, which jump at the
//! edges of what is hit, can fall as N^(−1/2 − 1/2d): N^(−0.625) for the four numbers of a ray.
//! Source of the exponent: Z. He, X. Wang, "On the convergence rate of randomized quasi-Monte Carlo for discontinuous
//! functions", SIAM J. Numer. Anal. 53(5), 2015.

use formfactor::{Params, form_factors};
use plot::{Axis, Chart, Marker, Scale, Series, Stroke, Ticks};
use radfile::Quiet;

use super::{
    Claim, Effort, Figure, judge,
    monte_carlo::{closed_form_factors, exchange_areas},
    rectangles::{Rectangle, exchange_area},
    room::{Room, closer_at_the_ends, scene},
    table::{Agreement, Cell, Column, Table},
};

/// Error of both samplers with one number of rays.
struct Point {
    case: &'static str,
    rays: u32,
    gather: f64,
    monte_carlo: f64,
}

fn ray_counts(effort: Effort, last: u32) -> Vec<u32> {
    match effort {
        Effort::Full => (6..=16).map(|power| 1 << power).collect(),
        Effort::Quick => (6..=last).step_by(2).map(|power| 1 << power).collect(),
    }
}

/// Seeds that no other number of rays has, so that errors along a curve are independent.
fn seeds(rays: u32, count: u32) -> impl Iterator<Item = u32> {
    (0..count).map(move |k| rays.wrapping_mul(1_000_003).wrapping_add(k))
}

/// Form factors by our stage, row = receiver, row-major.
fn gathered(rectangles: &[Rectangle], rays: u32, seed: u32) -> Vec<f64> {
    let (mesh, patches) = scene(rectangles);
    let (factors, _) = form_factors(&mesh, &patches, &Params::rays(rays, seed), &Quiet).expect("patches and rays");
    factors.values.iter().map(|&f| f64::from(f)).collect()
}

fn rms(errors: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = errors.fold((0.0, 0), |(sum, count), e| (sum + e * e, count + 1));
    (sum / f64::from(count)).sqrt()
}

/// Two unit squares against Howell's closed forms.
pub fn squares(effort: Effort) -> Figure {
    const SEEDS: u32 = 64;
    let wall = |axis, plane: f64, facing| {
        let mut corners = [[0.0; 3], [1.0; 3]];
        (corners[0][axis], corners[1][axis]) = (plane, plane);
        Rectangle { corners, axis, facing }
    };
    let floor = wall(2, 0.0, 1.0);
    let cases = [("opposed", [floor, wall(2, 1.0, -1.0)]), ("perpendicular", [floor, wall(0, 0.0, 1.0)])];
    let mut points = Vec::new();
    for (case, pair) in cases {
        // Areas are 1, so exchange area and form factor are one number.
        let exact = exchange_area(&pair[0], &pair[1]);
        for rays in ray_counts(effort, 16) {
            points.push(Point {
                case,
                rays,
                gather: rms(seeds(rays, SEEDS).map(|seed| gathered(&pair, rays, seed)[1] / exact - 1.0)),
                monte_carlo: rms(
                    seeds(rays, SEEDS).map(|seed| exchange_areas(&pair, rays, seed.into())[1] / exact - 1.0)
                ),
            });
        }
    }
    let (ours, plain) = (slopes(&points, |p| p.gather), slopes(&points, |p| p.monte_carlo));
    let last = |value: fn(&Point) -> f64| points.iter().filter(|p| p.rays == 1 << 16).map(value);
    let worst = last(|p| p.gather).fold(0.0, f64::max);
    let gain = last(|p| p.monte_carlo / p.gather).fold(f64::INFINITY, f64::min);
    let least = |slopes: &[f64]| slopes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Figure {
        name: "rays-squares",
        setting: format!(
            "Form factor of two unit squares, opposed at distance 1 and perpendicular with a common edge, by `formfactor` \
             and by plain Monte Carlo, both from both ends; relative error against the closed forms (0.199825, 0.200044), \
             RMS over {SEEDS} seeds."
        ),
        claims: vec![
            Claim::at_most(least(&ours), -0.58, "The error of our gather falls faster than N^−0.58."),
            Claim::within(least(&plain), -0.53..=-0.47, "That of plain Monte Carlo falls as N^−0.5."),
            Claim::at_most(
                0.2 * worst,
                5e-4,
                "At 65,536 rays both form factors, which are about 0.2, are within 5e-4 of the closed forms.",
            ),
            Claim::at_least(gain, 2.5, "Plain Monte Carlo is more than 2.5 times as far off."),
        ],
        table: table(
            "Form factor of two unit squares: relative error, RMS over seeds, against rays per patch.",
            &points,
        ),
        agreement: Agreement { factor: 1.05, floor: 1e-7 },
        chart: chart(
            "Form factors of unit squares: error against rays",
            format!("RMS over {SEEDS} seeds, against closed forms"),
            "error of the form factor (RMS, relative)",
            &points,
            [5e-4, 0.5],
        ),
    }
}

/// All light of a small room against exact form factors.
pub fn room(effort: Effort) -> Figure {
    const RHO: f64 = 0.7;
    const SEEDS: u32 = 4;
    let room = Room::new([
        &closer_at_the_ends(3.0, 4, 0.3),
        &closer_at_the_ends(2.4, 4, 0.3),
        &closer_at_the_ends(2.6, 4, 0.3),
    ]);
    let exact = room.form_factors();
    let lamps = [[1.5, 1.2, 2.2], [0.4, 0.5, 1.3], [2.6, 2.0, 0.4], [0.5, 1.9, 2.1], [2.4, 0.4, 1.9], [1.4, 1.3, 0.6]];
    let direct: Vec<Vec<f64>> = lamps.iter().map(|&lamp| room.lit_from(lamp)).collect();
    let light = |f: &[f64], direct: &[f64]| judge::all_bounces(f, RHO, direct).light;
    let truth: Vec<Vec<f64>> = direct.iter().map(|d| light(&exact, d)).collect();
    let error = |f: Vec<f64>| rms(direct.iter().zip(&truth).map(|(d, t)| room.error(&light(&f, d), t)));
    let points: Vec<Point> = ray_counts(effort, 12)
        .into_iter()
        .map(|rays| Point {
            case: "room",
            rays,
            gather: rms(seeds(rays, SEEDS).map(|seed| error(gathered(&room.patches, rays, seed)))),
            monte_carlo: rms(seeds(rays, SEEDS).map(|seed| error(closed_form_factors(&room, rays, seed.into())))),
        })
        .collect();
    let [ours, plain] = [slopes(&points, |p| p.gather)[0], slopes(&points, |p| p.monte_carlo)[0]];
    let [ours_for_one, plain_for_one] = [rays_for(&points, |p| p.gather), rays_for(&points, |p| p.monte_carlo)];
    Figure {
        name: "rays-room",
        setting: format!(
            "Indirect light of {} lamps in a closed room (3 m × 2.4 m × 2.6 m, {} unequal patches, ρ = {RHO}), all bounces, \
             with form factors by `formfactor` and by plain Monte Carlo, both made reciprocal and scaled to rows of 1; \
             error against exact form factors, RMS over area, lamps and {SEEDS} seeds.",
            lamps.len(),
            room.len()
        ),
        claims: vec![
            Claim::at_most(ours, -0.58, "The error falls faster than N^−0.58 with our gather."),
            Claim::within(plain, -0.53..=-0.47, "It falls as N^−0.5 with plain Monte Carlo."),
            Claim::at_most(ours_for_one, 640.0, "1 % of the final light takes fewer than 640 rays per patch."),
            Claim::at_least(plain_for_one / ours_for_one, 2.5, "Plain Monte Carlo takes more than 2.5 times as many."),
        ],
        table: table("Indirect light of a small room: relative error against rays per patch.", &points),
        agreement: Agreement { factor: 1.05, floor: 1e-7 },
        chart: chart(
            "All light of a small room: error against rays",
            format!("{} patches, ρ = {RHO}, exact form factors as truth", room.len()),
            "error of indirect irradiance (RMS, relative)",
            &points,
            [3e-4, 0.3],
        ),
    }
}

/// Least-squares slope of log error over log rays, of each case.
fn slopes(points: &[Point], error: fn(&Point) -> f64) -> Vec<f64> {
    points.chunk_by(|a, b| a.case == b.case).map(|case| line(case, error)[1]).collect()
}

/// Rays at which the fitted line of a single case passes 1 %.
fn rays_for(points: &[Point], error: fn(&Point) -> f64) -> f64 {
    let [start, slope] = line(points, error);
    ((0.01_f64.ln() - start) / slope).exp()
}

/// ln error ≈ start + slope ln rays.
fn line(points: &[Point], error: fn(&Point) -> f64) -> [f64; 2] {
    let logs: Vec<[f64; 2]> = points.iter().map(|p| [f64::from(p.rays).ln(), error(p).ln()]).collect();
    let mean = |axis: usize| logs.iter().map(|l| l[axis]).sum::<f64>() / logs.len() as f64;
    let [x, y] = [mean(0), mean(1)];
    let slope = logs.iter().map(|l| (l[0] - x) * (l[1] - y)).sum::<f64>()
        / logs.iter().map(|l| (l[0] - x).powi(2)).sum::<f64>();
    [y - slope * x, slope]
}

fn table(about: &str, points: &[Point]) -> Table {
    let row = |p: &Point| -> Vec<Cell> {
        vec![p.case.into(), f64::from(p.rays).into(), p.gather.into(), p.monte_carlo.into()]
    };
    Table {
        about: about.to_owned(),
        columns: vec![
            Column { name: "case", meaning: "what is measured" },
            Column { name: "rays", meaning: "per patch" },
            Column { name: "gather", meaning: "relative error with `formfactor` (Sobol)" },
            Column { name: "monte_carlo", meaning: "relative error with independent random rays" },
        ],
        keys: 2,
        rows: points.iter().map(row).collect(),
    }
}

fn chart(title: &str, subtitle: String, label: &str, points: &[Point], range: [f64; 2]) -> Chart {
    let mut series = Vec::new();
    let markers = [Marker::Circle, Marker::Square];
    let cases: Vec<&[Point]> = points.chunk_by(|a, b| a.case == b.case).collect();
    for (sampler, (name, error)) in
        [("plain Monte Carlo", (|p| p.monte_carlo) as fn(&Point) -> f64), ("our gather", |p| p.gather)]
            .into_iter()
            .enumerate()
    {
        for (case, marker) in cases.iter().zip(markers) {
            let of = if cases.len() > 1 { format!(", {}", case[0].case) } else { String::new() };
            series.push(Series {
                name: format!("{name}{of}: slope {:.2}", line(case, error)[1]).replace('-', "−"),
                points: case.iter().map(|p| [f64::from(p.rays), error(p)]).collect(),
                colour: 1 - sampler,
                stroke: if marker == Marker::Circle { Stroke::Solid } else { Stroke::Dashed },
                marker,
            });
        }
    }
    // Through the middle of plain Monte Carlo's points.
    let height = points.iter().map(|p| (p.monte_carlo * f64::from(p.rays).sqrt()).ln()).sum::<f64>();
    let root = |rays: f64| (height / points.len() as f64).exp() / rays.sqrt();
    series.push(Series {
        name: "1 / √N: slope −0.50".to_owned(),
        points: [64.0, 65536.0].map(|rays| [rays, root(rays)]).to_vec(),
        colour: 4,
        stroke: Stroke::Dotted,
        marker: Marker::None,
    });
    Chart {
        title: title.to_owned(),
        subtitle,
        x: Axis { label: "rays per patch N".to_owned(), scale: Scale::Log, range: [50.0, 8e4], ticks: Ticks::Plain },
        y: Axis { label: label.to_owned(), scale: Scale::Log, range, ticks: Ticks::Percent },
        series,
    }
}
