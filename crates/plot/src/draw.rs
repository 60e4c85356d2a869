//! A chart in kuva's terms.

use std::sync::Arc;

use kuva::{
    backend::{raster::RasterBackend, svg::SvgBackend},
    plot::{LegendEntry, LegendPosition, LegendShape, LinePlot, MarkerShape, ScatterPlot},
    render::{
        layout::{Layout, TickFormat},
        plots::Plot,
        render::{Scene, render_multiple},
    },
};

use crate::{Axis, Chart, Error, Marker, Scale, Series, Stroke, Ticks};

/// Width and height of the picture, in units of the SVG.
const SIZE: [f64; 2] = [900.0, 560.0];
/// Okabe and Ito's colours; their yellow, which is faint on white, comes last.
const COLOURS: [&str; 8] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#E69F00", "#56B4E9", "#B8A800"];
/// Pixels of the PNG for each unit.
const PIXELS: f32 = 2.0;

pub fn svg(chart: &Chart) -> Result<String, Error> {
    let text = SvgBackend::new().with_pretty(true).render_scene(&scene(chart)?);
    // kuva numbers the rectangle of the axes through the whole process; the bytes must not tell how many charts came before.
    let number = text.split("\"kuva-clip-").nth(1).and_then(|rest| rest.split('"').next());
    Ok(match number {
        Some(number) => text.replace(&format!("kuva-clip-{number}"), "axes"),
        None => text,
    })
}

pub fn png(chart: &Chart) -> Result<Vec<u8>, Error> {
    let scene = scene(chart)?;
    let painted = RasterBackend::new().with_scale(PIXELS).render_scene(&scene);
    painted.map_err(|reason| Error::Painting { title: chart.title.clone(), reason })
}

fn scene(chart: &Chart) -> Result<Scene, Error> {
    check(&chart.x)?;
    check(&chart.y)?;
    let plots: Vec<Plot> = chart.series.iter().flat_map(|series| plots(chart, series)).collect();
    if plots.is_empty() {
        return Err(Error::Empty { title: chart.title.clone() });
    }
    Ok(render_multiple(plots, layout(chart)))
}

fn check(axis: &Axis) -> Result<(), Error> {
    let [from, to] = axis.range;
    let log = axis.scale == Scale::Log;
    let of = if log { " of positive numbers" } else { "" };
    match from < to && from.is_finite() && to.is_finite() && (!log || from > 0.0) {
        true => Ok(()),
        false => Err(Error::Range { label: axis.label.clone(), from, to, of }),
    }
}

/// What values of an axis are divided by. kuva draws logarithms of numbers below 1e-10 as that of 1e-10, so that
/// logarithmic axes are handed to it starting in the decade from 1.
fn unit(axis: &Axis) -> f64 {
    match axis.scale {
        Scale::Linear => 1.0,
        Scale::Log => 10f64.powf(axis.range[0].log10().floor()),
    }
}

fn layout(chart: &Chart) -> Layout {
    let [x_unit, y_unit] = [unit(&chart.x), unit(&chart.y)];
    let ([x0, x1], [y0, y1]) = (chart.x.range.map(|v| v / x_unit), chart.y.range.map(|v| v / y_unit));
    let mut layout = Layout::new((x0, x1), (y0, y1))
        .with_width(SIZE[0])
        .with_height(SIZE[1])
        .with_title(&chart.title)
        .with_title_size(17)
        .with_subtitle(&chart.subtitle)
        .with_subtitle_size(12)
        .with_x_label(&chart.x.label)
        .with_y_label(&chart.y.label)
        .with_label_size(13)
        .with_tick_size(11)
        .with_grid_line_width(0.5)
        .with_box_axes()
        .with_x_tick_format(tick_format(&chart.x))
        .with_y_tick_format(tick_format(&chart.y))
        .with_x_axis_min(x0)
        .with_x_axis_max(x1)
        .with_y_axis_min(y0)
        .with_y_axis_max(y1)
        .with_clamp_axis()
        .with_legend_position(LegendPosition::OutsideRightTop)
        .with_legend_box(false)
        .with_legend_entries(chart.series.iter().filter(|s| !s.name.is_empty()).map(legend_entry).collect());
    if chart.x.scale == Scale::Log {
        layout = layout.with_log_x();
    }
    if chart.y.scale == Scale::Log {
        layout = layout.with_log_y();
    }
    layout
}

/// The unbroken stretches of a curve inside the axes, and its markers.
fn plots(chart: &Chart, series: &Series) -> Vec<Plot> {
    let colour = COLOURS[series.colour % COLOURS.len()];
    let [x_unit, y_unit] = [unit(&chart.x), unit(&chart.y)];
    let inside = |p: &[f64; 2]| shows(&chart.x, p[0]) && shows(&chart.y, p[1]);
    let mut plots = Vec::new();
    for run in series.points.split(|p| !inside(p)).filter(|run| !run.is_empty()) {
        let run: Vec<(f64, f64)> = run.iter().map(|&[x, y]| (x / x_unit, y / y_unit)).collect();
        if let Some(shape) = marker(series.marker) {
            let points = ScatterPlot::new().with_data(run.clone()).with_color(colour).with_size(3.5);
            plots.push(Plot::Scatter(points.with_marker(shape)));
        }
        let line = LinePlot::new().with_data(run).with_color(colour).with_stroke_width(1.8);
        match series.stroke {
            Stroke::Solid => plots.push(Plot::Line(line)),
            Stroke::Dashed => plots.push(Plot::Line(line.with_dashed())),
            Stroke::Dotted => plots.push(Plot::Line(line.with_dotted())),
            Stroke::None => {}
        }
    }
    plots
}

fn shows(axis: &Axis, value: f64) -> bool {
    value.is_finite() && (axis.range[0]..=axis.range[1]).contains(&value)
}

fn marker(marker: Marker) -> Option<MarkerShape> {
    match marker {
        Marker::None => None,
        Marker::Circle => Some(MarkerShape::Circle),
        Marker::Square => Some(MarkerShape::Square),
        Marker::Triangle => Some(MarkerShape::Triangle),
        Marker::Cross => Some(MarkerShape::Cross),
    }
}

fn legend_entry(series: &Series) -> LegendEntry {
    let dasharray = match series.stroke {
        Stroke::Dashed => Some("8 4".to_owned()),
        Stroke::Dotted => Some("2 4".to_owned()),
        Stroke::Solid | Stroke::None => None,
    };
    let shape = match marker(series.marker) {
        Some(shape) if series.stroke == Stroke::None => LegendShape::Marker(shape),
        _ => LegendShape::Line,
    };
    let color = COLOURS[series.colour % COLOURS.len()].to_owned();
    LegendEntry { label: series.name.clone(), color, shape, dasharray }
}

fn tick_format(axis: &Axis) -> TickFormat {
    let words: fn(f64) -> String = match axis.ticks {
        Ticks::Plain => plain,
        Ticks::Percent => percent,
        Ticks::Words(words) => words,
    };
    let unit = unit(axis);
    TickFormat::Custom(Arc::new(move |value| words(value * unit)))
}

/// Short numbers as they are, long ones as powers of ten.
fn plain(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e3).contains(&size) {
        // Ticks are sums of steps: twelve digits hide what rounding left.
        return format!("{}", format!("{value:.12}").parse::<f64>().unwrap_or(value));
    }
    // A tick may be a hair below its power of ten.
    let exponent = (size.log10() + 1e-9).floor();
    let mantissa = value / 10f64.powf(exponent);
    let power: String = format!("{exponent}").chars().map(raised).collect();
    match format!("{mantissa:.2}").trim_end_matches('0').trim_end_matches('.') {
        "1" => format!("10{power}"),
        digits => format!("{digits}·10{power}"),
    }
}

fn percent(value: f64) -> String {
    format!("{} %", plain(100.0 * value))
}

fn raised(digit: char) -> char {
    match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0'..='9' => char::from_u32(0x2070 + digit as u32 - '0' as u32).unwrap_or(digit),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::{percent, plain};

    #[test]
    fn ticks_are_written_as_people_write_them() {
        let written = [0.0, 0.001, 0.1 + 0.2, 200.0, 1e3, 1e-16, 2.5e-7].map(plain);
        assert_eq!(written, ["0", "0.001", "0.3", "200", "10³", "10⁻¹⁶", "2.5·10⁻⁷"]);
        assert_eq!([0.001, 1.0, 1e-12].map(percent), ["0.1 %", "100 %", "10⁻¹⁰ %"]);
    }
}
