//! (i) What the order of patches is worth, in codes and in light.

use plot::{Axis, Chart, Marker, Scale, Series, Stroke, Ticks};

use super::{AGREEMENT, Record};
use crate::{
    bench::orders::{RANDOM, Row},
    charts::{
        Claim, Figure,
        table::{Cell, Column, Table},
    },
};

/// From the worst to the best, as places on the axis 1, 2, …
const ORDERS: [&str; 6] = [RANDOM, "morton", "hilbert", "scene", "normal-hilbert", "greedy"];
/// Scenes, with their colours.
const SCENES: [(&str, usize); 2] = [("cornell", 1), ("apartment", 0)];
/// A figure of a row.
type Value = fn(&Row) -> Option<f64>;

/// What is compared.
const MEASURES: [(&str, Stroke, Marker, Value); 3] = [
    ("codes of paper (BC1)", Stroke::Solid, Marker::Circle, |row| row.paper_code_rms),
    ("light of paper (BC1)", Stroke::Dashed, Marker::Square, |row| row.paper_l2),
    ("light of bc4-sqrt", Stroke::Dotted, Marker::Triangle, |row| row.bc4_sqrt_l2),
];

pub fn figure(record: &Record) -> Figure {
    let mut series = Vec::new();
    for (scene, colour) in SCENES {
        for (name, stroke, marker, value) in MEASURES {
            let gain = |(place, order): (usize, &&str)| [(place + 1) as f64, gain(record, scene, order, value)];
            let points = ORDERS.iter().enumerate().map(gain).collect();
            series.push(Series { name: format!("{scene}: {name}"), points, colour, stroke, marker });
        }
    }
    Figure {
        name: "operator-orders",
        setting: format!(
            "How many times smaller the error is than in a random order of patches: of the codes (RMS, what the paper \
             goes by) and of indirect light (L2), about 1300 patches. The paper's order is `greedy`, on sketches of \
             rows; `scene` is that in which `voxel-simplify` leaves patches. Cornell box and apartment; in Sponza, also among \
             the numbers, orders are worth less. Record {}.",
            record.name
        ),
        claims: claims(record),
        table: table(record),
        agreement: AGREEMENT,
        chart: Chart {
            title: "What the order of patches is worth".to_owned(),
            subtitle: "error in a random order over error in this order; about 1300 patches".to_owned(),
            x: Axis {
                label: "order of rows and columns".to_owned(),
                scale: Scale::Linear,
                range: [0.5, ORDERS.len() as f64 + 0.5],
                ticks: Ticks::Words(word),
            },
            y: Axis {
                label: "times smaller than in a random order".to_owned(),
                scale: Scale::Linear,
                range: [0.0, 5.0],
                ticks: Ticks::Plain,
            },
            series,
        },
    }
}

/// The order at a place of the axis.
fn word(place: f64) -> String {
    let whole = (place - place.round()).abs() < 1e-9 && place >= 1.0;
    ORDERS.get(place.round() as usize - 1).filter(|_| whole).map_or(String::new(), |order| (*order).to_owned())
}

/// Rows of the small bake of a scene: nothing is packed in large ones.
fn rows<'a>(record: &'a Record, scene: &'a str) -> impl Iterator<Item = &'a Row> {
    let of = move |row: &&Row| row.scene == scene && row.paper_l2.is_some();
    let smallest = record.orders.iter().filter(of).map(|row| row.n).min();
    record.orders.iter().filter(of).filter(move |row| Some(row.n) == smallest)
}

fn value(record: &Record, scene: &str, order: &str, value: Value) -> f64 {
    rows(record, scene).find(|row| row.order == order).and_then(value).unwrap_or(f64::NAN)
}

fn gain(record: &Record, scene: &str, order: &str, of: Value) -> f64 {
    value(record, scene, RANDOM, of) / value(record, scene, order, of)
}

fn claims(record: &Record) -> Vec<Claim> {
    let codes = |scene: &str, order: &str| gain(record, scene, order, |row| row.paper_code_rms);
    let light = |scene: &str, order: &str| gain(record, scene, order, |row| row.paper_l2);
    let sqrt = |scene: &str, order: &str| gain(record, scene, order, |row| row.bc4_sqrt_l2);
    let least = |of: &dyn Fn(&str) -> f64| SCENES.iter().map(|(scene, _)| of(scene)).fold(f64::INFINITY, f64::min);
    let most = |of: &dyn Fn(&str) -> f64| SCENES.iter().map(|(scene, _)| of(scene)).fold(0.0, f64::max);
    vec![
        Claim::within(
            most(&|scene| codes(scene, "greedy")),
            3.0..=4.0,
            "In codes the paper's order gains three to four times over a random one in these two scenes, not five.",
        ),
        Claim::within(
            most(&|scene| codes(scene, "greedy") / codes(scene, "scene")),
            2.0..=2.5,
            "Over the order of the scene, which nobody had to look for, it gains at most 2.5 times.",
        ),
        Claim::at_least(
            least(&|scene| light(scene, "greedy")),
            2.5,
            "The light of the paper's format gains more than 2.5 times in both.",
        ),
        Claim::at_least(
            light("cornell", "normal-hilbert") / light("cornell", "greedy"),
            1.0,
            "`normal-hilbert`, which takes a millisecond, does as well in the Cornell box,",
        ),
        Claim::at_most(
            light("apartment", "normal-hilbert") / light("apartment", "greedy"),
            0.6,
            "but little more than half as well among the rooms of the apartment.",
        ),
        Claim::at_most(
            most(&|scene| ORDERS.iter().map(|order| sqrt(scene, order)).fold(0.0, f64::max)),
            1.15,
            "The light of `bc4-sqrt` gains nothing from any order: what is random cancels in the product.",
        ),
    ]
}

fn table(record: &Record) -> Table {
    let row = |row: &Row| -> Vec<Cell> {
        vec![
            row.scene[..].into(),
            (row.n as f64).into(),
            row.order[..].into(),
            row.zero_tiles.into(),
            row.paper_code_rms.into(),
            row.paper_rms.into(),
            row.paper_l2.into(),
            row.bc4_sqrt_rms.into(),
            row.bc4_sqrt_l2.into(),
        ]
    };
    Table {
        about: "Errors of packed operators in every order of patches.".to_owned(),
        columns: vec![
            Column { name: "scene", meaning: "as in bench/record" },
            Column { name: "n", meaning: "patches" },
            Column { name: "order", meaning: "as `allbounce permute --order`; scene is that of voxel-simplify" },
            Column { name: "zero_tiles", meaning: "share of 16 × 16 tiles of the form factors that are zero" },
            Column { name: "paper_code_rms", meaning: "RMS of the error of the codes of `paper`, 0 to 1" },
            Column { name: "paper_rms", meaning: "error of the matrix of `paper`, Frobenius norm, relative" },
            Column { name: "paper_l2", meaning: "error of its indirect light, L2" },
            Column { name: "bc4_sqrt_rms", meaning: "the same of `bc4-sqrt`" },
            Column { name: "bc4_sqrt_l2", meaning: "the same of `bc4-sqrt`" },
        ],
        keys: 3,
        rows: record.scenes().into_iter().flat_map(|scene| rows(record, scene)).map(row).collect(),
    }
}
