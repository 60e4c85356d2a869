//! `allbounce show patches`: each patch in a colour of its own.

use std::path::PathBuf;

use serde::Serialize;

use super::view::Eye;
use crate::{
    pictures::{self, Srgb},
    session::Session,
};

/// Where no patch is seen.
const NOTHING: [f32; 3] = [1.0; 3];
/// How much of a colour is left at borders, and where the surface is seen edge-on.
const BORDER: f32 = 0.35;
const EDGE_ON: f32 = 0.75;
/// Steps through the colours for each patch: parts of the circle that never come close again (golden ratio).
const HUE_STEP: f32 = 0.618_034;
/// How light the colours are, in turn.
const LIGHTNESS: [f32; 3] = [0.95, 0.8, 0.65];
const SATURATION: f32 = 0.45;

/// Each patch in a colour of its own, with its border.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    eye: Eye,
    /// Picture, .png
    #[arg(short, long, value_name = "OUT", value_parser = pictures::png_target)]
    output: PathBuf,
}

#[derive(Serialize)]
struct Report {
    patches: usize,
    patches_seen: usize,
    seconds: f64,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let view = args.eye.look(&[], &args.output, session)?;
    let pixels = view.picture(|seen, border| {
        seen.map_or(NOTHING, |seen| {
            let light = (EDGE_ON + (1.0 - EDGE_ON) * seen.facing) * if border { BORDER } else { 1.0 };
            colour(seen.patch).map(|c| light * c)
        })
    });
    Srgb::encoded(view.width, &pixels).write(&args.output)?;
    let (patches, patches_seen) = (view.patches.len(), view.count_seen());
    let report = Report { patches, patches_seen, seconds: session.seconds() };
    session.print("show patches", &report)?;
    session.finish(&report)
}

/// Colours of consecutive patches are far apart.
fn colour(patch: u32) -> [f32; 3] {
    let hue = (patch as f32 * HUE_STEP).fract();
    let value = LIGHTNESS[patch as usize % LIGHTNESS.len()];
    // From the hexagon of hues, as HSV has them: each primary is full on a third of the circle.
    [0.0, 2.0 / 3.0, 1.0 / 3.0].map(|primary: f32| {
        let full = (((hue + primary).fract() * 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
        value * (1.0 - SATURATION + SATURATION * full)
    })
}
