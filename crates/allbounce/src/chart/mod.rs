//! `allbounce chart`: every method on one scene under one light after another, speed against accuracy.
//!
//! - `receivers.rs`: where light is asked for; `truth.rs`: what it is there, path-traced.
//! - `contestants.rs`: the table of methods. `baked.rs`: the stages of a bake; `ours.rs`, `published.rs`, `paths.rs`: one
//!   method each. The others are in [`reference::rivals`].
//! - `judge.rs`: times an entry and holds it to the truth (`score.rs`).
//! - `sheet.rs`: the table as CSV and Markdown; `picture.rs`: the charts; `side_by_side.rs`: what a camera sees by the light of
//!   each method.

mod baked;
mod contestants;
mod ground;
mod judge;
mod ours;
mod paths;
mod picture;
mod published;
pub mod receivers;
pub mod score;
mod sheet;
mod side_by_side;
pub mod truth;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::builder::PossibleValuesParser;
use reference::rivals::Setting;
use scene::{ImportOptions, Rays, Surfaces};
use serde::Serialize;

use crate::{
    csv_points::Points,
    files::{self, DiskFolder},
    numbers, runtime,
    session::Session,
};
use contestants::{ALL, Contestant};
use ground::Ground;
use judge::{Choice, Entry, Judge, LeftOut};
use side_by_side::{Eye, Sight};
use truth::Truth;

/// Receivers where none are given, and with --quick.
const RECEIVERS: [u32; 2] = [2000, 200];
/// Standard error of the truth where none is asked for, and with --quick.
const TRUTH_ERROR: [f64; 2] = [0.01, 0.05];

/// Chart every method on a scene: time of a change of the lights, memory and bake against error.
///
/// Light is asked for at points of the scene's surfaces and held to path-traced truth. Writes chart.csv, chart.md, chart.svg
/// and chart.png (error against time), memory.svg and memory.png (error against memory), and truth.csv, which --truth
/// takes. With --camera also side-by-side.png: indirect light as a camera sees it by one setting of each method, beside the
/// truth. Exit: 0 done, 1 input refused, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    /// Scene: .obj (with .mtl), .gltf or .glb; metres
    scene: PathBuf,
    /// Lights of a frame, JSON; several count alike; `scene` takes the lights of the scene file
    #[arg(long, value_name = "L.json", value_delimiter = ',', required = true)]
    lights: Vec<PathBuf>,
    /// Folder that the files go to; it is made if it is not there
    #[arg(short, long, value_name = "OUTDIR")]
    output: PathBuf,
    /// Which methods [default: all]
    #[arg(long, value_name = "METHOD", value_delimiter = ',', value_parser = PossibleValuesParser::new(ALL.iter().map(|c| c.name)))]
    methods: Vec<String>,
    /// Few settings of each, few receivers, rough truth
    #[arg(long)]
    quick: bool,
    /// Points with light of the scene's surfaces, chosen by area [default: 2000, with --quick 200]
    #[arg(long, value_name = "N", conflicts_with_all = ["points", "truth"], value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    receivers: Option<u32>,
    /// Ask for light at these points instead: px,py,pz,nx,ny,nz in the scene file's axes, metres
    #[arg(long, value_name = "P.csv", conflicts_with = "truth")]
    points: Option<PathBuf>,
    /// Points and their light, as `reference` and `chart` write them, instead of tracing it; one a lights file
    #[arg(long, value_name = "T.csv", value_delimiter = ',')]
    truth: Vec<PathBuf>,
    /// Standard error of the traced truth, relative as with `reference --rel-error`; pixels of --camera take at least 5% [default: 1%, with --quick 5%]
    #[arg(long, value_name = "SHARE", value_parser = numbers::relative_error, conflicts_with = "truth")]
    truth_error: Option<f64>,
    /// Draw what this camera sees of the first lights by each method, JSON; `scene` takes the first camera of the scene file
    #[arg(long, value_name = "C.json")]
    camera: Option<PathBuf>,
    /// Pixels of each of those pictures
    #[arg(long, value_name = "WIDTHxHEIGHT", requires = "camera", default_value = "240x180", value_parser = numbers::pixels)]
    size: [usize; 2],
    /// Back sides neither reflect nor receive (emission always leaves the front)
    #[arg(long)]
    one_sided: bool,
    /// What the files say beside the numbers, such as the machine
    #[arg(long, value_name = "TEXT", default_value = "")]
    note: String,
}

/// The numbers of a run.
#[derive(Serialize)]
struct Report {
    scene: String,
    lights: Vec<String>,
    receivers: usize,
    /// RMS of the standard errors of the truth, relative to its mean.
    truth_noise: f64,
    /// Direct light of the receivers, which every frame needs besides, ms.
    direct_ms: f64,
    threads: usize,
    note: String,
    entries: Vec<Entry>,
    left_out: Vec<LeftOut>,
    /// The settings that side-by-side.png shows; receivers are pixels.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    side_by_side: Vec<Entry>,
    seconds: f64,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let names = outputs(args);
    prepare(args, &names, session)?;
    let (folder, name) = DiskFolder::of(&args.scene)?;
    let named = || args.scene.display().to_string();
    let import = ImportOptions { one_sided: args.one_sided };
    let (scene, imported) = scene::import(&name, &folder, import).with_context(named)?;
    imported.warnings.iter().for_each(|warning| session.warn(warning));
    let rigs =
        args.lights.iter().map(|path| runtime::rig(path, &scene, session)).collect::<anyhow::Result<Vec<_>>>()?;
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials).with_context(named)?;
    let rays = Rays::new(&scene.mesh);
    let points = points(args, &scene, &rays).with_context(named)?;
    let receivers = relight::surface_points(&scene.mesh, &points.position, &points.normal);
    let setting = Setting { scene: &scene, surfaces: &surfaces, rays: &rays, receivers: &receivers };
    let wanted = |c: &&Contestant| args.methods.is_empty() || args.methods.iter().any(|m| m == c.name);
    let contestants: Vec<&Contestant> = ALL.iter().filter(wanted).collect();
    // What the camera file may lack is found before the long part.
    let look = |camera| {
        let eye = Eye { camera, size: args.size, truth_error: args.truth_error() };
        Sight::new(eye, &setting, &rigs[0], &args.output, session)
    };
    let sight = args.camera.as_deref().map(look).transpose()?;
    let truths = truths(args, &points, &setting, &rigs, session)?;
    let ground = Ground::new(setting, &points.position, session);
    let mut judge = Judge::new(&ground, &rigs, &truths);
    for contestant in &contestants {
        judge.run(contestant, if args.quick { Choice::First } else { Choice::All })?;
    }
    let Judge { entries, left_out, direct_seconds, .. } = judge;
    // Its bakes are not needed any more.
    drop(ground);
    let side_by_side = match sight {
        Some(sight) => sight.draw(&contestants, (&entries, receivers.len()), &setting, &args.output, session)?,
        None => vec![],
    };
    let file_name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let report = Report {
        scene: file_name(&args.scene),
        lights: args.lights.iter().map(file_name).collect(),
        receivers: receivers.len(),
        truth_noise: score::quadratic_mean(truths.iter().map(score::noise)),
        direct_ms: 1e3 * direct_seconds,
        threads: rayon::current_num_threads(),
        note: args.note.clone(),
        entries,
        left_out,
        side_by_side,
        seconds: session.seconds(),
    };
    write(&report, &args.output)?;
    session.finish(&report)
}

impl Args {
    fn truth_error(&self) -> f64 {
        self.truth_error.unwrap_or(TRUTH_ERROR[usize::from(self.quick)])
    }
}

/// The light of every lights file at the receivers: read, or traced and written.
fn truths(
    args: &Args,
    points: &Points,
    setting: &Setting,
    rigs: &[scene::LightRig],
    session: &Session,
) -> anyhow::Result<Vec<Truth>> {
    let error = args.truth_error();
    let one = |(at, rig): (usize, &scene::LightRig)| match args.truth.get(at) {
        Some(path) => Truth::read(path, points),
        None => Truth::trace(points, setting, rig, error, &args.output.join(truth_name(args, at)), session),
    };
    let truths = rigs.iter().enumerate().map(one).collect::<anyhow::Result<Vec<_>>>()?;
    for (truth, lights) in truths.iter().zip(&args.lights) {
        if score::mean(truth) <= 0.0 {
            bail!("{}: no indirect light reaches the receivers; take other lights or points", lights.display());
        }
    }
    Ok(truths)
}

/// The receivers of the scene, of a points file, or of the truth.
fn points(args: &Args, scene: &scene::Scene, rays: &Rays) -> anyhow::Result<Points> {
    match args.truth.first().or(args.points.as_ref()) {
        Some(path) => Points::read(path, &[]),
        None => receivers::by_area(scene, rays, args.receivers.unwrap_or(RECEIVERS[usize::from(args.quick)])),
    }
}

fn write(report: &Report, folder: &Path) -> anyhow::Result<()> {
    files::write(&folder.join("chart.csv"), sheet::csv(report)?.as_bytes())?;
    files::write(&folder.join("chart.md"), sheet::markdown(report).as_bytes())?;
    for (name, chart) in [("chart", picture::of_time(report)), ("memory", picture::of_memory(report))] {
        files::write(&folder.join(format!("{name}.svg")), chart.svg()?.as_bytes())?;
        files::write(&folder.join(format!("{name}.png")), &chart.png()?)?;
    }
    Ok(())
}

/// Name of the file with the truth of a lights file.
fn truth_name(args: &Args, at: usize) -> String {
    if args.lights.len() == 1 { "truth.csv".into() } else { format!("truth-{}.csv", at + 1) }
}

/// The files that a run writes.
fn outputs(args: &Args) -> Vec<String> {
    let charts = ["chart.csv", "chart.md", "chart.svg", "chart.png", "memory.svg", "memory.png"];
    let traced = if args.truth.is_empty() { args.lights.len() } else { 0 };
    let seen = if args.camera.is_some() { &side_by_side::FILES[..] } else { &[] };
    let known = charts.iter().chain(seen).map(|name| String::from(*name));
    known.chain((0..traced).map(|at| truth_name(args, at))).collect()
}

/// Makes the folder and refuses outputs that could not be written or would overwrite an input.
fn prepare(args: &Args, names: &[String], session: &Session) -> anyhow::Result<()> {
    if !args.truth.is_empty() && args.truth.len() != args.lights.len() {
        bail!("--truth has {} files, expected {}: one a lights file", args.truth.len(), args.lights.len());
    }
    if !args.output.is_dir() {
        std::fs::create_dir(&args.output).with_context(|| args.output.display().to_string())?;
    }
    let paths: Vec<PathBuf> = names.iter().map(|name| args.output.join(name)).collect();
    let mut outputs = session.outputs(&paths[0]);
    outputs.extend(paths[1..].iter().map(|path| ("-o", path.as_path())));
    let mut inputs = vec![("the scene", args.scene.as_path())];
    inputs.extend(args.lights.iter().map(|path| ("the lights", path.as_path())));
    inputs.extend(args.points.iter().map(|path| ("the points", path.as_path())));
    inputs.extend(args.camera.iter().map(|path| ("the camera", path.as_path())));
    inputs.extend(args.truth.iter().map(|path| ("the truth", path.as_path())));
    files::check_outputs(&outputs, &inputs)
}
