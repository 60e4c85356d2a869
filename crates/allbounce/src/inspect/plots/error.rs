//! How far the packed operator is from the dense one, entry by entry.

use std::borrow::Cow;

use plot::{Content, Panel, Sheet};
use radfile::Kernel;
use serde::Serialize;

use super::{
    Plot,
    entries::{self, LogColours},
    subject::{DENSE, Subject},
};
use crate::numbers;

const NAME: &str = "error";
const DECADES: u32 = 4;
/// Bytes an entry while a channel is unpacked and compared: f64, f32, and the dense matrix of one bounce.
const BYTES: u64 = 16;

#[derive(Serialize)]
struct Numbers {
    matrix: &'static str,
    /// RMS of the errors of entries relative to the RMS of entries.
    rms: f64,
    /// Largest error relative to the largest entry.
    largest: f64,
    pixels: usize,
}

/// What the packed operator should be.
struct Dense<'a> {
    symbol: &'static str,
    channels: Vec<Cow<'a, [f32]>>,
}

pub fn draw(subject: &Subject) -> anyhow::Result<Plot> {
    let Some(packed) = &subject.packed else {
        return Ok(Plot::missing(NAME, "The container has no packed operator to compare; run hmatrix or dxt-pack."));
    };
    let n = subject.patches.len();
    let is_there = if is_one_bounce(packed) { subject.factors.is_some() } else { subject.operator.is_some() };
    if !is_there {
        let reason = format!("The container has no dense matrix to hold the packed operator to; {DENSE}.");
        return Ok(Plot::missing(NAME, reason));
    }
    if let Err(reason) = subject.ask_memory(BYTES * (n as u64).pow(2)) {
        return Ok(Plot::missing(NAME, format!("{reason}.")));
    }
    let dense = dense(subject, packed)?;
    let order = subject.clusters().unwrap_or_else(|| subject.numbered());
    let (mut squares, mut of_entries, mut largest, mut most) = (Vec::new(), 0.0, 0.0f64, 0.0f64);
    let share = 1.0 / dense.channels.len() as f64;
    for (channel, exact) in dense.channels.iter().enumerate() {
        let found = decoded(packed, channel)?;
        let error = |at: usize| f64::from(found[at]) - f64::from(exact[at]);
        let cells = entries::cells(&order, |i, j| share * error(i * n + j).powi(2));
        squares.resize(cells.mean.len(), 0.0);
        squares.iter_mut().zip(&cells.mean).for_each(|(sum, mean)| *sum += mean);
        of_entries += entries::cells(&order, |i, j| share * f64::from(exact[i * n + j]).powi(2)).whole;
        largest = (0..n * n).fold(largest, |largest, at| largest.max(error(at).abs()));
        most = exact.iter().fold(most, |most, v| most.max(f64::from(*v)));
    }
    if of_entries <= 0.0 {
        return Ok(Plot::missing(NAME, "All entries of the matrix are 0: no patch sees another."));
    }
    drawn(subject, &dense, squares, [of_entries.sqrt(), largest / most])
}

/// The sheet of mean squares of errors.
fn drawn(subject: &Subject, dense: &Dense, squares: Vec<f64>, [unit, largest]: [f64; 2]) -> anyhow::Result<Plot> {
    let n = subject.patches.len();
    let side = squares.len().isqrt();
    let places = |cell: usize| (cell + 1) * n / side - cell * n / side;
    let sum: f64 = squares.iter().enumerate().map(|(at, s)| s * (places(at / side) * places(at % side)) as f64).sum();
    let rms = sum.sqrt() / n as f64 / unit;
    let top = squares.iter().fold(0.0f64, |most, s| most.max(*s)).sqrt();
    let colours = LogColours { top: if top > 0.0 { top } else { unit }, decades: DECADES };
    let (symbol, mean) = (dense.symbol, numbers::percent(rms));
    let order = if subject.clusters().is_some() { "in the order of their clusters" } else { "as they are numbered" };
    let sheet = Sheet {
        title: format!("Error of the packed operator against the dense {symbol}"),
        subtitle: format!(
            "{n} patches {order}; a pixel is the RMS over its entries and {} channel(s), relative to the RMS of all entries. All \
             together {mean}; largest error {} of the largest entry.",
            dense.channels.len(),
            numbers::percent(largest)
        ),
        panels: vec![Panel {
            title: String::new(),
            content: Content::Picture {
                pixels: squares.iter().map(|s| colours.at(s.sqrt())).collect(),
                key: colours.key(unit, "error relative to the RMS of entries, logarithmic".into()),
            },
        }],
    };
    let sentence = format!(
        "Where the packed operator differs from the dense {symbol}: by {mean} RMS over all entries, which says less than the error of \
         light, as most errors of entries cancel in a product."
    );
    Plot::new(NAME, sheet, &Numbers { matrix: symbol, rms, largest, pixels: side }, sentence)
}

fn is_one_bounce(packed: &relight::Operator) -> bool {
    matches!(packed, relight::Operator::Hierarchical(_, k) if k.kernel == Kernel::OneBounce)
}

/// None of its channels if the container does not hold it.
fn dense<'a>(subject: &'a Subject, packed: &relight::Operator) -> anyhow::Result<Dense<'a>> {
    if is_one_bounce(packed) {
        let w = subject.factors.iter().map(|factors| hmatrix::one_bounce(factors, &subject.patches));
        let channels = w.map(|w| Ok(Cow::Owned(w?.values.into_owned()))).collect::<anyhow::Result<_>>()?;
        return Ok(Dense { symbol: "W", channels });
    }
    let k = subject.operator.iter();
    Ok(Dense { symbol: "K", channels: k.flat_map(|k| (0..k.channels).map(|c| Cow::Borrowed(k.channel(c)))).collect() })
}

/// A channel of the packed operator, dense.
fn decoded(packed: &relight::Operator, channel: usize) -> anyhow::Result<Vec<f32>> {
    Ok(match packed {
        relight::Operator::Textures(product) => product.packed().decode(channel),
        relight::Operator::Hierarchical(matrix, _) => {
            matrix.decode(channel.min(matrix.channels() - 1))?.iter().map(|v| *v as f32).collect()
        }
    })
}
