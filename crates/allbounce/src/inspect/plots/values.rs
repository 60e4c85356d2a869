//! Which entries the matrix has: on a linear and on a logarithmic scale.

use plot::{Content, Panel, Sheet};
use rayon::prelude::*;
use serde::Serialize;

use super::{
    Plot,
    subject::{DENSE, Matrix, Subject},
};
use crate::numbers;

const NAME: &str = "values";
const COLUMNS: usize = 64;
/// Of the logarithmic scale, from the largest entry down.
const DECADES: usize = 8;
/// Entries that are counted by one task.
const CHUNK: usize = 1 << 16;

#[derive(Serialize)]
struct Numbers {
    matrix: &'static str,
    entries: u64,
    largest: f32,
    zero: u64,
    /// Above 0, and below the columns of the logarithmic scale.
    tiny: u64,
    /// All entries, by columns from 0 to the largest.
    linear: Vec<u64>,
    /// Those that are not zero nor tiny.
    logarithmic: Vec<u64>,
}

pub fn draw(subject: &Subject) -> anyhow::Result<Plot> {
    let Some(matrix) = subject.matrix() else {
        return Ok(Plot::missing(NAME, format!("The container has no dense matrix; {DENSE}.")));
    };
    let numbers = count(&matrix);
    if numbers.largest == 0.0 {
        return Ok(Plot::missing(NAME, "All entries of the matrix are 0: no patch sees another."));
    }
    let of_all = |count: u64| numbers::percent(count as f64 / numbers.entries as f64);
    let columns = |counts: &[u64], ticks, label: &str| Content::Columns {
        heights: counts.iter().map(|c| *c as f64).collect(),
        ticks,
        label: format!("{label}; share of all entries upwards"),
        top: of_all(counts.iter().copied().max().unwrap_or(0)),
    };
    let largest = f64::from(numbers.largest);
    let digits = (2.0 - largest.log10().floor()).clamp(0.0, 9.0) as usize;
    let linear = [0.0, 0.25, 0.5, 0.75, 1.0].map(|at| (at, format!("{:.digits$}", at * largest)));
    let panels = vec![
        Panel { title: "linear".into(), content: columns(&numbers.linear, linear.into(), "entry") },
        Panel {
            title: "logarithmic".into(),
            content: columns(&numbers.logarithmic, powers(numbers.largest), "entry, by its logarithm"),
        },
    ];
    let (first, zero, tiny) = (of_all(numbers.linear[0]), of_all(numbers.zero), of_all(numbers.tiny));
    let what = format!(
        "{first} of the entries lie in the first of {COLUMNS} columns of the linear scale; {zero} are 0 and {tiny} smaller than the \
         logarithmic scale shows"
    );
    let sheet = Sheet {
        title: format!("The entries of {}", numbers.matrix),
        subtitle: format!("{} patches, {} channel(s). {what}.", matrix.n, matrix.channels.len()),
        panels,
    };
    let sentence = format!("How often which entry occurs in {}: {what}.", numbers.matrix);
    Plot::new(NAME, sheet, &numbers, sentence)
}

fn count(matrix: &Matrix) -> Numbers {
    let chunks = || matrix.channels.par_iter().flat_map(|channel| channel.par_chunks(CHUNK));
    let largest = chunks().map(|chunk| chunk.iter().fold(0.0f32, |most, v| most.max(*v))).reduce(|| 0.0, f32::max);
    let mut numbers = Numbers {
        matrix: matrix.symbol,
        entries: matrix.channels.iter().map(|channel| channel.len() as u64).sum(),
        largest,
        zero: 0,
        tiny: 0,
        linear: vec![0; COLUMNS],
        logarithmic: vec![0; COLUMNS],
    };
    // Counts of linear columns, of logarithmic ones, of tiny entries and of zeros.
    let add = |mut counts: Vec<u64>, chunk: &[f32]| {
        for &value in chunk {
            let share = f64::from(value) / f64::from(largest);
            counts[((share * COLUMNS as f64) as usize).min(COLUMNS - 1)] += 1;
            counts[match (value > 0.0, 1.0 + share.log10() / DECADES as f64) {
                (false, _) => 2 * COLUMNS + 1,
                (true, at) if at < 0.0 => 2 * COLUMNS,
                (true, at) => COLUMNS + ((at * COLUMNS as f64) as usize).min(COLUMNS - 1),
            }] += 1;
        }
        counts
    };
    let none = || vec![0; 2 * COLUMNS + 2];
    let both = |a: Vec<u64>, b: Vec<u64>| a.iter().zip(&b).map(|(a, b)| a + b).collect();
    let counts = chunks().fold(none, add).reduce(none, both);
    numbers.linear.copy_from_slice(&counts[..COLUMNS]);
    numbers.logarithmic.copy_from_slice(&counts[COLUMNS..2 * COLUMNS]);
    [numbers.tiny, numbers.zero] = [counts[2 * COLUMNS], counts[2 * COLUMNS + 1]];
    numbers
}

/// Powers of ten along the logarithmic scale.
fn powers(largest: f32) -> Vec<(f64, String)> {
    let top = f64::from(largest).log10();
    let place = |power: i32| 1.0 + (f64::from(power) - top) / DECADES as f64;
    let powers = (0..=DECADES as i32).map(|k| top.floor() as i32 - k).filter(|power| place(*power) >= 0.0);
    powers.map(|power| (place(power), format!("1e{power}"))).collect()
}
