//! `allbounce reference`: a scene file and lights in, path-traced truth out.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};
use reference::{PathTracer, PointEstimate, Sampling, Stop};
use relight::Image;
use scene::{ImportOptions, Rays, Scene, Surfaces};
use serde::Serialize;

use crate::{
    csv_points::{ANSWERS, Points},
    files::{self, DiskFolder},
    numbers, pictures, runtime,
    session::Session,
};

/// The columns that path tracing adds to [`ANSWERS`]: light of one bounce, standard errors, paths.
pub const FURTHER: [&str; 13] = [
    "single_r",
    "single_g",
    "single_b",
    "se_direct_r",
    "se_direct_g",
    "se_direct_b",
    "se_single_r",
    "se_single_g",
    "se_single_b",
    "se_indirect_r",
    "se_indirect_g",
    "se_indirect_b",
    "samples",
];
/// Tallies and answers, as they are while a round of paths ends.
pub const BYTES_A_POINT: u64 = 1024;
const BYTES_A_PIXEL: u64 = 256;
/// Paths of a point where nothing is asked.
const POINT_SAMPLES: u32 = 4096;
/// Paths of a pixel where nothing is asked.
const PIXEL_SAMPLES: u32 = 64;

/// Path-trace a scene: the truth to hold a bake against.
///
/// No patches, no operator: paths at random, with the standard error of every answer. Points get
/// px,py,pz,nx,ny,nz and direct, indirect as relight writes them, then single (exactly one bounce), the standard
/// errors se_direct, se_single, se_indirect, and samples. Exit: 0 done, 1 input refused, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    /// Scene: .obj (with .mtl), .gltf or .glb; metres
    scene: PathBuf,
    /// Lights of the frame, JSON; `scene` takes the lights of the scene file
    #[arg(long, value_name = "L.json")]
    lights: PathBuf,
    /// Points with px,py,pz,nx,ny,nz in the scene file's axes, metres
    #[arg(long, value_name = "P.csv", required_unless_present = "camera", conflicts_with = "camera")]
    points: Option<PathBuf>,
    /// Camera, JSON, for a picture; `scene` takes the first camera of the scene file
    #[arg(long, value_name = "C.json")]
    camera: Option<PathBuf>,
    /// Where the answers go: CSV for points, .png or .exr for a picture
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Pixels in a row
    #[arg(long, conflicts_with = "points", default_value_t = 512, value_parser = clap::value_parser!(u16).range(1..=16384))]
    width: u16,
    /// Rows
    #[arg(long, conflicts_with = "points", default_value_t = 512, value_parser = clap::value_parser!(u16).range(1..=16384))]
    height: u16,
    /// Paths for each point or pixel, rounded up to whole batches of at most 64 [default: 4096 a point, 64 a pixel]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1 << 30))]
    samples: Option<u32>,
    /// Go on until the standard error of luminance is at most this part of it, or of 5 % of the mean of all points
    /// (pixels) where that is more; points: of direct and of indirect light. Such as 1%
    #[arg(long, value_name = "SHARE", value_parser = numbers::relative_error, conflicts_with = "samples")]
    rel_error: Option<f64>,
    /// Paths after which --rel-error gives a point or pixel up
    #[arg(long, value_name = "N", requires = "rel_error", conflicts_with = "samples", default_value_t = 1 << 18, value_parser = clap::value_parser!(u32).range(2..=1 << 30))]
    max_samples: u32,
    /// Chooses the paths: same seed, same file; other seeds, independent errors
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u32,
    /// Back sides neither reflect nor receive (emission always leaves the front)
    #[arg(long)]
    one_sided: bool,
    /// Factor on radiance, (m² sr)/W, before a PNG is clipped to white [default: the 95th percentile becomes 0.8]
    #[arg(long, value_name = "X", conflicts_with = "points", value_parser = numbers::positive)]
    exposure: Option<f32>,
}

#[derive(Serialize)]
struct Report<T: Serialize> {
    stop: String,
    seed: u32,
    #[serde(flatten)]
    numbers: T,
    #[serde(skip_serializing_if = "Option::is_none")]
    exposure: Option<f32>,
    rays_per_second: f64,
    seconds: f64,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let mut inputs = vec![("the scene", args.scene.as_path()), ("the lights", &args.lights)];
    inputs.extend(args.points.iter().map(|p| ("the points", p.as_path())));
    inputs.extend(args.camera.iter().map(|c| ("the camera", c.as_path())));
    files::check_outputs(&session.outputs(&args.output), &inputs)?;
    if args.camera.is_some() {
        let name = args.output.to_str().unwrap_or("");
        pictures::target(name).map_err(|what| anyhow!("{}: {what}", args.output.display()))?;
    }
    let (folder, name) = DiskFolder::of(&args.scene)?;
    let named = || args.scene.display().to_string();
    let (scene, imported) =
        scene::import(&name, &folder, ImportOptions { one_sided: args.one_sided }).with_context(named)?;
    imported.warnings.iter().for_each(|warning| session.warn(warning));
    let rig = runtime::rig(&args.lights, &scene, session)?;
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials).with_context(named)?;
    let rays = Rays::new(&scene.mesh);
    let tracer = PathTracer::new(&scene, &surfaces, &rays, &rig);
    match (&args.points, &args.camera) {
        (Some(points), _) => trace_points(args, points, &tracer, session),
        (None, Some(camera)) => trace_picture(args, camera, &scene, &tracer, session),
        (None, None) => bail!("nothing to evaluate, expected --points or --camera"),
    }
}

fn trace_points(args: &Args, path: &Path, tracer: &PathTracer, session: &Session) -> anyhow::Result<()> {
    let answers: Vec<&str> = ANSWERS.into_iter().chain(FURTHER).collect();
    let points = Points::read(path, &answers)?;
    session.ask_memory("the points", points.position.len() as u64 * BYTES_A_POINT, "ask for fewer points at once")?;
    let start = session.seconds();
    let sampling = args.sampling(POINT_SAMPLES);
    let (light, numbers) = tracer.points(&points.position, &points.normal, &sampling, &session.progress());
    let seconds = session.seconds() - start;
    if !light.iter().all(is_finite) {
        bail!("{}", runtime::TOO_BRIGHT);
    }
    points.write(&args.output, &answers, |i| row(&light[i]))?;
    if numbers.points_short_of_error > 0 {
        session.warn(&format!(
            "{} of {} points are less sure than asked after {} paths each; raise --max-samples",
            numbers.points_short_of_error, numbers.points, args.max_samples
        ));
    }
    let rays = numbers.rays;
    args.finish(numbers, None, rays as f64 / seconds, session)
}

fn trace_picture(
    args: &Args,
    camera: &Path,
    scene: &Scene,
    tracer: &PathTracer,
    session: &Session,
) -> anyhow::Result<()> {
    let size = [args.width.into(), args.height.into()];
    let pixels = u64::from(args.width) * u64::from(args.height);
    session.ask_memory("the picture", pixels * BYTES_A_PIXEL, "make it smaller (--width, --height)")?;
    let camera = runtime::camera(camera, scene)?;
    let start = session.seconds();
    let sampling = args.sampling(PIXEL_SAMPLES);
    let (picture, numbers) = tracer.picture(&camera, size, &sampling, &session.progress());
    let seconds = session.seconds() - start;
    if !picture.pixels.as_flattened().iter().all(|v| v.is_finite()) {
        bail!("{}", runtime::TOO_BRIGHT);
    }
    let image = Image { width: picture.width, height: picture.height, pixels: picture.pixels };
    let exposure = pictures::write(&args.output, &image, args.exposure)?;
    let rays = numbers.rays;
    args.finish(numbers, exposure, rays as f64 / seconds, session)
}

impl Args {
    fn sampling(&self, default: u32) -> Sampling {
        let stop = match self.rel_error {
            Some(error) => Stop::RelativeError { error, max_samples: self.max_samples },
            None => Stop::Samples(self.samples.unwrap_or(default)),
        };
        Sampling { stop, seed: self.seed }
    }

    fn stop(&self) -> String {
        match (self.rel_error, self.samples) {
            (Some(error), _) => format!("--rel-error {}% --max-samples {}", 100.0 * error, self.max_samples),
            (None, Some(samples)) => format!("--samples {samples}"),
            (None, None) => format!("--samples {}", if self.points.is_some() { POINT_SAMPLES } else { PIXEL_SAMPLES }),
        }
    }

    fn finish<T: Serialize>(
        &self,
        numbers: T,
        exposure: Option<f32>,
        rays_per_second: f64,
        session: &Session,
    ) -> anyhow::Result<()> {
        let (stop, seed, seconds) = (self.stop(), self.seed, session.seconds());
        let report = Report { stop, seed, numbers, exposure, rays_per_second, seconds };
        session.print("reference", &report)?;
        session.finish(&report)
    }
}

pub fn is_finite(light: &PointEstimate) -> bool {
    let all = [light.direct, light.single, light.indirect];
    all.iter().all(|m| m.value.iter().chain(&m.error).all(|v| (*v as f32).is_finite()))
}

/// The columns [`ANSWERS`] and [`FURTHER`] of one point, in single precision as relight writes them.
pub fn row(light: &PointEstimate) -> Vec<String> {
    let PointEstimate { direct, single, indirect, samples } = light;
    let colours =
        [direct.value, indirect.value, single.value, direct.error, single.error, indirect.error].into_iter().flatten();
    colours.map(|v| (v as f32).to_string()).chain([samples.to_string()]).collect()
}
