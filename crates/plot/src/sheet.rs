//! Sheets: pictures, columns and bars side by side under one title, for what is no curve.
//!
//! Pictures are pixels. SVG has them as embedded PNG, as a rectangle for each pixel would take megabytes.

use kuva::{
    backend::{raster::RasterBackend, svg::SvgBackend},
    render::{
        color::Color,
        render::{Primitive, Scene, TextAnchor},
    },
};

use crate::{Colours, Error, base64::base64};

/// Pixels along the edge of a picture, two a unit.
pub const PICTURE_PIXELS: usize = 840;
/// Edge of a panel, units of the SVG.
const EDGE: f64 = PICTURE_PIXELS as f64 / PIXELS as f64;
/// Pixels of the PNG for each unit.
const PIXELS: f32 = 2.0;
/// Around the sheet and between its panels.
const MARGIN: f64 = 30.0;
/// Left of columns, for the numbers of their heights.
const NUMBERS: f64 = 44.0;
/// Heights of letters: of the title, of panels' titles, of everything else.
const TITLE: f64 = 17.0;
const HEADING: f64 = 13.0;
const LETTERS: f64 = 12.0;
/// How wide a letter of the subtitle is for its height, about.
const LETTER_WIDTH: f64 = 0.52;
/// From one line to the next.
const LINE: f64 = 17.0;
/// Height of columns, of the place of a bar, and of the strip of colours below a picture.
const COLUMNS: f64 = 300.0;
const BAR: f64 = 34.0;
const STRIP: f64 = 12.0;
/// Width of bars with their names and numbers.
const BARS: f64 = 820.0;
/// Where bars start, and how long the longest is.
const BAR_LEFT: f64 = 330.0;
const LONGEST: f64 = 360.0;
/// Colours of columns and of the two kinds of bars (M. Okabe, K. Ito).
const BLUE: Color = Color::Rgb(0, 0x72, 0xB2);
const GREY: Color = Color::Rgb(0x99, 0x99, 0x99);
const BLACK: Color = Color::Rgb(0, 0, 0);

/// Panels side by side.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// What is seen.
    pub title: String,
    /// Under what circumstances; long ones are broken into lines.
    pub subtitle: String,
    /// From left to right.
    pub panels: Vec<Panel>,
}

/// One of the drawings of a sheet.
#[derive(Clone, Debug)]
pub struct Panel {
    /// What tells it from the others; may be empty.
    pub title: String,
    /// What is drawn.
    pub content: Content,
}

/// What a panel shows.
#[derive(Clone, Debug)]
pub enum Content {
    /// A square picture.
    Picture {
        /// Rows from the top, as many as columns; stretched to [`PICTURE_PIXELS`] without smoothing.
        pixels: Vec<[u8; 3]>,
        /// What the colours mean.
        key: Key,
    },
    /// Columns that touch, such as those of a histogram.
    Columns {
        /// Not negative; the highest fills the panel.
        heights: Vec<f64>,
        /// Where along the columns, 0 to 1, which number is written.
        ticks: Vec<(f64, String)>,
        /// What the numbers below are.
        label: String,
        /// What is written at the height of the highest column; 0 is at the bottom.
        top: String,
    },
    /// Bars that lie below each other, each with its name and its number.
    Bars(Vec<Bar>),
}

/// What the colours of a picture mean.
#[derive(Clone, Debug)]
pub enum Key {
    /// Numbers along a strip of colours.
    Strip {
        /// Colours from the left end to the right.
        colours: Colours,
        /// Where along the strip, 0 to 1, which number is written.
        ticks: Vec<(f64, String)>,
        /// What the numbers are.
        label: String,
    },
    /// Names of single colours.
    Names(Vec<([u8; 3], String)>),
}

/// A bar.
#[derive(Clone, Debug)]
pub struct Bar {
    /// What it is of.
    pub name: String,
    /// Its length, not negative; the longest fills the panel.
    pub length: f64,
    /// The number that is written behind it.
    pub number: String,
    /// Whether it is there to compare with; then it is grey.
    pub beside: bool,
}

impl Sheet {
    /// The sheet as SVG. Letters are text in a usual font without serifs.
    ///
    /// # Errors
    ///
    /// [`Error::Empty`] if a panel has nothing to draw, [`Error::Painting`] if a picture could not be painted.
    pub fn svg(&self) -> Result<String, Error> {
        let (scene, pictures) = self.scene()?;
        let text = SvgBackend::new().with_pretty(true).render_scene(&scene);
        let mut images = String::new();
        for (at, pixels) in pictures {
            let png = self.painted(&paint(&pixels, [0.0, 0.0], 1.0), 1.0)?;
            let [x, y] = at;
            images += &format!(
                "  <image x=\"{x}\" y=\"{y}\" width=\"{EDGE}\" height=\"{EDGE}\" preserveAspectRatio=\"none\" \
                 style=\"image-rendering: pixelated\" href=\"data:image/png;base64,{}\" />\n",
                base64(&png)
            );
        }
        let end = text.rfind("</svg>").unwrap_or(text.len());
        Ok(format!("{}{images}{}", &text[..end], &text[end..]))
    }

    /// The sheet as PNG, two pixels for each unit of the SVG.
    ///
    /// # Errors
    ///
    /// As [`Sheet::svg`].
    pub fn png(&self) -> Result<Vec<u8>, Error> {
        let (mut scene, pictures) = self.scene()?;
        for (at, pixels) in pictures {
            scene.elements.extend(paint(&pixels, at, EDGE / edge(&pixels) as f64).elements);
        }
        self.painted(&scene, PIXELS)
    }

    fn painted(&self, scene: &Scene, scale: f32) -> Result<Vec<u8>, Error> {
        let painted = RasterBackend::new().with_scale(scale).render_scene(scene);
        painted.map_err(|reason| Error::Painting { title: self.title.clone(), reason })
    }

    /// Everything but the pictures, and these with where they are, each with a whole number of pixels.
    #[allow(clippy::type_complexity, reason = "places and pixels of pictures, read once")]
    fn scene(&self) -> Result<(Scene, Vec<([f64; 2], Vec<[u8; 3]>)>), Error> {
        if self.panels.is_empty() || self.panels.iter().any(|panel| panel.content.is_empty()) {
            return Err(Error::Empty { title: self.title.clone() });
        }
        let widths: Vec<f64> = self.panels.iter().map(|panel| panel.content.width()).collect();
        let inner = widths.iter().sum::<f64>() + MARGIN * (widths.len() - 1) as f64;
        let width = inner.max(BARS) + 2.0 * MARGIN;
        let lines = broken(&self.subtitle, ((width - 2.0 * MARGIN) / (LETTER_WIDTH * LETTERS)) as usize);
        let top = MARGIN + TITLE + 8.0 + LINE * lines.len() as f64 + 14.0 + HEADING;
        let tallest = self.panels.iter().map(|panel| panel.content.height()).fold(0.0, f64::max);
        let mut scene = Scene::new(width, top + tallest + MARGIN);
        scene.elements.push(text([width / 2.0, MARGIN + 8.0], TITLE, TextAnchor::Middle, &self.title));
        for (number, line) in lines.iter().enumerate() {
            let y = MARGIN + TITLE + 10.0 + LINE * number as f64;
            scene.elements.push(text([width / 2.0, y], LETTERS, TextAnchor::Middle, line));
        }
        let (mut left, mut pictures) = ((width - inner) / 2.0, Vec::new());
        for (panel, width) in self.panels.iter().zip(widths) {
            let heading = [left + width / 2.0, top - 8.0];
            scene.elements.push(text(heading, HEADING, TextAnchor::Middle, &panel.title));
            match &panel.content {
                Content::Picture { pixels, key } => {
                    pictures.push(([left, top], stretched(pixels)));
                    draw_key(&mut scene, key, [left, top + EDGE + 10.0]);
                }
                Content::Columns { heights, ticks, label, top: highest } => {
                    draw_columns(&mut scene, heights, [left + NUMBERS, top], highest);
                    draw_ticks(&mut scene, ticks, [left + NUMBERS, top + COLUMNS], EDGE - NUMBERS, label);
                }
                Content::Bars(bars) => draw_bars(&mut scene, bars, [left, top]),
            }
            left += width + MARGIN;
        }
        Ok((scene, pictures))
    }
}

impl Content {
    fn is_empty(&self) -> bool {
        match self {
            Content::Picture { pixels, .. } => pixels.is_empty(),
            Content::Columns { heights, .. } => !heights.iter().any(|h| h.is_finite() && *h > 0.0),
            Content::Bars(bars) => !bars.iter().any(|bar| bar.length.is_finite() && bar.length > 0.0),
        }
    }

    fn width(&self) -> f64 {
        if matches!(self, Content::Bars(_)) { BARS } else { EDGE }
    }

    fn height(&self) -> f64 {
        const WRITING: f64 = 44.0;
        match self {
            Content::Picture { key: Key::Strip { .. }, .. } => EDGE + 10.0 + STRIP + WRITING,
            Content::Picture { key: Key::Names(names), .. } => EDGE + 10.0 + LINE * names.len().div_ceil(2) as f64,
            Content::Columns { .. } => COLUMNS + WRITING,
            Content::Bars(bars) => BAR * bars.len() as f64,
        }
    }
}

/// A text in lines of at most `letters`, unless a word is longer.
fn broken(text: &str, letters: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut().filter(|line| line.chars().count() + 1 + word.chars().count() <= letters) {
            Some(line) => *line += &format!(" {word}"),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Pixels along the edge of a square picture.
fn edge(pixels: &[[u8; 3]]) -> usize {
    pixels.len().isqrt()
}

/// A picture of [`PICTURE_PIXELS`].
fn stretched(pixels: &[[u8; 3]]) -> Vec<[u8; 3]> {
    let edge = edge(pixels);
    let from = |at: usize| at * edge / PICTURE_PIXELS;
    let all = (0..PICTURE_PIXELS).flat_map(|y| (0..PICTURE_PIXELS).map(move |x| (x, y)));
    all.map(|(x, y)| pixels[from(y) * edge + from(x)]).collect()
}

/// Rectangles for all pixels, runs of the same colour together.
fn paint(pixels: &[[u8; 3]], [left, top]: [f64; 2], size: f64) -> Scene {
    let edge = edge(pixels);
    let mut scene = Scene::new(size * edge as f64, size * edge as f64);
    let (mut x, mut y, mut w, mut h, mut fills) = (vec![], vec![], vec![], vec![], vec![]);
    for (row, pixels) in pixels.chunks(edge).enumerate() {
        let mut column = 0;
        for run in pixels.chunk_by(|a, b| a == b) {
            x.push(left + size * column as f64);
            y.push(top + size * row as f64);
            w.push(size * run.len() as f64);
            h.push(size);
            let [r, g, b] = run[0];
            fills.push(Color::Rgb(r, g, b));
            column += run.len();
        }
    }
    scene.elements.push(Primitive::RectBatch { x, y, w, h, fills });
    scene
}

fn draw_key(scene: &mut Scene, key: &Key, [left, top]: [f64; 2]) {
    match key {
        Key::Strip { colours, ticks, label } => {
            for step in 0..EDGE as u32 {
                let [r, g, b] = colours.at((f64::from(step) + 0.5) / EDGE);
                scene.elements.push(rectangle([left + f64::from(step), top], [1.0, STRIP], Color::Rgb(r, g, b)));
            }
            draw_ticks(scene, ticks, [left, top + STRIP], EDGE, label);
        }
        Key::Names(names) => {
            for (number, ([r, g, b], name)) in names.iter().enumerate() {
                let (x, y) = (left + EDGE / 2.0 * (number % 2) as f64, top + LINE * (number / 2) as f64);
                let mut patch = rectangle([x, y], [22.0, 11.0], Color::Rgb(*r, *g, *b));
                if let Primitive::Rect { stroke, stroke_width, .. } = &mut patch {
                    (*stroke, *stroke_width) = (Some(GREY), Some(0.5));
                }
                scene.elements.push(patch);
                scene.elements.push(text([x + 29.0, y + 10.0], LETTERS, TextAnchor::Start, name));
            }
        }
    }
}

/// Numbers below a line of some length, and a label below them.
fn draw_ticks(scene: &mut Scene, ticks: &[(f64, String)], [left, top]: [f64; 2], length: f64, label: &str) {
    for (at, number) in ticks {
        let x = left + at * length;
        scene.elements.push(line([x, top], [x, top + 4.0], BLACK));
        // Numbers at the ends stay within the panel, as others are beside it.
        let anchor = match at {
            ..0.02 => TextAnchor::Start,
            0.98.. => TextAnchor::End,
            _ => TextAnchor::Middle,
        };
        scene.elements.push(text([x, top + 16.0], LETTERS, anchor, number));
    }
    scene.elements.push(text([left + length / 2.0, top + 35.0], LETTERS, TextAnchor::Middle, label));
}

fn draw_columns(scene: &mut Scene, heights: &[f64], [left, top]: [f64; 2], highest: &str) {
    let most = heights.iter().copied().fold(0.0, f64::max);
    let (width, bottom) = ((EDGE - NUMBERS) / heights.len() as f64, top + COLUMNS);
    for (number, height) in heights.iter().enumerate() {
        let height = COLUMNS * height / most;
        let place = [left + width * number as f64, bottom - height];
        scene.elements.push(rectangle(place, [width, height], BLUE));
    }
    for (y, words) in [(top, highest), (bottom, "0")] {
        scene.elements.push(line([left, y], [left + EDGE - NUMBERS, y], if y == top { GREY } else { BLACK }));
        scene.elements.push(text([left - 5.0, y + 4.0], LETTERS, TextAnchor::End, words));
    }
    scene.elements.push(line([left, top], [left, bottom], BLACK));
}

fn draw_bars(scene: &mut Scene, bars: &[Bar], [left, top]: [f64; 2]) {
    let longest = bars.iter().map(|bar| bar.length).fold(0.0, f64::max);
    for (number, bar) in bars.iter().enumerate() {
        let (y, length) = (top + BAR * number as f64, LONGEST * bar.length / longest);
        let (start, middle) = (left + BAR_LEFT, y + 15.0);
        scene.elements.push(text([start - 8.0, middle], LETTERS, TextAnchor::End, &bar.name));
        let colour = if bar.beside { GREY } else { BLUE };
        scene.elements.push(rectangle([start, y], [length, BAR - 12.0], colour));
        scene.elements.push(text([start + length + 7.0, middle], LETTERS, TextAnchor::Start, &bar.number));
    }
    let bottom = top + BAR * bars.len() as f64 - 10.0;
    scene.elements.push(line([left + BAR_LEFT, top - 3.0], [left + BAR_LEFT, bottom], BLACK));
}

fn rectangle([x, y]: [f64; 2], [width, height]: [f64; 2], fill: Color) -> Primitive {
    Primitive::Rect { x, y, width, height, fill, stroke: None, stroke_width: None, opacity: None }
}

fn line([x1, y1]: [f64; 2], [x2, y2]: [f64; 2], stroke: Color) -> Primitive {
    Primitive::Line { x1, y1, x2, y2, stroke, stroke_width: 1.0, stroke_dasharray: None }
}

fn text([x, y]: [f64; 2], size: f64, anchor: TextAnchor, words: &str) -> Primitive {
    let (content, size) = (words.to_owned(), size as u32);
    Primitive::Text { x, y, content, size, anchor, rotate: None, bold: false, color: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(content: Content) -> Sheet {
        let panel = Panel { title: "<a & b>".into(), content };
        Sheet { title: "t".into(), subtitle: "s".into(), panels: vec![panel] }
    }

    #[test]
    fn a_picture_keeps_its_pixels_and_is_one_image_in_svg() {
        let pixels = vec![[255, 0, 0], [0, 255, 0], [0, 0, 255], [9, 9, 9]];
        let whole = stretched(&pixels);
        let half = PICTURE_PIXELS / 2;
        assert_eq!([whole[half - 1], whole[half], whole[half * PICTURE_PIXELS]], [pixels[0], pixels[1], pixels[2]]);
        // One rectangle a run.
        match &paint(&pixels, [0.0; 2], 1.0).elements[..] {
            [Primitive::RectBatch { x, .. }] => assert_eq!(*x, [0.0, 1.0, 0.0, 1.0]),
            other => panic!("{}", other.len()),
        }
        let svg = sheet(Content::Picture { pixels, key: Key::Names(vec![]) }).svg().expect("a sheet");
        assert_eq!(svg.matches("<image ").count(), 1);
        assert!(svg.contains("data:image/png;base64,iVBORw0KGgo") && svg.trim_end().ends_with("</svg>"));
        assert!(svg.contains("&lt;a &amp; b&gt;"), "titles are escaped");
    }

    #[test]
    fn bars_are_as_long_as_their_numbers() {
        let bar = |length: f64| Bar { name: "b".into(), length, number: "1".into(), beside: false };
        let (scene, _) = sheet(Content::Bars(vec![bar(1.0), bar(4.0)])).scene().expect("bars");
        let widths = scene.elements.iter().filter_map(|e| match e {
            Primitive::Rect { width, .. } => Some(*width),
            _ => None,
        });
        assert_eq!(widths.collect::<Vec<_>>(), [LONGEST / 4.0, LONGEST]);
        let nothing = sheet(Content::Bars(vec![bar(0.0)])).png();
        assert_eq!(nothing, Err(Error::Empty { title: "t".into() }));
    }

    #[test]
    fn lines_break_between_words() {
        assert_eq!(broken("one two  three, extraordinarily", 9), ["one two", "three,", "extraordinarily"]);
    }
}
