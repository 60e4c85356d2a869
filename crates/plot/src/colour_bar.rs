//! Bars that tell which number a colour of a picture stands for.

use kuva::{
    backend::raster::RasterBackend,
    plot::ColorMap,
    render::{
        color::Color,
        render::{Primitive, Scene, TextAnchor},
    },
};

use crate::Error;

/// Height of a bar with its writing, pixels.
pub const BAR_HEIGHT: u32 = 64;
/// From the borders of the picture to the ends of the bar.
const MARGIN: f64 = 24.0;
/// Upper and lower border of the bar itself.
const BAR: [f64; 2] = [8.0, 20.0];
const TICK: f64 = 4.0;
/// Height of letters, and about how wide one is for its height.
const LETTERS: f64 = 12.0;
const LETTER_WIDTH: f64 = 0.55;

/// Colours of numbers from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colours {
    /// From black over red to light yellow, equal steps looking equal (matplotlib's Inferno).
    Sequential,
    /// From blue over white, at one half, to red (C. Brewer's RdBu).
    Diverging,
}

impl Colours {
    /// The colour of a number, sRGB; those beyond 0 and 1 have the colours at the ends.
    pub fn at(self, value: f64) -> [u8; 3] {
        let (map, value) = match self {
            Colours::Sequential => (ColorMap::Inferno, value),
            Colours::Diverging => (ColorMap::RedBlue, 1.0 - value),
        };
        let (r, g, b) = map.map_rgb(value.clamp(0.0, 1.0)).unwrap_or_default();
        [r, g, b]
    }
}

/// A bar with the numbers of some of its colours.
#[derive(Clone, Debug)]
pub struct ColourBar {
    /// What the numbers are, in one line below the bar.
    pub label: String,
    /// Colours from the left end to the right.
    pub colours: Colours,
    /// Where along the bar, 0 to 1, which number is written.
    pub ticks: Vec<(f64, String)>,
}

impl ColourBar {
    /// The bar as PNG, `width` × [`BAR_HEIGHT`] pixels, black on white.
    ///
    /// # Errors
    ///
    /// [`Error::Painting`] if it could not be drawn.
    pub fn png(&self, width: u32) -> Result<Vec<u8>, Error> {
        let mut scene = Scene::new(width.into(), BAR_HEIGHT.into());
        let length = (f64::from(width) - 2.0 * MARGIN).max(1.0);
        for step in 0..length as u32 {
            let [r, g, b] = self.colours.at((f64::from(step) + 0.5) / length);
            scene.elements.push(rectangle(MARGIN + f64::from(step), 1.0, Color::Rgb(r, g, b)));
        }
        for (at, number) in &self.ticks {
            let x = MARGIN + at * length;
            let stroke = Color::Rgb(0, 0, 0);
            let (y1, y2) = (BAR[1], BAR[1] + TICK);
            scene.elements.push(Primitive::Line {
                x1: x,
                y1,
                x2: x,
                y2,
                stroke,
                stroke_width: 1.0,
                stroke_dasharray: None,
            });
            scene.elements.push(text(x, y2 + 13.0, LETTERS, number));
        }
        let size = fitting(&self.label, width);
        scene.elements.push(text(f64::from(width) / 2.0, f64::from(BAR_HEIGHT) - 8.0, size, &self.label));
        let painted = RasterBackend::new().with_scale(1.0).render_scene(&scene);
        painted.map_err(|reason| Error::Painting { title: self.label.clone(), reason })
    }
}

fn rectangle(x: f64, width: f64, fill: Color) -> Primitive {
    let (y, height) = (BAR[0], BAR[1] - BAR[0]);
    Primitive::Rect { x, y, width, height, fill, stroke: None, stroke_width: None, opacity: None }
}

/// Height of letters with which a line fits into so many pixels.
pub fn fitting(line: &str, width: u32) -> f64 {
    LETTERS.min(f64::from(width) / (LETTER_WIDTH * line.chars().count().max(1) as f64))
}

/// Words around `x`, standing on `y`.
pub fn text(x: f64, y: f64, size: f64, words: &str) -> Primitive {
    let (content, anchor, size) = (words.to_owned(), TextAnchor::Middle, size as u32);
    Primitive::Text { x, y, content, size, anchor, rotate: None, bold: false, color: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_run_from_end_to_end() {
        let [dark, light] = [0.0, 1.0].map(|x| Colours::Sequential.at(x).iter().map(|c| u32::from(*c)).sum::<u32>());
        assert!(dark < 20 && light > 500, "{dark} {light}");
        let [[low_red, _, low_blue], middle, [high_red, _, high_blue]] =
            [-3.0, 0.5, 3.0].map(|x| Colours::Diverging.at(x));
        assert!(low_blue > low_red && high_red > high_blue && middle.iter().all(|c| *c > 230), "{middle:?}");
    }

    #[test]
    fn the_bar_is_as_wide_as_asked() {
        let bar = ColourBar { label: "F".into(), colours: Colours::Diverging, ticks: vec![(0.5, "0 %".into())] };
        let bytes = bar.png(300).expect("a picture");
        // Width and height are the first numbers of a PNG's header.
        assert_eq!(bytes[16..24], [0, 0, 1, 44, 0, 0, 0, BAR_HEIGHT as u8]);
    }
}
