//! (f) Bytes of every operator against the error of its light, a chart a scene.

use plot::{Axis, Chart, Scale, Stroke, Ticks};

use super::{AGREEMENT, Record, curve, error_axis, others, table};
use crate::{
    bench::{contest::AS_PAPER, record::Row},
    charts::{Claim, Figure},
};

/// Patches at which all operators are drawn.
const PATCHES: f64 = 5000.0;
/// What is drawn of a scene, and what is claimed.
struct Shown {
    scene: &'static str,
    /// Of the chart.
    name: &'static str,
    /// Bytes over n² that hierarchical blocks take at 1 %, at most.
    size: f64,
    /// How many times smaller than the paper's format they are at its error, at least.
    gain: f64,
}

/// A scene that is not in the record has no chart.
const SHOWN: [Shown; 3] = [
    Shown { scene: "cornell", name: "operator-rate-cornell", size: 0.05, gain: 14.0 },
    Shown { scene: "apartment", name: "operator-rate-apartment", size: 0.025, gain: 25.0 },
    Shown { scene: "sponza", name: "operator-rate-sponza", size: 0.05, gain: 10.0 },
];

pub fn figures(record: &Record) -> Vec<Figure> {
    SHOWN.iter().filter(|shown| record.scenes().contains(&shown.scene)).map(|shown| figure(record, shown)).collect()
}

fn figure(record: &Record, shown: &Shown) -> Figure {
    let Shown { scene, name, .. } = *shown;
    let size = |row: &Row| Some(row.bytes_per_n2);
    let mut series = vec![
        curve(record, scene, PATCHES, Stroke::Solid, size),
        curve(record, scene, 2600.0, Stroke::Dashed, size),
        curve(record, scene, 1300.0, Stroke::Dotted, size),
    ];
    series.append(&mut others(record, scene, PATCHES, size));
    let n = record.near(scene, PATCHES).next().map_or(0, |row| row.n);
    Figure {
        name,
        setting: format!(
            "Bytes over n² and error of indirect light of every operator of `{scene}`, n = {n}; the hierarchical one \
             at fewer patches, too. Lower left is better. K in f32 is exact to seven digits and lies below. Record {}.",
            record.name
        ),
        claims: claims(record, shown),
        table: table(
            &format!("Bytes and errors of operators, {scene}."),
            record.operators.iter().filter(|row| row.scene == scene),
        ),
        agreement: AGREEMENT,
        chart: Chart {
            title: format!("Bytes against error of light: {scene}"),
            subtitle: format!("{n} patches, all bounces, three colours; 20 lights that packing did not see"),
            x: Axis { label: "bytes / n²".to_owned(), scale: Scale::Log, range: [3e-3, 20.0], ticks: Ticks::Plain },
            y: error_axis(),
            series,
        },
    }
}

fn claims(record: &Record, shown: &Shown) -> Vec<Claim> {
    let Shown { scene, size: limit, gain, .. } = *shown;
    let get = |format: &str, setting: &str, value: fn(&Row) -> Option<f64>| {
        record.one(scene, PATCHES, format, setting).and_then(value).unwrap_or(f64::NAN)
    };
    let size = |format: &str, setting: &str| get(format, setting, |row| Some(row.bytes_per_n2));
    let l2 = |format: &str, setting: &str| get(format, setting, |row| row.l2);
    vec![
        Claim::at_most(
            size("hmatrix", "1%"),
            limit,
            &format!("Hierarchical blocks at 1 % take less than {limit} bytes / n²."),
        ),
        Claim::at_least(
            size("paper", "greedy") / size("hmatrix", AS_PAPER),
            gain,
            &format!(
                "Packed to the error of the paper's format in its better order, they are more than {gain} times smaller."
            ),
        ),
        Claim::at_most(
            l2("hmatrix", AS_PAPER) / l2("paper", "greedy").min(l2("paper", "normal-hilbert")),
            1.2,
            "Their error under these lights is then at most 1.2 times its.",
        ),
        Claim::at_most(
            l2("bc4-sqrt", "normal-hilbert") / l2("paper", "normal-hilbert"),
            1.0,
            "In one order of patches `bc4-sqrt` has less error than the paper's format,",
        ),
        Claim::at_most(
            size("bc4-sqrt", "normal-hilbert") / size("paper", "greedy"),
            0.5,
            "at less than half of its bytes.",
        ),
    ]
}
