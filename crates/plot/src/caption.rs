//! Lines of text that stand below a picture.

use kuva::{backend::raster::RasterBackend, render::render::Scene};

use crate::{
    Error,
    colour_bar::{fitting, text},
};

/// Height of a caption of `lines`, pixels.
pub fn caption_height(lines: usize) -> u32 {
    lines as u32 * LINE + BELOW
}

/// From line to line, and below the last.
const LINE: u32 = 15;
const BELOW: u32 = 8;

/// The lines in the middle of a PNG, `width` pixels × [`caption_height`], black on white; long ones in smaller letters.
///
/// # Errors
///
/// [`Error::Painting`] if it could not be drawn.
pub fn caption(lines: &[String], width: u32) -> Result<Vec<u8>, Error> {
    let mut scene = Scene::new(width.into(), caption_height(lines.len()).into());
    for (number, line) in lines.iter().enumerate() {
        let y = f64::from((number as u32 + 1) * LINE);
        scene.elements.push(text(f64::from(width) / 2.0, y, fitting(line, width), line));
    }
    let painted = RasterBackend::new().with_scale(1.0).render_scene(&scene);
    painted.map_err(|reason| Error::Painting { title: lines.join(" "), reason })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_caption_is_as_large_as_it_says() {
        let bytes = caption(&["above".into(), "below, in far more letters than there is room for".into()], 100);
        let [width, height] = [16, 20].map(|at| bytes.as_ref().expect("a picture")[at + 3]);
        assert_eq!([width, height], [100, caption_height(2) as u8]);
    }
}
