//! `allbounce render`: a bake, lights and a camera in, a picture out.

use std::path::PathBuf;

use anyhow::{Context, bail};
use relight::{Image, Look, Operator, PatchSamples, Relighter, Shown};
use scene::{Camera, LightRig, Rays};
use serde::Serialize;

use crate::{
    files, numbers, pictures,
    runtime::{self, Backend, Bake, LightOptions},
    session::Session,
};

/// Linear and encoded pixels, and what the exposure sorts.
const BYTES_A_PIXEL: u64 = 12 + 12 + 4 + 3;

/// A picture of one frame.
///
/// EXR holds linear radiance ρH/π + emission, W/(m² sr); PNG is sRGB with the exposure that the report
/// states. Exit: 0 done, 1 input refused, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    /// Bake of `allbounce bake`, or the last container of the chain
    #[arg(value_name = "BAKE.rad")]
    bake: PathBuf,
    #[command(flatten)]
    light: LightOptions,
    /// Camera, JSON; `scene` takes the first camera of the scene file
    #[arg(long, value_name = "C.json")]
    camera: PathBuf,
    /// Picture, .png or .exr
    #[arg(short, long, value_name = "OUT", value_parser = pictures::target)]
    output: PathBuf,
    /// Pixels in a row
    #[arg(long, default_value_t = 512, value_parser = clap::value_parser!(u16).range(1..=16384))]
    width: u16,
    /// Rows
    #[arg(long, default_value_t = 512, value_parser = clap::value_parser!(u16).range(1..=16384))]
    height: u16,
    /// Primary rays a pixel; the GPU takes 4
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=65536))]
    samples: u32,
    /// Factor on radiance, (m² sr)/W, before a PNG is clipped to white [default: the 95th percentile becomes 0.8]
    #[arg(long, value_name = "X", value_parser = numbers::positive)]
    exposure: Option<f32>,
}

#[derive(Serialize)]
struct Report {
    backend: String,
    bounces: String,
    width: usize,
    height: usize,
    mean_radiance: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    exposure: Option<f32>,
    seconds: f64,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let inputs =
        [("the bake", args.bake.as_path()), ("the lights", args.light.chosen.path()), ("the camera", &args.camera)];
    files::check_outputs(&session.outputs(&args.output), &inputs)?;
    let pixels = u64::from(args.width) * u64::from(args.height);
    session.ask_memory("the picture", pixels * BYTES_A_PIXEL, "make it smaller (--width, --height)")?;
    let bake = Bake::open(&args.bake)?;
    let rig = args.light.rig(&bake, session)?;
    let camera = runtime::camera(&args.camera, &bake.scene)?;
    let operator = bake.operator().with_context(|| args.bake.display().to_string())?;
    let (image, backend) = match args.light.backend {
        Backend::Cpu => (on_cpu(args, &bake, &operator, &rig, &camera, session)?, "cpu".to_owned()),
        Backend::Gpu => {
            let size = [args.width, args.height].map(usize::from);
            crate::gpu::render(&bake, &operator, &rig, &camera, size, args.light.chosen.parts())?
        }
    };
    if !image.pixels.as_flattened().iter().all(|v| v.is_finite()) {
        bail!("{}", runtime::TOO_BRIGHT);
    }
    let exposure = pictures::write(&args.output, &image, args.exposure)?;
    let mean = |c: usize| image.pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / pixels as f64;
    let report = Report {
        backend,
        bounces: runtime::bounces_in_words(operator.bounces()),
        width: image.width,
        height: image.height,
        mean_radiance: std::array::from_fn(mean),
        exposure,
        seconds: session.seconds(),
    };
    session.print("render", &report)?;
    session.finish(&report)
}

fn on_cpu(
    args: &Args,
    bake: &Bake,
    operator: &Operator,
    rig: &LightRig,
    camera: &Camera,
    session: &Session,
) -> anyhow::Result<Image> {
    let rays = Rays::new(&bake.scene.mesh);
    let named = || args.bake.display().to_string();
    let (scene, patches, elements) = (&bake.scene, &bake.patches, &bake.elements);
    let relighter = Relighter::new(scene, &rays, patches, elements, operator, bake.sky()?).with_context(named)?;
    let receivers = bake.receivers().with_context(named)?;
    let light = relighter.direct_light(rig);
    let progress = session.progress();
    let frame = relighter.frame(&light, &PatchSamples::default(), &progress);
    let look = Look {
        width: args.width.into(),
        height: args.height.into(),
        samples: args.samples,
        parts: args.light.chosen.parts(),
        ..Look::default()
    };
    let shown =
        Shown { bake: &relighter, transfer: &bake.transfer, receivers: &receivers, light: &light, frame: &frame };
    Ok(relight::render(&shown, camera, &look, &progress))
}
