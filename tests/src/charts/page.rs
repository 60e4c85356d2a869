//! The page that shows the charts.

use std::fmt::Write;

use super::Figure;

/// What stands before the first figure.
pub const HEAD: &str = "# The stability laboratory\n\n\
    Where methods hold and where they fail. `make charts` writes this folder again: pictures (SVG, PNG), numbers (CSV) \
    and this page. Every sentence of a list is an assertion of `tests/tests/charts.rs`. Rooms are empty boxes whose form \
    factors are known in closed form (J. R. Howell, entries C-13 and C-15), and the truth is a refined solution with an error \
    bound (`tests/src/charts/judge.rs`). The axis of reflectances is that of 1 / (1 − ρ), the gain of all bounces together.\n\n\
    Charts of operators, at the end, are of whole scenes: `make bench` measures them, and their sentences are about \
    its record in `bench/record/`.\n\n\
    Speed against accuracy of every method, by `make rival-charts`: [Cornell box](rivals-cornell.md), \
    [apartment](rivals-apartment.md), and a larger scene that is not bundled, [Sponza](rivals-sponza.md). Indirect light as a camera sees it by each of them, beside the path-traced truth (upper \
    left), with method, setting, time of a light change and RMS error below each picture: \
    [Cornell box](side-by-side-cornell.png).\n\n\
    Which claims of the published method hold, by `make claims`: [table](claims.md).\n";

/// `docs/charts/README.md`.
pub fn text(figures: &[Figure]) -> String {
    let mut page = String::from(HEAD);
    for figure in figures {
        let (name, title) = (figure.name, &figure.chart.title);
        write!(page, "\n## {title}\n\n![{title}]({name}.png)\n\n{}\n\n", figure.setting).expect("writing to a string");
        for claim in &figure.claims {
            let measured = claim.measured.map(|value| format!(" Measured: {}.", three_digits(value)));
            writeln!(page, "- {}{}", claim.says, measured.unwrap_or_default()).expect("writing to a string");
        }
        writeln!(page, "\n[numbers]({name}.csv), [SVG]({name}.svg)").expect("writing to a string");
    }
    page
}

fn three_digits(value: f64) -> String {
    let short: f64 = format!("{value:.2e}").parse().expect("a number was written");
    if short == 0.0 || (1e-3..1e6).contains(&short.abs()) { format!("{short}") } else { format!("{short:e}") }
}
