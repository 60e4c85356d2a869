//! (g) How bytes grow with the number of patches.

use plot::{Axis, Chart, Marker, Scale, Series, Stroke, Ticks};

use super::{AGREEMENT, Record, table};
use crate::{
    bench::record::Row,
    charts::{Claim, Figure},
};

pub fn figure(record: &Record) -> Figure {
    let scenes = record.scenes();
    let exponents: Vec<f64> = scenes.iter().map(|scene| exponent(&points(record, scene, "hmatrix", "1%"))).collect();
    let markers = [Marker::Circle, Marker::Square, Marker::Triangle];
    let mut series: Vec<Series> = scenes
        .iter()
        .zip(&exponents)
        .enumerate()
        .map(|(k, (scene, exponent))| Series {
            name: format!("{scene}: n^{exponent:.2}"),
            points: points(record, scene, "hmatrix", "1%"),
            colour: [0, 2, 3][k % 3],
            stroke: Stroke::Solid,
            marker: markers[k % 3],
        })
        .collect();
    let first = scenes.first().copied().unwrap_or_default();
    for (format, setting, name, colour) in
        [("paper", "greedy", "paper (BC1)", 1), ("dense-f", "bounces=8", "F in f32: 4 n²", 4)]
    {
        let points = points(record, first, format, setting);
        series.push(Series { name: name.to_owned(), points, colour, stroke: Stroke::Dashed, marker: Marker::None });
    }
    let drawn = |row: &&Row| ["1%", "greedy"].contains(&&row.setting[..]) || row.format == "dense-f";
    Figure {
        name: "operator-scaling",
        setting: format!(
            "Bytes of the hierarchical operator at 1 % against the number of patches n, three colours; exponents are \
             fitted to the logarithms. The paper's format and F in f32 are those of {first}. Record {}.",
            record.name
        ),
        claims: claims(record),
        table: table("Bytes of operators against patches.", record.operators.iter().filter(drawn)),
        agreement: AGREEMENT,
        chart: Chart {
            title: "Bytes of the operator against patches".to_owned(),
            subtitle: "hierarchical blocks at 1 % error of light, all bounces, three colours".to_owned(),
            x: Axis { label: "patches n".to_owned(), scale: Scale::Log, range: [1e3, 1e4], ticks: Ticks::Plain },
            y: Axis { label: "bytes".to_owned(), scale: Scale::Log, range: [1e4, 1e9], ticks: Ticks::Plain },
            series,
        },
    }
}

fn points(record: &Record, scene: &str, format: &str, setting: &str) -> Vec<[f64; 2]> {
    let rows = record.operators.iter().filter(|r| r.scene == scene && r.format == format && r.setting == setting);
    rows.map(|row| [row.n as f64, row.bytes as f64]).collect()
}

/// Least squares on logarithms.
fn exponent(points: &[[f64; 2]]) -> f64 {
    let logs: Vec<[f64; 2]> = points.iter().map(|p| p.map(f64::ln)).collect();
    let mean = |a: usize| logs.iter().map(|p| p[a]).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let slope = logs.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>();
    slope / logs.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>()
}

/// Scenes and the exponents that theirs lie between.
const EXPONENTS: [(&str, f64, f64); 3] = [("apartment", 1.1, 1.3), ("cornell", 1.3, 1.6), ("sponza", 1.2, 1.4)];

fn claims(record: &Record) -> Vec<Claim> {
    let there = EXPONENTS.iter().filter(|(scene, ..)| record.scenes().contains(scene));
    let claim = |&(scene, least, most): &(&str, f64, f64)| {
        let exponent = exponent(&points(record, scene, "hmatrix", "1%"));
        let words = format!("Bytes of `{scene}` at 1 % grow as n to the power of {least} to {most}.");
        Claim::within(exponent, least..=most, &words)
    };
    there.map(claim).collect()
}
