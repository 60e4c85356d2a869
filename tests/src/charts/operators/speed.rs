//! (h) Time of a product against the error of its light.

use plot::{Axis, Chart, Scale, Stroke, Ticks};

use super::{AGREEMENT, Record, curve, error_axis, others, table};
use crate::{
    bench::record::Row,
    charts::{Claim, Figure},
};

const SCENE: &str = "apartment";
const PATCHES: f64 = 5000.0;

pub fn figure(record: &Record) -> Figure {
    let time = |row: &Row| row.cpu1_ms;
    let mut series =
        vec![curve(record, SCENE, PATCHES, Stroke::Solid, time), curve(record, SCENE, 2600.0, Stroke::Dashed, time)];
    series.append(&mut others(record, SCENE, PATCHES, time));
    let n = record.near(SCENE, PATCHES).next().map_or(0, |row| row.n);
    Figure {
        name: "operator-speed",
        setting: format!(
            "Milliseconds of all bounces of a frame in three colours on one thread, and error of indirect light, \
             `{SCENE}`, n = {n}. Textures are made for GPUs; here a processor decodes them. F does not fit the caches and is \
             read from memory at {:.0} GB/s. Record {}.",
            bandwidth(record),
            record.name
        ),
        claims: claims(record),
        table: table(
            "Time and error of operators.",
            record.operators.iter().filter(|row| row.scene == SCENE && row.cpu1_ms.is_some()),
        ),
        agreement: AGREEMENT,
        chart: Chart {
            title: "Time of all bounces against error of light".to_owned(),
            subtitle: format!("{SCENE}, {n} patches, three colours, one thread of {}", record.name),
            x: Axis { label: "milliseconds".to_owned(), scale: Scale::Log, range: [0.05, 2e3], ticks: Ticks::Plain },
            y: error_axis(),
            series,
        },
    }
}

/// What the rival reads in a second on one thread, 10⁹ bytes.
fn bandwidth(record: &Record) -> f64 {
    let row = record.one(SCENE, PATCHES, "dense-f", "bounces=8");
    row.and_then(|row| Some(8.0 * row.bytes as f64 / (1e6 * row.cpu1_ms?))).unwrap_or(f64::NAN)
}

fn claims(record: &Record) -> Vec<Claim> {
    let time = |n: f64, format: &str, setting: &str| {
        record.one(SCENE, n, format, setting).and_then(|row| row.cpu1_ms).unwrap_or(f64::NAN)
    };
    let against_bounces = |n: f64| time(n, "dense-f", "bounces=8") / time(n, "hmatrix", "1%");
    vec![
        Claim::at_least(
            against_bounces(2600.0),
            30.0,
            "At about 2600 patches all bounces at 1 % take less than a thirtieth of eight bounces with F in f32.",
        ),
        Claim::at_least(against_bounces(PATCHES), 60.0, "At about 5000 patches they take less than a sixtieth."),
    ]
}
