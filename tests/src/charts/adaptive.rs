//! (i) Adaptive against uniform patches: error of light against their number.
//!
//! Drawn from a committed record, as the charts of `operators`.

use std::path::Path;

use plot::{Axis, Chart, Marker, Scale, Series, Stroke, Ticks};

use super::{
    Claim, Figure,
    table::{Agreement, Cell, Column, Table},
};
use crate::bench::{adaptive::Row, record::read};

/// Numbers that are drawn as they were written.
const AGREEMENT: Agreement = Agreement { factor: 1.0001, floor: 0.0 };

/// Scenes and how many times fewer elements of the matrix adaptive patches are claimed to need, at least, over the
/// numbers of patches that were tried, on average.
const FEWER: [(&str, f64); 3] = [("apartment", 1.8), ("cornell", 1.1), ("sponza", 2.0)];

/// Of the record that `bench_adaptive` wrote to a file.
///
/// # Panics
///
/// If it is not there or has other columns: the bench and its charts are of one version.
pub fn figure(record: &Path) -> Figure {
    let rows: Vec<Row> = read(record).expect("a record of patches");
    let mut scenes: Vec<&str> = rows.iter().map(|row| &row.scene[..]).collect();
    scenes.dedup();
    let curve = |(k, scene): (usize, &&str)| {
        let colour = [2, 0, 3][k % 3];
        ["uniform", "adaptive"].map(|kind| Series {
            name: format!("{scene}, {kind}"),
            points: points(&rows, scene, kind),
            colour,
            stroke: if kind == "adaptive" { Stroke::Solid } else { Stroke::Dashed },
            marker: if kind == "adaptive" { Marker::Circle } else { Marker::None },
        })
    };
    let claims = FEWER.iter().map(|&(scene, times)| {
        let words = format!("In `{scene}` adaptive patches need at least {times} times fewer elements at equal error.");
        Claim::at_least(fewer(&rows, scene), times, &words)
    });
    Figure {
        name: "adaptive",
        setting: "Error of irradiance that is constant on each patch, at 4000 points, against light gathered from uniform \
                  patches of about 8000; geometric mean over lights that nobody saw who made the patches: those of lights \
                  files and 32 lamps hung at random, with shadows. The table also has what points gather. How many times \
                  fewer elements is the square of how many times fewer patches at equal error, by interpolation between \
                  uniform numbers, geometric mean over the adaptive ones."
            .to_owned(),
        claims: claims.collect(),
        table: table(&rows),
        agreement: AGREEMENT,
        chart: Chart {
            title: "Error of light against patches".to_owned(),
            subtitle: "uniform voxels and patches made where light changes; constant on each patch".to_owned(),
            x: Axis { label: "patches n".to_owned(), scale: Scale::Log, range: [5e2, 1e4], ticks: Ticks::Plain },
            y: Axis { label: "error".to_owned(), scale: Scale::Log, range: [0.02, 0.5], ticks: Ticks::Percent },
            series: scenes.iter().enumerate().flat_map(curve).collect(),
        },
    }
}

/// Patches and the geometric mean of the error over all lights, by increasing number.
fn points(rows: &[Row], scene: &str, kind: &str) -> Vec<[f64; 2]> {
    let mut own: Vec<&Row> = rows.iter().filter(|r| r.scene == scene && r.kind == kind).collect();
    own.sort_by_key(|r| r.n);
    let mean = |same: &[&Row]| {
        let count = same.iter().map(|r| r.count as f64).sum::<f64>();
        let logs = same.iter().map(|r| r.count as f64 * r.constant.ln()).sum::<f64>();
        [same[0].n as f64, (logs / count).exp()]
    };
    own.chunk_by(|a, b| a.n == b.n).map(mean).collect()
}

/// How many times fewer elements.
fn fewer(rows: &[Row], scene: &str) -> f64 {
    let uniform: Vec<[f64; 2]> = points(rows, scene, "uniform").iter().map(|p| p.map(f64::ln)).collect();
    let adaptive = points(rows, scene, "adaptive");
    let ratios: Vec<f64> = adaptive.iter().filter_map(|&[n, e]| Some(2.0 * (at(&uniform, e.ln())? - n.ln()))).collect();
    (ratios.iter().sum::<f64>() / ratios.len() as f64).exp()
}

/// Logarithm of the uniform number of patches that has this logarithm of the error, if it lies between two that were
/// tried.
fn at(uniform: &[[f64; 2]], error: f64) -> Option<f64> {
    uniform.windows(2).find_map(|w| {
        let [[n, e], [m, f]] = [w[0], w[1]];
        (f..=e).contains(&error).then(|| n + (e - error) / (e - f) * (m - n))
    })
}

fn table(rows: &[Row]) -> Table {
    let column = |name, meaning| Column { name, meaning };
    Table {
        about: "Error of light of uniform and adaptive patches.".to_owned(),
        columns: vec![
            column("scene", "what was lit"),
            column("kind", "how patches were made"),
            column("lights", "those of lights files, or lamps hung at random"),
            column("n", "patches"),
            column("constant", "error of irradiance that is constant on each patch, a fraction"),
            column("gathered", "error of what points gather from all patches that they see, a fraction"),
            column("commit", "of the program"),
        ],
        keys: 4,
        rows: rows
            .iter()
            .map(|r| {
                let word = |w: &str| Cell::Word(w.to_owned());
                let numbers = [r.n as f64, r.constant, r.gathered].map(Cell::Number);
                let mut cells = vec![word(&r.scene), word(&r.kind), word(&r.lights)];
                cells.extend(numbers);
                cells.push(word(&r.commit));
                cells
            })
            .collect(),
    }
}
