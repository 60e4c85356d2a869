//! `allbounce show row`: a row of the form-factor matrix, what one patch sees of each other.

use std::path::PathBuf;

use anyhow::{Context, bail};
use plot::{ColourBar, Colours};
use radfile::{FormFactors, Record};
use serde::Serialize;

use super::view::{Eye, View};
use crate::{
    numbers,
    pictures::{self, Srgb},
    session::Session,
};

/// Powers of ten that the colours span.
const DECADES: i32 = 3;
/// The patch itself; no colour of the bar is like it.
const MARK: [f32; 3] = [0.0, 0.85, 0.95];
/// Patches that it does not see.
const UNSEEN: [f32; 3] = [0.55; 3];
/// Where there is no patch.
const NOTHING: [f32; 3] = [1.0; 3];

/// A row of the form-factor matrix: what one patch sees of each other, on a logarithmic scale of three powers of ten.
///
/// The patch itself is marked blue; those that it does not see are grey.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    eye: Eye,
    /// Number of the patch in this container; each stage may number patches anew
    #[arg(long, value_name = "I", required_unless_present = "pixel", conflicts_with = "pixel")]
    patch: Option<u32>,
    /// The patch that is seen in the middle of a pixel, from the upper left
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pixel: Option<[usize; 2]>,
    /// Picture, .png
    #[arg(short, long, value_name = "OUT", value_parser = pictures::png_target)]
    output: PathBuf,
}

#[derive(Serialize)]
struct Report {
    patch: u32,
    /// In the axes of the scene file, metres.
    position: [f64; 3],
    normal: [f32; 3],
    /// m².
    area: f32,
    patches: usize,
    /// Patches with F > 0.
    patches_it_sees: usize,
    /// Σ_j F_ij.
    row_sum: f64,
    sky: f32,
    largest: f32,
    seconds: f64,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let view = args.eye.look(&[], &args.output, session)?;
    let named = || args.eye.name();
    if !view.container.has("formfactor.values") {
        bail!("{}: there are no form factors; take what `formfactor` made, or bake with --keep-dense", named());
    }
    let factors = FormFactors::read(&view.container).with_context(named)?;
    let patch = chosen(args, &view).with_context(named)?;
    let row = factors.row(patch as usize);
    let largest = row.iter().fold(0.0, |most: f32, f| most.max(*f));
    let colour = |f: f32| Colours::Sequential.at(along(f, largest)).map(|c| f32::from(c) / 255.0);
    let pixels = view.picture(|seen, _| match seen.map(|s| s.patch) {
        None => NOTHING,
        Some(own) if own == patch => MARK,
        Some(other) if row[other as usize] == 0.0 => UNSEEN,
        Some(other) => colour(row[other as usize]),
    });
    Srgb::encoded(view.width, &pixels).with_bar(&bar(patch, largest))?.write(&args.output)?;
    let (at, origin) = (patch as usize, view.scene.mesh.origin);
    let report = Report {
        patch,
        position: std::array::from_fn(|a| f64::from(view.patches.position[at][a]) + origin[a]),
        normal: view.patches.normal[at],
        area: view.patches.area[at],
        patches: row.len(),
        patches_it_sees: row.iter().filter(|f| **f > 0.0).count(),
        row_sum: row.iter().map(|f| f64::from(*f)).sum(),
        sky: factors.sky[at],
        largest,
        seconds: session.seconds(),
    };
    session.print("show row", &report)?;
    session.finish(&report)
}

/// Two numbers with a comma between.
fn pixel(text: &str) -> Result<[usize; 2], String> {
    let numbers = text.split_once(',').and_then(|(x, y)| Some([x.trim().parse().ok()?, y.trim().parse().ok()?]));
    numbers.ok_or_else(|| "expected a pixel such as 200,310".into())
}

/// The patch that was asked for.
fn chosen(args: &Args, view: &View) -> anyhow::Result<u32> {
    let count = view.patches.len();
    match (args.patch, args.pixel) {
        (Some(patch), _) if (patch as usize) < count => Ok(patch),
        (Some(patch), _) => bail!("--patch {patch}: there are {count} patches, expected 0 to {}", count - 1),
        (None, Some([x, y])) if x < view.width && y < view.height => view
            .patch_at([x, y])
            .with_context(|| format!("--pixel {x},{y}: no patch is seen there; choose another pixel")),
        (None, Some([x, y])) => {
            bail!("--pixel {x},{y}: the picture has {} × {} pixels, counted from 0,0", view.width, view.height)
        }
        (None, None) => bail!("which row? --patch or --pixel"),
    }
}

/// Place of a number along the bar, which ends at the largest.
fn along(f: f32, largest: f32) -> f64 {
    1.0 + f64::from(f / largest).log10() / f64::from(DECADES)
}

fn bar(patch: u32, largest: f32) -> ColourBar {
    // Powers of ten, and the largest itself where it is not next to one.
    let top = f64::from(largest).log10();
    // A patch that sees nothing has no scale.
    let decades = if largest > 0.0 { DECADES + 1 } else { 0 };
    let mut ticks: Vec<(f64, String)> = (0..decades)
        .map(|k| top.floor() as i32 - k)
        .filter(|power| f64::from(*power) >= top - f64::from(DECADES))
        .map(|power| (along(10f32.powi(power), largest), numbers::percent(10f64.powi(power))))
        .collect();
    if top - top.floor() > 0.3 {
        ticks.push((1.0, numbers::percent(f64::from(largest))));
    }
    let label = format!("share of what patch {patch} (blue) sees; logarithmic; grey: not seen");
    ColourBar { label, colours: Colours::Sequential, ticks }
}
