//! The matrix in the order in which patches were made, as `permute` ordered them, and as hierarchical blocks have them.

use plot::{Content, Panel, Sheet};
use serde::Serialize;

use super::{
    Plot,
    entries::{self, Cells, LogColours},
    subject::{DENSE, Matrix, Subject},
};
use crate::numbers;

const NAME: &str = "matrix";
const DECADES: u32 = 5;

#[derive(Serialize)]
struct Numbers {
    matrix: &'static str,
    patches: usize,
    pixels: usize,
    orders: Vec<Order>,
}

#[derive(Serialize)]
struct Order {
    order: &'static str,
    /// Of all entries.
    mean: f64,
    /// RMS difference of the square roots of entries that are neighbours in a row, relative to the RMS of the roots.
    neighbours_differ_by: f64,
}

pub fn draw(subject: &Subject) -> anyhow::Result<Plot> {
    let Some(matrix) = subject.matrix() else {
        return Ok(Plot::missing(NAME, format!("The container has no dense matrix; {DENSE}.")));
    };
    let drawn: Vec<(Order, Cells)> =
        orders(subject).into_iter().map(|(name, order)| seen(&matrix, name, &order)).collect();
    let top = drawn.iter().flat_map(|(_, cells)| &cells.mean).fold(0.0f64, |most, v| most.max(*v));
    // A matrix of zeros is as dark as can be.
    let colours = LogColours { top: if top > 0.0 { top } else { 1.0 }, decades: DECADES };
    let panel = |(order, cells): &(Order, Cells)| Panel {
        title: format!("{}; neighbours differ by {}", order.order, numbers::percent(order.neighbours_differ_by)),
        content: Content::Picture {
            pixels: colours.pixels(cells),
            key: colours.key(colours.top, "entries relative to the brightest pixel, logarithmic".into()),
        },
    };
    let (n, side, symbol) = (matrix.n, drawn[0].1.side, matrix.symbol);
    let sampled =
        if side < n { format!("{side} × {side} pixels, each a mean of entries") } else { "a pixel an entry".into() };
    let sheet = Sheet {
        title: format!("The matrix {symbol} in different orders of the patches"),
        subtitle: format!(
            "{n} patches, {sampled}, mean of {} channel(s). Rows receive, columns send. Neighbours differ by: RMS over \
             pairs of entries beside each other, by their square roots, relative to the RMS of these.",
            matrix.channels.len()
        ),
        panels: drawn.iter().map(panel).collect(),
    };
    let never = if subject.order.is_none() {
        " The patches of this container were never reordered; permute does so."
    } else {
        ""
    };
    let sentence = format!(
        "The matrix {symbol} of {n} patches, {sampled}; one picture for each order of the patches, and the smoother an order is, \
         the better its matrix packs.{never}"
    );
    let numbers =
        Numbers { matrix: symbol, patches: n, pixels: side, orders: drawn.into_iter().map(|d| d.0).collect() };
    Plot::new(NAME, sheet, &numbers, sentence)
}

/// The orders that are known, as number of the patch at each place.
fn orders(subject: &Subject) -> Vec<(&'static str, Vec<u32>)> {
    let mut orders = Vec::new();
    match &subject.order {
        Some(order) => {
            orders.push(("as they were made", order.old_to_new()));
            orders.push(("after permute", subject.numbered()));
        }
        None => orders.push(("as they are numbered", subject.numbered())),
    }
    orders.extend(subject.clusters().map(|clusters| ("in hierarchical blocks", clusters)));
    orders
}

/// What is seen of a matrix in an order.
fn seen(matrix: &Matrix, name: &'static str, order: &[u32]) -> (Order, Cells) {
    let n = matrix.n;
    let share = 1.0 / matrix.channels.len() as f64;
    let entry = |row: usize, column: usize| {
        share * matrix.channels.iter().map(|channel| f64::from(channel[row * n + column])).sum::<f64>()
    };
    let mut next: Vec<usize> = (0..n).collect();
    order.windows(2).for_each(|pair| next[pair[0] as usize] = pair[1] as usize);
    let step = |row: usize, column: usize| (entry(row, next[column]).sqrt() - entry(row, column).sqrt()).powi(2);
    let pairs = (n as f64 - 1.0).max(1.0) / n as f64;
    let steps = entries::cells(order, step).whole / pairs;
    let cells = entries::cells(order, entry);
    // The square of a root is the entry.
    let neighbours_differ_by = if cells.whole > 0.0 { (steps / cells.whole).sqrt() } else { 0.0 };
    (Order { order: name, mean: cells.whole, neighbours_differ_by }, cells)
}
