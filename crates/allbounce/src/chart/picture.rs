//! Error against time, error against memory: one colour and shape a method, and the front that nobody beats.

use plot::{Axis, Chart, Marker, Scale, Series, Stroke, Ticks, front};

use super::{Report, contestants::ALL, judge::Entry};

const SHAPES: [Marker; 4] = [Marker::Circle, Marker::Square, Marker::Triangle, Marker::Cross];
/// Colours before they come again, with another shape.
const COLOURS: usize = 8;
const KIB: f64 = 1024.0;

/// Error against the time of a change of the lights.
pub fn of_time(report: &Report) -> Chart {
    chart(report, "Error against time", "change of the lights, ms", &|e| e.change_ms)
}

/// Error against what is kept; methods that keep nothing are not in it.
pub fn of_memory(report: &Report) -> Chart {
    chart(report, "Error against memory", "memory kept, KiB", &|e| e.bytes as f64 / KIB)
}

fn chart(report: &Report, title: &str, label: &str, x: &dyn Fn(&Entry) -> f64) -> Chart {
    let place = |e: &Entry| [x(e), 100.0 * e.score.rms];
    let drawn = |p: &[f64; 2]| p.iter().all(|v| v.is_finite() && *v > 0.0);
    let all: Vec<[f64; 2]> = report.entries.iter().map(place).filter(drawn).collect();
    let mut series = vec![Series {
        name: "nothing is better in both".into(),
        points: front(&all),
        colour: 4,
        stroke: Stroke::Dotted,
        marker: Marker::None,
    }];
    for (number, method) in ALL.iter().enumerate() {
        let of_method = report.entries.iter().filter(|e| e.method == method.label);
        let points: Vec<[f64; 2]> = of_method.map(place).filter(drawn).collect();
        if !points.is_empty() {
            let (colour, marker) = style(number);
            series.push(Series { name: method.label.into(), points, colour, stroke: Stroke::None, marker });
        }
    }
    let lights = report.lights.join(", ");
    let note = if report.note.is_empty() { String::new() } else { format!("; {}", report.note) };
    Chart {
        title: format!("{title}: {}", report.scene),
        subtitle: format!("{} points under {lights}, {} threads{note}", report.receivers, report.threads),
        x: axis(label, all.iter().map(|p| p[0])),
        y: axis("RMS error of indirect irradiance, % of its mean", all.iter().map(|p| p[1])),
        series,
    }
}

/// Colour and shape, together of one method alone. Black is the front's.
fn style(number: usize) -> (usize, Marker) {
    let others = COLOURS - 1;
    let colour = number % others;
    (if colour >= 4 { colour + 1 } else { colour }, SHAPES[(number + 2 * (number / others)) % SHAPES.len()])
}

/// A logarithmic axis over the values with some room beside them.
fn axis(label: &str, values: impl Iterator<Item = f64>) -> Axis {
    let [least, most] = values.fold([f64::INFINITY, 0.0f64], |[a, b], v| [a.min(v), b.max(v)]);
    let range = if most > 0.0 { [least / 1.5, most * 1.5] } else { [0.1, 1.0] };
    Axis { label: label.into(), scale: Scale::Log, range, ticks: Ticks::Plain }
}

#[cfg(test)]
mod tests {
    use super::{ALL, style};

    #[test]
    fn no_two_methods_look_alike() {
        for (a, method) in ALL.iter().enumerate() {
            assert!((0..a).all(|b| style(a) != style(b)), "{}", method.label);
        }
    }
}
