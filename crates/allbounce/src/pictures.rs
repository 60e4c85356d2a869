//! Pictures on disk: EXR with linear radiance, PNG for the eye.

use std::{
    io::Cursor,
    path::{Path, PathBuf},
};

use anyhow::{Context, anyhow, bail};
use exr::{
    meta::MetaData,
    prelude::{ReadChannels, ReadLayers, SpecificChannels, Vec2, WritableImage, read},
};
use image::{
    ImageEncoder,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};
use plot::ColourBar;
use relight::{Exposure, Image};

use crate::{files, session::Session};

/// Pixels and bytes of an EXR file while it is read.
const BYTES_READ: u64 = 24;
/// Width of the line between pictures that stand side by side.
const GAP: usize = 8;

/// The kinds of file that a picture can be written to.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Png,
    Exr,
}

/// A file name on the command line that ends in .png or .exr.
pub fn target(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    kind(&path).map(|_| path).ok_or_else(|| "unknown picture format, expected .png or .exr".into())
}

/// A file name on the command line that ends in .png, for pictures with a legend.
pub fn png_target(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if kind(&path) == Some(Kind::Png) { Ok(path) } else { Err("unknown picture format, expected .png".into()) }
}

/// The kind that a file name asks for.
fn kind(path: &Path) -> Option<Kind> {
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "png" => Some(Kind::Png),
        "exr" => Some(Kind::Exr),
        _ => None,
    }
}

/// Writes a picture as its file name asks; returns the exposure of a PNG.
pub fn write(path: &Path, picture: &Image, exposure: Option<f32>) -> anyhow::Result<Option<f32>> {
    if kind(path) == Some(Kind::Exr) {
        write_exr(path, picture)?;
        return Ok(None);
    }
    let (picture, exposure) = Srgb::of(picture, exposure);
    picture.write(path)?;
    Ok(Some(exposure))
}

/// Writes linear radiance.
fn write_exr(path: &Path, picture: &Image) -> anyhow::Result<()> {
    let layer = SpecificChannels::rgb(|Vec2(x, y)| {
        let [r, g, b] = picture.pixels[y * picture.width + x];
        (r, g, b)
    });
    let mut bytes = Cursor::new(Vec::new());
    exr::image::Image::from_channels((picture.width, picture.height), layer)
        .write()
        .to_buffered(&mut bytes)
        .with_context(|| path.display().to_string())?;
    files::write(path, bytes.get_ref())
}

/// Reads linear radiance.
pub fn read_exr(path: &Path, session: &Session) -> anyhow::Result<Image> {
    let name = || path.display().to_string();
    if kind(path) != Some(Kind::Exr) {
        bail!("{}: expected an .exr file; a PNG is tone-mapped and has no numbers to compare", name());
    }
    let bytes = std::fs::read(path).with_context(name)?;
    let broken = |error: exr::error::Error| anyhow!("{}: no readable EXR picture with R, G and B: {error}", name());
    let meta = MetaData::read_from_buffered(Cursor::new(&bytes), false).map_err(broken)?;
    let pixels = meta.headers.iter().map(|h| (h.layer_size.0 as u64).saturating_mul(h.layer_size.1 as u64)).max();
    let need = pixels.unwrap_or(0).saturating_mul(BYTES_READ);
    session.ask_memory(&format!("the picture {}", name()), need, "compare smaller ones")?;
    let new = |size: Vec2<usize>, _: &_| Image { width: size.0, height: size.1, pixels: vec![[0.0; 3]; size.area()] };
    let set = |image: &mut Image, Vec2(x, y): Vec2<usize>, (r, g, b): (f32, f32, f32)| {
        image.pixels[y * image.width + x] = [r, g, b];
    };
    let layer = read().no_deep_data().largest_resolution_level().rgb_channels(new, set).first_valid_layer();
    let read = layer.all_attributes().from_buffered(Cursor::new(&bytes)).map_err(broken)?;
    let image = read.layer_data.channel_data.pixels;
    match image.pixels.as_flattened().iter().all(|v| v.is_finite()) {
        true => Ok(image),
        false => bail!("{}: a pixel is not finite; render it again", name()),
    }
}

/// A picture for the eye: 8-bit sRGB, three bytes a pixel, rows from the top.
#[derive(Clone)]
pub struct Srgb {
    width: usize,
    height: usize,
    bytes: Vec<u8>,
}

impl Srgb {
    /// From colours between 0 and 1 that are encoded already.
    pub fn encoded(width: usize, pixels: &[[f32; 3]]) -> Srgb {
        let bytes = pixels.as_flattened().iter().map(|v| (255.0 * v + 0.5) as u8).collect();
        Srgb { width, height: pixels.len() / width, bytes }
    }

    /// Linear radiance, and the exposure that it was shown with.
    pub fn of(picture: &Image, exposure: Option<f32>) -> (Srgb, f32) {
        let (bytes, exposure) = relight::tone_map(picture, exposure.map_or(Exposure::Auto, Exposure::Fixed));
        (Srgb { width: picture.width, height: picture.height, bytes }, exposure)
    }

    /// With a bar of colours below.
    pub fn with_bar(self, bar: &ColourBar) -> anyhow::Result<Srgb> {
        let drawn = bar.png(self.width as u32)?;
        self.above(&drawn)
    }

    /// With lines of text below.
    pub fn with_caption(self, lines: &[String]) -> anyhow::Result<Srgb> {
        let drawn = plot::caption(lines, self.width as u32)?;
        self.above(&drawn)
    }

    /// With a PNG of the same width below.
    fn above(mut self, png: &[u8]) -> anyhow::Result<Srgb> {
        let drawn = image::load_from_memory(png)?.into_rgb8();
        self.height += drawn.height() as usize;
        self.bytes.extend(drawn.into_raw());
        Ok(self)
    }

    /// Pictures of one size in rows of so many; what is left of the last row is white.
    pub fn grid(tiles: &[Srgb], columns: usize) -> Srgb {
        let (width, height) = tiles.first().map_or((0, 0), |tile| (tile.width, tile.height));
        let blank = Srgb { width, height, bytes: vec![255; 3 * width * height] };
        let place = |at: usize| tiles.get(at).unwrap_or(&blank);
        let row =
            |first: usize| (first + 1..first + columns).fold(place(first).clone(), |row, at| row.beside(place(at)));
        let rows: Vec<Srgb> = (0..tiles.len()).step_by(columns).map(row).collect();
        let width = rows.first().map_or(0, |row| row.width);
        Srgb {
            width,
            height: rows.iter().map(|row| row.height).sum(),
            bytes: rows.into_iter().flat_map(|row| row.bytes).collect(),
        }
    }

    /// With another picture of the same height to the right.
    pub fn beside(&self, right: &Srgb) -> Srgb {
        let row = |picture: &Srgb, y: usize| picture.bytes[3 * y * picture.width..][..3 * picture.width].to_vec();
        let bytes = (0..self.height).flat_map(|y| [row(self, y), vec![255; 3 * GAP], row(right, y)].concat()).collect();
        Srgb { width: self.width + GAP + right.width, height: self.height, bytes }
    }

    /// Writes a PNG file.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let mut bytes = Vec::new();
        let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
        encoder.write_image(&self.bytes, self.width as u32, self.height as u32, image::ExtendedColorType::Rgb8)?;
        files::write(path, &bytes)
    }
}
