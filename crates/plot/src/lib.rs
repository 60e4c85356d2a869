//! Line charts and sheets of pictures and bars as SVG and PNG, and colour bars and captions of pictures.
//!
//! One kind of picture, on linear or logarithmic axes: a few named curves with markers, and a legend beside them.
//! A chart is a value; [`Chart::svg`] and [`Chart::png`] draw it, and the same value gives the same bytes. kuva does
//! the drawing; nothing outside this crate knows it. The eight colours are those of M. Okabe and K. Ito, "Color
//! universal design" (2008), which every eye can tell apart. What is no curve, such as the entries of a matrix, stands on a
//! [`Sheet`].

mod base64;
mod caption;
mod colour_bar;
mod draw;
mod error;
mod front;
mod sheet;

pub use caption::{caption, caption_height};
pub use colour_bar::{BAR_HEIGHT, ColourBar, Colours};
pub use error::Error;
pub use front::front;
pub use sheet::{Bar, Content, Key, PICTURE_PIXELS, Panel, Sheet};

/// A chart with one pair of axes.
#[derive(Clone, Debug)]
pub struct Chart {
    /// What is seen.
    pub title: String,
    /// Under what circumstances, in smaller letters.
    pub subtitle: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Curves, in the order of the legend.
    pub series: Vec<Series>,
}

/// One axis.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// How values become lengths.
    pub scale: Scale,
    /// First and last value that are shown.
    pub range: [f64; 2],
    /// How the values of ticks are written.
    pub ticks: Ticks,
}

/// How values become lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// In proportion.
    Linear,
    /// By their logarithm; ticks at powers of ten.
    Log,
}

/// How the values of ticks are written.
#[derive(Clone, Copy, Debug)]
pub enum Ticks {
    /// 0.001, 1, 100; beyond as powers of ten.
    Plain,
    /// 0.1 %, 1 %, 100 %; beyond as powers of ten. The values are fractions of 1.
    Percent,
    /// By the caller, for axes that are scaled by one quantity and read as another.
    Words(fn(f64) -> String),
}

/// A named curve.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend; an empty one keeps it out of there.
    pub name: String,
    /// Horizontal and vertical value of every point. A vertical value that is not finite interrupts the curve.
    pub points: Vec<[f64; 2]>,
    /// Number of the colour, counted round by eight.
    pub colour: usize,
    /// How the line is drawn.
    pub stroke: Stroke,
    /// Shape of the points.
    pub marker: Marker,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// Unbroken.
    Solid,
    /// Long dashes.
    Dashed,
    /// Dots.
    Dotted,
    /// Points only.
    None,
}

/// Shape of the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// Line only.
    None,
    /// Disc.
    Circle,
    /// Square.
    Square,
    /// Triangle.
    Triangle,
    /// Diagonal cross.
    Cross,
}

impl Chart {
    /// The chart as SVG. Letters are text in a usual font without serifs.
    ///
    /// # Errors
    ///
    /// [`Error`] if there is nothing to draw, or an axis cannot show what it should.
    pub fn svg(&self) -> Result<String, Error> {
        draw::svg(self)
    }

    /// The chart as PNG, two pixels for each unit of the SVG.
    ///
    /// # Errors
    ///
    /// As [`Chart::svg`].
    pub fn png(&self) -> Result<Vec<u8>, Error> {
        draw::png(self)
    }
}
