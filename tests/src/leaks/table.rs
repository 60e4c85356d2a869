//! The table of `docs/leaks.md`.

use super::measure::{Leak, Scores};

/// The lines between which the table stands.
pub const MARKS: [&str; 2] = ["<!-- scores: made by `make leaks` -->", "<!-- end of scores -->"];

/// A page with its table replaced.
///
/// # Panics
///
/// If the page has no place for it.
pub fn replaced(page: &str, scores: &[Scores]) -> String {
    let [head, tail] = MARKS.map(|mark| page.find(mark).expect("the page marks where the table stands"));
    format!("{}\n\n{}\n{}", &page[..head + MARKS[0].len()], table(scores), &page[tail..])
}

fn table(scores: &[Scores]) -> String {
    let mut text = String::from(
        "| scene | dark places: points, receivers | path tracer, at most | gathered | interpolated | receivers | picture |\n\
         |---|---|---|---|---|---|---|\n",
    );
    for s in scores {
        let [points, receivers] = s.places;
        let [gather, interpolate] = [s.gather, s.interpolate].map(leak);
        let received = if receivers == 0 { "–".to_owned() } else { leak(s.receivers) };
        let picture = s.picture.map_or_else(|| "–".to_owned(), percent);
        text += &format!(
            "| {} | {points}, {receivers} | {} | {gather} | {interpolate} | {received} | {picture} |\n",
            s.name,
            percent(s.truth)
        );
    }
    text
}

fn leak(leak: Leak) -> String {
    if leak.worst == 0.0 { "0".to_owned() } else { format!("{}, {}", percent(leak.mean), percent(leak.worst)) }
}

/// Thousandths of a per cent.
fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0".to_owned(),
        small if small < 0.001 => "< 0.001 %".to_owned(),
        other => format!("{other:.3} %"),
    }
}
