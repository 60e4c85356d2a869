//! `allbounce show light`: the light of the patches themselves, before anything is gathered from them.

use std::{f32::consts::PI, path::PathBuf};

use anyhow::{Context, bail};
use radfile::{Elements, FormFactors, Patches, Record};
use rayon::prelude::*;
use relight::{DirectLight, Image, PatchSamples};
use scene::{ElementPoints, Surfaces};
use serde::Serialize;

use super::view::{Eye, View};
use crate::{numbers, pictures, runtime, session::Session};

/// Radiance of the patches under lights, one colour a patch.
///
/// Direct light and bounces together, of the packed operator where there is one, otherwise of the dense one, or as
/// many bounces as --bounces says, which takes form factors. EXR holds radiance, W/(m² sr).
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    eye: Eye,
    /// Lights of the frame, JSON; `scene` takes the lights of the scene file
    #[arg(long, value_name = "L.json")]
    lights: PathBuf,
    /// Direct light and the first K bounces; 0 is direct light alone [default: all of the operator]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(0..=100_000))]
    bounces: Option<u32>,
    /// Picture, .png or .exr
    #[arg(short, long, value_name = "OUT", value_parser = pictures::target)]
    output: PathBuf,
    /// Factor on radiance, (m² sr)/W, before a PNG is clipped to white [default: the 95th percentile becomes 0.8]
    #[arg(long, value_name = "X", value_parser = numbers::positive)]
    exposure: Option<f32>,
}

#[derive(Serialize)]
struct Report {
    /// What the bounces were computed from.
    operator: &'static str,
    bounces: String,
    patches: usize,
    /// Irradiance, mean over the area, W/m².
    mean_direct: [f64; 3],
    mean_indirect: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    exposure: Option<f32>,
    seconds: f64,
}

/// Bounced light of the patches, and what it is of.
struct Indirect {
    operator: &'static str,
    bounces: Option<u32>,
    irradiance: Vec<[f32; 3]>,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let named = || args.eye.name();
    let view = args.eye.look(&[("the lights", args.lights.as_path())], &args.output, session)?;
    let rig = runtime::rig(&args.lights, &view.scene, session)?;
    let surfaces = Surfaces::new(&view.scene.mesh, &view.scene.materials).with_context(named)?;
    let light = DirectLight::new(&view.scene, &surfaces, &view.rays, &rig);
    let direct = direct(&view, &light, session).with_context(named)?;
    let indirect = indirect(&view, &direct, args.bounces).with_context(named)?;
    let patches = &view.patches;
    let radiance = |i: usize| -> [f32; 3] {
        std::array::from_fn(|c| {
            let emitted = if light.uses_scene_emission() { patches.emission[i][c] } else { 0.0 };
            (patches.reflectance[i][c] * (direct[i][c] + indirect.irradiance[i][c]) + emitted) / PI
        })
    };
    let colours: Vec<[f32; 3]> = (0..patches.len()).map(radiance).collect();
    if !colours.as_flattened().iter().all(|v| v.is_finite()) {
        bail!("{}", runtime::TOO_BRIGHT);
    }
    let sky = light.sky_radiance().map(|v| v as f32);
    let pixels = view.picture(|seen, _| seen.map_or(sky, |seen| colours[seen.patch as usize]));
    let image = Image { width: view.width, height: view.height, pixels };
    let exposure = pictures::write(&args.output, &image, args.exposure)?;
    let report = Report {
        operator: indirect.operator,
        bounces: runtime::bounces_in_words(indirect.bounces),
        patches: patches.len(),
        mean_direct: mean(patches, &direct),
        mean_indirect: mean(patches, &indirect.irradiance),
        exposure,
        seconds: session.seconds(),
    };
    session.print("show light", &report)?;
    session.finish(&report)
}

/// Direct irradiance of the patches.
fn direct(view: &View, light: &DirectLight, session: &Session) -> anyhow::Result<Vec<[f32; 3]>> {
    let elements = Elements::read_or_whole(&view.container, &view.patches)?;
    let (samples, sky) = (PatchSamples::default(), radfile::read_sky(&view.container)?);
    let points = ElementPoints::new(&view.scene.mesh, &view.patches, &elements, samples.points);
    let of_elements = relight::element_irradiance(light, &elements, &points, sky, samples.area, &session.progress());
    Ok(elements.mean(&of_elements))
}

/// Bounced light: the first `bounces`, or all of the operator.
fn indirect(view: &View, direct: &[[f32; 3]], bounces: Option<u32>) -> anyhow::Result<Indirect> {
    let (container, patches) = (&view.container, &view.patches);
    let has = |section: &str| container.has(section);
    Ok(match bounces {
        Some(0) => Indirect { operator: "none", bounces, irradiance: vec![[0.0; 3]; patches.len()] },
        Some(_) if !has("formfactor.values") => {
            bail!(
                "--bounces needs the form factors, which are not there; take what an earlier stage made, or bake with --keep-dense"
            )
        }
        Some(count) => {
            let irradiance = relight::bounces(patches, &FormFactors::read(container)?, direct, count);
            Indirect { operator: "form factors", bounces, irradiance }
        }
        None if relight::Operator::is_in(container) => {
            let operator = relight::Operator::read(container)?;
            if operator.patches() != patches.len() {
                bail!("the operator is of {} patches, the list has {}", operator.patches(), patches.len());
            }
            let irradiance = relight::indirect(patches, &operator, direct);
            Indirect { operator: "packed", bounces: operator.bounces(), irradiance }
        }
        None if has("series.values") => {
            let operator = radfile::Operator::read(container)?;
            let irradiance = of_dense(patches, &operator, direct);
            Indirect { operator: "dense", bounces: operator.bounces, irradiance }
        }
        None => bail!(
            "there is no operator of bounces yet; take what `series` or a later stage made, or ask for --bounces K"
        ),
    })
}

/// A^{-1/2} K A^{1/2} ρ H⁰ with the dense K, docs/theory.md (4.3).
fn of_dense(patches: &Patches, operator: &radfile::Operator, direct: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let root = |i: usize| f64::from(patches.area[i]).sqrt();
    let sent = |c: usize| -> Vec<f64> {
        (0..operator.n).map(|j| root(j) * f64::from(patches.reflectance[j][c]) * f64::from(direct[j][c])).collect()
    };
    let sent = [0, 1, 2].map(sent);
    let received = |i: usize, c: usize| {
        let row = &operator.channel(c)[i * operator.n..][..operator.n];
        let sum: f64 = row.iter().zip(&sent[c]).map(|(k, x)| f64::from(*k) * x).sum();
        (sum / root(i)) as f32
    };
    (0..operator.n).into_par_iter().map(|i| std::array::from_fn(|c| received(i, c))).collect()
}

fn mean(patches: &Patches, values: &[[f32; 3]]) -> [f64; 3] {
    let area: f64 = patches.area.iter().map(|a| f64::from(*a)).sum();
    std::array::from_fn(|c| {
        let weighed = values.iter().zip(&patches.area).map(|(v, a)| f64::from(v[c]) * f64::from(*a));
        weighed.sum::<f64>() / area
    })
}
