//! Linear radiance to 8-bit sRGB with a stated exposure.
//!
//! Source of the transfer curve: IEC 61966-2-1.

use crate::Image;

/// Share of pixels that stay below [`BRIGHT`].
const PERCENTILE: f64 = 0.95;
/// Linear value that the automatic exposure gives to that percentile.
const BRIGHT: f32 = 0.8;

/// What radiance is multiplied by before it is clipped to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// The 95th percentile of luminance becomes 0.8.
    Auto,
    /// This factor, (m² sr)/W.
    Fixed(f32),
}

/// Three bytes a pixel, rows from the top, and the exposure that was used.
pub fn tone_map(image: &Image, exposure: Exposure) -> (Vec<u8>, f32) {
    let exposure = match exposure {
        Exposure::Fixed(exposure) => exposure,
        Exposure::Auto => automatic(image),
    };
    let bytes = image.pixels.iter().flatten().map(|v| (255.0 * srgb(exposure * v) + 0.5) as u8).collect();
    (bytes, exposure)
}

fn automatic(image: &Image) -> f32 {
    let luminance = |[r, g, b]: &[f32; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let mut values: Vec<f32> = image.pixels.iter().map(luminance).collect();
    values.sort_unstable_by(f32::total_cmp);
    let at = (PERCENTILE * values.len() as f64) as usize;
    // Where all but a few pixels are black, those few are what is shown.
    match values.get(at).filter(|v| **v > 0.0).or(values.last()) {
        Some(&v) if v > 0.0 => BRIGHT / v,
        _ => 1.0,
    }
}

fn srgb(linear: f32) -> f32 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(values: &[f32]) -> Image {
        Image { width: values.len(), height: 1, pixels: values.iter().map(|v| [*v; 3]).collect() }
    }

    #[test]
    fn linear_values_take_the_srgb_curve_and_are_clipped() {
        // 0.25 is 0.5371 in sRGB, which is 136.96 of 255.
        let (bytes, exposure) = tone_map(&image(&[0.0, 0.125, 0.5, 7.0]), Exposure::Fixed(2.0));
        assert_eq!(exposure, 2.0);
        assert_eq!(bytes, [0, 0, 0, 137, 137, 137, 255, 255, 255, 255, 255, 255]);
    }

    #[test]
    fn automatic_exposure_ignores_the_brightest_twentieth() {
        let mut values: Vec<f32> = (0..100).map(|i| i as f32 * 0.02).collect();
        values[99] = 1e6;
        let (_, exposure) = tone_map(&image(&values), Exposure::Auto);
        assert!((exposure * 1.9 - 0.8).abs() < 1e-4, "{exposure}");
        assert_eq!(tone_map(&image(&[0.0; 4]), Exposure::Auto), (vec![0; 12], 1.0));
        assert_eq!(tone_map(&image(&[]), Exposure::Auto).1, 1.0);
    }
}
