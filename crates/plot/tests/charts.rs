//! Pictures hold what the chart says, at the places where its axes say.

use plot::{Axis, Chart, Error, Marker, Scale, Series, Stroke, Ticks};

fn axis(scale: Scale, range: [f64; 2]) -> Axis {
    Axis { label: "length, m".to_owned(), scale, range, ticks: Ticks::Plain }
}

fn curve(points: &[[f64; 2]]) -> Series {
    Series {
        name: "measured".to_owned(),
        points: points.to_vec(),
        colour: 0,
        stroke: Stroke::None,
        marker: Marker::Circle,
    }
}

fn chart(x: Axis, y: Axis, series: Vec<Series>) -> Chart {
    Chart { title: "A title".to_owned(), subtitle: "a room".to_owned(), x, y, series }
}

/// Centres of the discs of an SVG.
fn discs(svg: &str) -> Vec<[f64; 2]> {
    let number = |tag: &str, name: &str| -> f64 {
        let rest = tag.split(&format!("{name}=\"")).nth(1).expect("an attribute");
        rest.split('"').next().and_then(|text| text.parse().ok()).expect("a number")
    };
    svg.split("<circle").skip(1).map(|tag| [number(tag, "cx"), number(tag, "cy")]).collect()
}

/// Three points that are equally far apart on their axes, down to 1e-14, are so in the picture.
#[test]
fn axes_are_to_scale() {
    let log = chart(
        axis(Scale::Log, [1e-16, 1.0]),
        axis(Scale::Linear, [0.0, 4.0]),
        vec![curve(&[[1e-14, 1.0], [1e-8, 2.0], [1e-2, 3.0]])],
    );
    let places = discs(&log.svg().expect("a picture"));
    for axis in 0..2 {
        let [a, b, c] = [places[0][axis], places[1][axis], places[2][axis]];
        assert!((b - a - (c - b)).abs() < 0.1 && (b - a).abs() > 50.0, "{places:?}");
    }
}

#[test]
fn the_picture_says_what_it_shows() {
    let chart = chart(axis(Scale::Linear, [0.0, 1.0]), axis(Scale::Log, [1e-3, 1.0]), vec![curve(&[[0.5, 0.1]])]);
    let svg = chart.svg().expect("a picture");
    for words in ["A title", "a room", "length, m", "measured", "0.001"] {
        assert!(svg.contains(words), "{words} is missing");
    }
    assert_eq!(svg, chart.svg().expect("a picture"), "the same chart, other bytes");
    let png = chart.png().expect("a picture");
    assert_eq!(png[..8], *b"\x89PNG\r\n\x1a\n");
    assert_eq!(png, chart.png().expect("a picture"), "the same chart, other bytes");
}

/// Points outside the axes are not drawn at their edge, and a curve breaks where it has no value.
#[test]
fn what_is_outside_is_left_out() {
    let points = [[0.5, 0.1], [0.6, f64::NAN], [0.7, 5.0], [0.8, 0.1]];
    let line = Series { stroke: Stroke::Solid, ..curve(&points) };
    let lone = chart(axis(Scale::Linear, [0.0, 1.0]), axis(Scale::Linear, [0.0, 1.0]), vec![line]);
    let inside = discs(&lone.svg().expect("a picture"));
    // The legend of a curve shows its line.
    assert_eq!(inside.len(), 2, "{inside:?}");
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let fine = axis(Scale::Linear, [0.0, 1.0]);
    let empty = chart(fine.clone(), fine.clone(), vec![curve(&[[0.5, f64::NAN], [0.5, 2.0]])]);
    assert_eq!(empty.svg(), Err(Error::Empty { title: "A title".to_owned() }));
    for wrong in [axis(Scale::Log, [0.0, 1.0]), axis(Scale::Linear, [1.0, 1.0]), axis(Scale::Linear, [0.0, f64::NAN])] {
        let refused = chart(wrong, fine.clone(), vec![curve(&[[0.5, 0.5]])]).png();
        assert!(matches!(refused, Err(Error::Range { .. })), "{refused:?}");
    }
}
