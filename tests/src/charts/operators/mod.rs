//! Charts of the operators that `make bench` measured: bytes, light and time of each.
//!
//! They are drawn from a committed record, not measured again, and their claims are about that record.
//! `bench/record/shown` names it, as `machine/date`; `make bench` writes it.

pub mod orders;
pub mod rate;
pub mod scaling;
pub mod speed;

use plot::{Axis, Marker, Scale, Series, Stroke, Ticks};

use super::{
    Figure,
    table::{Agreement, Cell, Column, Table},
};
use crate::{
    bench::{
        orders as bench_orders,
        record::{Row, read},
    },
    root,
};

/// What was measured.
pub struct Record {
    /// `machine/date`.
    pub name: String,
    pub operators: Vec<Row>,
    pub orders: Vec<bench_orders::Row>,
}

/// Numbers that are drawn as they were written.
const AGREEMENT: Agreement = Agreement { factor: 1.0001, floor: 0.0 };

impl Record {
    /// The record that is shown.
    ///
    /// # Panics
    ///
    /// If it is not there or has other columns: the bench and its charts are of one version.
    pub fn shown() -> Record {
        let folder = root().join("bench/record");
        let name = std::fs::read_to_string(folder.join("shown")).expect("bench/record/shown; run `make bench`");
        let name = name.trim().to_owned();
        let path = |subject: &str| folder.join(format!("{name}-{subject}.csv"));
        let operators = read(&path("operators")).expect("a record of operators");
        let orders = read(&path("orders")).expect("a record of orders");
        Record { name, operators, orders }
    }

    /// Scenes in the order of the record.
    pub fn scenes(&self) -> Vec<&str> {
        let mut scenes: Vec<&str> = self.operators.iter().map(|row| &row.scene[..]).collect();
        scenes.dedup();
        scenes
    }

    /// Rows of a scene at the number of patches nearest to `n`.
    pub fn near<'a>(&'a self, scene: &'a str, n: f64) -> impl Iterator<Item = &'a Row> {
        let of = move |row: &&Row| row.scene == scene;
        let off = move |row: &Row| (row.n as f64 / n).ln().abs();
        let nearest = self.operators.iter().filter(of).min_by(|a, b| off(a).total_cmp(&off(b))).map(|row| row.n);
        self.operators.iter().filter(of).filter(move |row| Some(row.n) == nearest)
    }

    /// One of them.
    pub fn one<'a>(&'a self, scene: &'a str, n: f64, format: &str, setting: &str) -> Option<&'a Row> {
        self.near(scene, n).find(|row| row.format == format && row.setting == setting)
    }
}

/// All figures of a record.
pub fn figures(record: &Record) -> Vec<Figure> {
    let mut figures = rate::figures(record);
    figures.extend([scaling::figure(record), speed::figure(record), orders::figure(record)]);
    figures
}

/// Everything but the hierarchical operator of all bounces: its name in legends, colour and marker.
const OTHERS: [(&str, &str, &str, usize, Marker); 9] = [
    ("dense-f", "bounces=8", "F in f32, 8 bounces", 4, Marker::Square),
    ("dense-s", "f32", "K in f32", 3, Marker::Square),
    ("dense-s", "f16", "K in f16", 3, Marker::Triangle),
    ("dense-s", "u8-log", "K in u8, logarithm", 3, Marker::Cross),
    ("paper", "greedy", "paper (BC1), its order", 1, Marker::Circle),
    ("paper", "normal-hilbert", "paper (BC1), our order", 1, Marker::Triangle),
    ("bc4-log", "normal-hilbert", "bc4-log", 2, Marker::Triangle),
    ("bc4-sqrt", "normal-hilbert", "bc4-sqrt", 2, Marker::Circle),
    ("g-cg", "1%", "one bounce and a solve, 1 %", 6, Marker::Circle),
];

/// Settings of the hierarchical operator that make its curve.
const CURVE: [&str; 3] = ["3%", "1%", "0.3%"];

/// A point of each of [`OTHERS`] at some number of patches; `x` is its horizontal value.
fn others(record: &Record, scene: &str, n: f64, x: impl Fn(&Row) -> Option<f64>) -> Vec<Series> {
    let series = |(format, setting, name, colour, marker): (&str, &str, &str, usize, Marker)| {
        let row = record.one(scene, n, format, setting)?;
        let l2 = row.l2.filter(|l2| *l2 >= LEAST)?;
        let points = vec![[x(row)?, l2]];
        Some(Series { name: name.to_owned(), points, colour, stroke: Stroke::None, marker })
    };
    OTHERS.into_iter().filter_map(series).collect()
}

/// The curve of the hierarchical operator at some number of patches.
fn curve(record: &Record, scene: &str, n: f64, stroke: Stroke, x: impl Fn(&Row) -> Option<f64>) -> Series {
    let rows = CURVE.iter().filter_map(|setting| record.one(scene, n, "hmatrix", setting));
    let points: Vec<[f64; 2]> = rows.filter_map(|row| Some([x(row)?, row.l2?])).collect();
    let patches = record.near(scene, n).next().map_or(0, |row| row.n);
    let name = format!("hierarchical, {patches} patches");
    Series { name, points, colour: 0, stroke, marker: Marker::Circle }
}

/// Least error that is drawn: K in f32 has less.
const LEAST: f64 = 2e-5;

/// The axis of errors of light.
fn error_axis() -> Axis {
    Axis {
        label: "error of indirect light (L2, mean over 20 lights)".to_owned(),
        scale: Scale::Log,
        range: [LEAST, 0.3],
        ticks: Ticks::Percent,
    }
}

/// Rows as they are drawn, with some of their columns.
fn table<'a>(about: &str, rows: impl Iterator<Item = &'a Row>) -> Table {
    let cells = |row: &Row| -> Vec<Cell> {
        vec![
            row.scene[..].into(),
            (row.n as f64).into(),
            row.format[..].into(),
            row.setting[..].into(),
            (row.bytes as f64).into(),
            row.bytes_per_n2.into(),
            row.cpu1_ms.into(),
            row.l2.into(),
            row.vis99.into(),
        ]
    };
    Table {
        about: about.to_owned(),
        columns: vec![
            Column { name: "scene", meaning: "as in bench/record" },
            Column { name: "n", meaning: "patches" },
            Column { name: "format", meaning: "of the operator" },
            Column { name: "setting", meaning: "of the format" },
            Column { name: "bytes", meaning: "of the operator as stored" },
            Column { name: "bytes_per_n2", meaning: "the same over n²" },
            Column { name: "cpu1_ms", meaning: "median of a product in three colours on one thread, milliseconds" },
            Column { name: "l2", meaning: "error of indirect light, area-weighted L2, mean over probe lights" },
            Column { name: "vis99", meaning: "99th percentile of what is seen of it" },
        ],
        keys: 4,
        rows: rows.map(cells).collect(),
    }
}
