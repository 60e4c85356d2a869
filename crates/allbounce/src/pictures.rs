//! Pictures on disk: EXR with linear radiance, PNG for the eye.

use std::path::Path;

use anyhow::{Context, bail};
use exr::prelude::write_rgb_file;
use image::{ImageEncoder, codecs::png::PngEncoder};

use relight::Image;

use crate::files;

/// The kinds of file that a picture can be written to.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    Png,
    Exr,
}

/// The kind that a file name asks for.
pub fn kind(path: &Path) -> anyhow::Result<Kind> {
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("png") => Ok(Kind::Png),
        Some("exr") => Ok(Kind::Exr),
        _ => bail!("{}: unknown picture format, expected .png or .exr", path.display()),
    }
}

/// Writes linear radiance.
pub fn write_exr(path: &Path, picture: &Image) -> anyhow::Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let temporary =
        tempfile::Builder::new().suffix(".exr").tempfile_in(folder).with_context(|| path.display().to_string())?;
    let pixel = |x: usize, y: usize| {
        let [r, g, b] = picture.pixels[y * picture.width + x];
        (r, g, b)
    };
    write_rgb_file(temporary.path(), picture.width, picture.height, pixel)
        .with_context(|| path.display().to_string())?;
    files::write(path, &std::fs::read(temporary.path())?)
}

/// Writes 8-bit sRGB, three bytes a pixel.
pub fn write_png(path: &Path, width: usize, height: usize, srgb: &[u8]) -> anyhow::Result<()> {
    files::write_with(path, |file| {
        let encoder = PngEncoder::new(std::io::BufWriter::new(file));
        encoder.write_image(srgb, width as u32, height as u32, image::ExtendedColorType::Rgb8)?;
        Ok(())
    })
}
