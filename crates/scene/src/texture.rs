//! Decoded images: sRGB texels to linear light, bilinear between them.
//!
//! Source of the transfer curve: IEC 61966-2-1 (sRGB). Coordinates are those of glTF: (0, 0) is the outer
//! corner of the first texel of the first row, (1, 1) that of the last.

use std::{io::Cursor, sync::LazyLock};

use image::{ImageReader, Limits};
use radfile::Wrap;

/// Largest width and height of a texture, texels.
const MAX_SIDE: u32 = 16384;
/// Largest memory that decoding one texture may take, bytes.
const MAX_MEMORY: u64 = 1 << 30;

/// Linear light of every sRGB byte.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let s = byte as f64 / 255.0;
        (if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }) as f32
    })
});

/// A decoded image.
pub struct Image {
    width: usize,
    height: usize,
    /// Rows from the top, sRGB bytes.
    texels: Vec<[u8; 3]>,
}

impl Image {
    /// Decodes PNG or JPEG; says in words why not. Alpha is dropped.
    pub fn decode(bytes: &[u8]) -> Result<Image, String> {
        let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
        let mut limits = Limits::default();
        (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
        limits.max_alloc = Some(MAX_MEMORY);
        reader.limits(limits);
        let image = reader.decode().map_err(|e| e.to_string())?.into_rgb8();
        let (width, height) = (image.width() as usize, image.height() as usize);
        if width == 0 || height == 0 {
            return Err("it has no texels".into());
        }
        Ok(Image { width, height, texels: image.into_raw().as_chunks().0.to_vec() })
    }

    /// Linear RGB at `uv`. Coordinates that are not finite count as 0.
    pub fn sample(&self, uv: [f32; 2], wrap: [Wrap; 2]) -> [f32; 3] {
        let (x, fx) = neighbours(uv[0], self.width, wrap[0]);
        let (y, fy) = neighbours(uv[1], self.height, wrap[1]);
        let texel = |x: usize, y: usize| self.texels[y * self.width + x].map(|byte| LINEAR[byte as usize]);
        let corners = [texel(x[0], y[0]), texel(x[1], y[0]), texel(x[0], y[1]), texel(x[1], y[1])];
        std::array::from_fn(|c| {
            let top = corners[0][c] + (corners[1][c] - corners[0][c]) * fx;
            let bottom = corners[2][c] + (corners[3][c] - corners[2][c]) * fx;
            top + (bottom - top) * fy
        })
    }

    /// The largest linear value of each channel.
    pub fn brightest(&self) -> [f32; 3] {
        let largest = |m: [u8; 3], t: &[u8; 3]| std::array::from_fn(|c| m[c].max(t[c]));
        self.texels.iter().fold([0; 3], largest).map(|byte| LINEAR[byte as usize])
    }
}

/// The two texels of a row or column of `n` around a coordinate, and how far it is towards the second.
fn neighbours(coordinate: f32, n: usize, wrap: Wrap) -> ([usize; 2], f32) {
    let c = if coordinate.is_finite() { f64::from(coordinate) } else { 0.0 };
    let within = match wrap {
        Wrap::Repeat => c.rem_euclid(1.0),
        Wrap::Mirror => 1.0 - (c.rem_euclid(2.0) - 1.0).abs(),
        Wrap::Clamp => c.clamp(0.0, 1.0),
    };
    let position = within * n as f64 - 0.5;
    let (low, fraction) = (position.floor(), position - position.floor());
    let inside = |i: i64| match wrap {
        Wrap::Repeat => i.rem_euclid(n as i64) as usize,
        // A mirrored border repeats its texel, just as a clamped one does.
        Wrap::Mirror | Wrap::Clamp => i.clamp(0, n as i64 - 1) as usize,
    };
    ([inside(low as i64), inside(low as i64 + 1)], fraction as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(texels: &[u8]) -> Image {
        Image { width: texels.len(), height: 1, texels: texels.iter().map(|&t| [t; 3]).collect() }
    }

    fn at(image: &Image, u: f32, wrap: Wrap) -> f32 {
        image.sample([u, 0.5], [wrap; 2])[0]
    }

    #[test]
    fn srgb_bytes_become_linear_light() {
        assert_eq!((LINEAR[0], LINEAR[255]), (0.0, 1.0));
        assert!((LINEAR[188] - 0.502_886_5).abs() < 1e-6, "{}", LINEAR[188]);
        assert!((LINEAR[10] - 10.0 / 255.0 / 12.92).abs() < 1e-9, "below the knee the curve is straight");
    }

    #[test]
    fn texel_centres_give_the_texel_and_the_middle_between_two_their_mean() {
        let image = row(&[0, 255, 255, 0]);
        assert_eq!(at(&image, 0.125, Wrap::Repeat), 0.0);
        assert_eq!(at(&image, 0.375, Wrap::Repeat), 1.0);
        assert_eq!(at(&image, 0.25, Wrap::Repeat), 0.5, "the mean is taken of light, not of bytes");
    }

    #[test]
    fn the_first_row_is_at_v_zero() {
        let image = Image { width: 1, height: 2, texels: vec![[255; 3], [0; 3]] };
        assert_eq!(image.sample([0.5, 0.25], [Wrap::Clamp; 2])[0], 1.0);
        assert_eq!(image.sample([0.5, 0.75], [Wrap::Clamp; 2])[0], 0.0);
    }

    #[test]
    fn wrapping_goes_on_beyond_the_border_as_asked() {
        let image = row(&[0, 255]);
        assert_eq!([at(&image, 1.25, Wrap::Repeat), at(&image, 1.75, Wrap::Repeat)], [0.0, 1.0]);
        assert_eq!([at(&image, 1.25, Wrap::Mirror), at(&image, 1.75, Wrap::Mirror)], [1.0, 0.0]);
        assert_eq!([at(&image, -0.25, Wrap::Mirror), at(&image, -0.75, Wrap::Mirror)], [0.0, 1.0]);
        assert_eq!([at(&image, 7.0, Wrap::Clamp), at(&image, -7.0, Wrap::Clamp)], [1.0, 0.0]);
        assert_eq!(at(&image, 0.0, Wrap::Repeat), 0.5, "the first and last texel meet");
        assert_eq!(at(&image, 0.0, Wrap::Mirror), 0.0);
    }

    #[test]
    fn wild_coordinates_neither_panic_nor_leave_the_image() {
        let image = row(&[9, 9, 9]);
        for u in [f32::NAN, f32::INFINITY, f32::MAX, f32::MIN, 1e20, -1e20, 0.999_999_94, -1e-30] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                assert!((at(&image, u, wrap) - LINEAR[9]).abs() < 1e-9, "{u} {wrap:?}");
            }
        }
    }

    #[test]
    fn what_is_no_png_or_jpeg_is_refused_in_words() {
        for bytes in [&b""[..], b"GIF89a", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff\xe0"] {
            assert!(!Image::decode(bytes).err().expect("not an image").is_empty());
        }
    }
}
