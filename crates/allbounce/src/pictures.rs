//! Pictures on disk: EXR with linear radiance, PNG for the eye.

use std::{
    io::Cursor,
    path::{Path, PathBuf},
};

use anyhow::Context;
use exr::prelude::{SpecificChannels, Vec2, WritableImage};
use image::{ImageEncoder, codecs::png::PngEncoder};

use relight::{Exposure, Image};

use crate::files;

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
    let (bytes, exposure) = relight::tone_map(picture, exposure.map_or(Exposure::Auto, Exposure::Fixed));
    write_png(path, picture.width, picture.height, &bytes)?;
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

/// Writes 8-bit sRGB, three bytes a pixel.
fn write_png(path: &Path, width: usize, height: usize, srgb: &[u8]) -> anyhow::Result<()> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(srgb, width as u32, height as u32, image::ExtendedColorType::Rgb8)?;
    files::write(path, &bytes)
}
