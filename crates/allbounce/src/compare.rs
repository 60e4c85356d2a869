//! `allbounce compare`: how far one picture is from another, as a map and in numbers.

use std::path::PathBuf;

use anyhow::bail;
use plot::{ColourBar, Colours};
use radfile::luma;
use relight::Image;
use serde::Serialize;

use crate::{
    files, numbers,
    pictures::{self, Srgb},
    session::Session,
};

/// Differences of pixels darker than this part of the median are relative to it: noise of black is no error.
const DARK: f64 = 0.05;
/// Part of the pixels whose differences the default range of colours holds.
const SHOWN: f64 = 0.99;
/// Where both pictures are black.
const BLACK: [f32; 3] = [0.55; 3];

/// The relative difference of luminance of two pictures, pixel by pixel.
///
/// B − A relative to A, or to 5 % of the median of A where that is more. Pixels that are black in both do not count.
/// Exit: 0 done, 1 input refused, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    /// The picture to compare with, .exr
    #[arg(value_name = "A.exr")]
    a: PathBuf,
    /// The other, .exr of the same size
    #[arg(value_name = "B.exr")]
    b: PathBuf,
    /// Map of the differences, .png: red where B is brighter, blue where it is darker
    #[arg(short, long, value_name = "OUT", value_parser = pictures::png_target)]
    output: PathBuf,
    /// Difference at the ends of the colours, such as 10% [default: 99 % of the pixels are within]
    #[arg(long, value_name = "SHARE", value_parser = numbers::relative_error)]
    range: Option<f64>,
    /// Both pictures side by side as well, .png, with the exposure of A
    #[arg(long, value_name = "FILE", value_parser = pictures::png_target)]
    beside: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report {
    /// Pixels that are not black in both.
    pixels: usize,
    /// Root of the mean square of the relative differences.
    rms: f64,
    /// Their mean.
    bias: f64,
    /// What 99 % of their sizes stay below.
    percentile_99: f64,
    largest: f64,
    /// Where that is, from the upper left.
    largest_at: [usize; 2],
    range: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    exposure: Option<f32>,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let mut outputs = session.outputs(&args.output);
    outputs.extend(args.beside.iter().map(|path| ("--beside", path.as_path())));
    files::check_outputs(&outputs, &[("the first picture", &args.a), ("the second picture", &args.b)])?;
    let a = pictures::read_exr(&args.a, session)?;
    let b = pictures::read_exr(&args.b, session)?;
    if [a.width, a.height] != [b.width, b.height] {
        bail!(
            "{} has {} × {} pixels, {} has {} × {}; render both in one size",
            args.a.display(),
            a.width,
            a.height,
            args.b.display(),
            b.width,
            b.height
        );
    }
    let differences = differences(&a, &b);
    let mut report = measured(&differences, a.width);
    report.range = args.range.unwrap_or_else(|| wide(report.percentile_99));
    let pixels: Vec<[f32; 3]> = differences.iter().map(|d| d.map_or(BLACK, |d| colour(d, report.range))).collect();
    Srgb::encoded(a.width, &pixels).with_bar(&bar(&report))?.write(&args.output)?;
    if let Some(path) = &args.beside {
        let (left, exposure) = Srgb::of(&a, None);
        left.beside(&Srgb::of(&b, Some(exposure)).0).write(path)?;
        report.exposure = Some(exposure);
    }
    session.print("compare", &report)?;
    session.finish(&report)
}

/// (B − A) / A of each pixel; `None` where both are black.
fn differences(a: &Image, b: &Image) -> Vec<Option<f64>> {
    let luminance = |image: &Image| image.pixels.iter().map(|p| f64::from(luma(*p))).collect::<Vec<_>>();
    let (a, b) = (luminance(a), luminance(b));
    let mut lit: Vec<f64> = a.iter().copied().filter(|y| *y > 0.0).collect();
    lit.sort_unstable_by(f64::total_cmp);
    let dark = DARK * lit.get(lit.len() / 2).copied().unwrap_or(1.0);
    let difference = |(a, b): (&f64, &f64)| (*a != 0.0 || *b != 0.0).then(|| (b - a) / a.max(dark));
    a.iter().zip(&b).map(difference).collect()
}

/// The numbers of a map, its rows `width` wide.
fn measured(differences: &[Option<f64>], width: usize) -> Report {
    let lit = || differences.iter().enumerate().filter_map(|(place, d)| d.map(|d| (place, d)));
    let mut sizes: Vec<f64> = lit().map(|(_, d)| d.abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let pixels = sizes.len();
    let mean = |sum: f64| sum / pixels.max(1) as f64;
    let (place, largest) = lit().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or_default();
    let last = ((SHOWN * pixels as f64) as usize).min(pixels.saturating_sub(1));
    Report {
        pixels,
        rms: mean(lit().map(|(_, d)| d * d).sum()).sqrt(),
        bias: mean(lit().map(|(_, d)| d).sum()),
        percentile_99: sizes.get(last).copied().unwrap_or(0.0),
        largest,
        largest_at: [place % width, place / width],
        range: 0.0,
        exposure: None,
    }
}

/// A round number that is not below another.
fn wide(size: f64) -> f64 {
    let power = 10f64.powf(size.max(1e-6).log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power).into_iter().find(|round| *round >= size).unwrap_or(size)
}

fn colour(difference: f64, range: f64) -> [f32; 3] {
    Colours::Diverging.at(0.5 + 0.5 * difference / range).map(|c| f32::from(c) / 255.0)
}

fn bar(report: &Report) -> ColourBar {
    let tick = |at: f64| (0.5 + 0.5 * at, numbers::percent(at * report.range));
    let label =
        format!("relative difference; RMS {}, mean {}", numbers::percent(report.rms), numbers::percent(report.bias));
    ColourBar { label, colours: Colours::Diverging, ticks: [-1.0, -0.5, 0.0, 0.5, 1.0].map(tick).to_vec() }
}
