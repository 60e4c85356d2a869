//! `allbounce export`: a frame's light in files that other programs read. One file a format.

mod glb;
mod ktx2;
mod lightmap;
mod surface;
mod vertex_colours;
mod volume;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use radfile::{Gathered, Lightmap, Record, Volume};
use relight::{DirectLight, Frame, PatchSamples, PointLight, Receivers, Relighter, Samples};
use scene::{Rays, SurfacePoint};
use serde::Serialize;

use crate::{
    csv_points::{ANSWERS, Points},
    files,
    runtime::{self, Bake, Lighting},
    session::Session,
};

/// Irradiance of one frame as lightmap, irradiance volume, vertex colours or table, W/m².
///
/// Without a format: all that the bake has. Computed on the CPU. Exit: 0 done, 1 input refused, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    /// Bake of `allbounce bake`, or the last container of the chain
    #[arg(value_name = "BAKE.rad")]
    bake: PathBuf,
    #[command(flatten)]
    light: Lighting,
    /// Folder that the files go to; it is made if it is not there
    #[arg(short, long, value_name = "OUTDIR")]
    output: PathBuf,
    /// lightmap.exr and lightmap.png (irradiance), lightmap_radiance.exr and .png (reflectance times irradiance over
    /// π), and scene.glb, the scene with the lightmap's coordinates as its last TEXCOORD; of a bake with --lightmap
    #[arg(long)]
    lightmap: bool,
    /// volume.ktx2, a texture of Bevy's IrradianceVolume (irradiance over π), volume.raw and volume_sh.raw, ambient
    /// cubes and linear harmonics (irradiance, f32), and volume.json, which says where they lie; of a bake with
    /// --volume
    #[arg(long)]
    volume: bool,
    /// vertex_colours.glb: the finer mesh with irradiance as COLOR_0, in parts of `irradiance_of_white` in its extras
    #[arg(long)]
    vertex_colours: bool,
    /// receivers.csv: irradiance of each side of each vertex of the finer mesh, as `relight` writes it
    #[arg(long)]
    csv: bool,
}

#[derive(Serialize)]
struct Report {
    bounces: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    lightmap: Option<lightmap::Report>,
    #[serde(skip_serializing_if = "Option::is_none")]
    volume: Option<volume::Report>,
    #[serde(skip_serializing_if = "Option::is_none")]
    vertex_colours: Option<vertex_colours::Report>,
    #[serde(skip_serializing_if = "Option::is_none")]
    csv_rows: Option<usize>,
    files: Vec<String>,
    seconds: f64,
}

const RECEIVERS: &str = "receivers.csv";

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let bake = Bake::open(&args.bake)?;
    let named = || args.bake.display().to_string();
    let c = &bake.container;
    let has_lightmap = c.has("lightmap.meta") && Gathered::is_in(c, Lightmap::PREFIX);
    if args.lightmap && !has_lightmap {
        bail!("{}: the bake has no lightmap; bake with --lightmap, or run transfer --lightmap on it", named());
    }
    let has_volume = c.has("volume.meta") && Gathered::is_in(c, Volume::PREFIX);
    if args.volume && !has_volume {
        bail!(
            "{}: the bake has no irradiance volume; bake with --volume 0.5m, or run transfer --volume on it",
            named()
        );
    }
    let all = !(args.lightmap || args.volume || args.vertex_colours || args.csv);
    let wanted = [
        (args.lightmap || all && has_lightmap, &lightmap::FILES[..]),
        (args.volume || all && has_volume, &volume::FILES[..]),
        (args.vertex_colours || all, &[vertex_colours::FILE]),
        (args.csv || all, &[RECEIVERS]),
    ];
    let names: Vec<String> =
        wanted.iter().filter(|(wanted, _)| *wanted).flat_map(|(_, names)| *names).map(|n| (*n).to_owned()).collect();
    prepare(args, &names, session)?;
    let rig = args.light.rig(&bake, session)?;
    let operator = bake.operator().with_context(named)?;
    let rays = Rays::new(&bake.scene.mesh);
    let relighter = Relighter::new(&bake.scene, &rays, &bake.patches, &bake.elements, &operator, bake.sky()?)
        .with_context(named)?;
    let light = relighter.direct_light(&rig);
    let frame = relighter.frame(&light, &PatchSamples::default(), &session.progress());
    let lit = Lit { bake: &bake, relighter: &relighter, light: &light, frame: &frame, chosen: &args.light, session };
    let [(lightmap, _), (volume, _), (vertex_colours, _), (csv, _)] = wanted;
    let lightmap = lightmap.then(|| lightmap::write(&lit, &args.output)).transpose().with_context(named)?;
    let volume = volume.then(|| volume::write(&lit, &args.output)).transpose().with_context(named)?;
    let of_vertices = if vertex_colours || csv { Some(lit.vertices().with_context(named)?) } else { None };
    let vertex_colours = match &of_vertices {
        Some(light) if vertex_colours => Some(vertex_colours::write(&lit, light, &args.output)?),
        _ => None,
    };
    let csv_rows = match &of_vertices {
        Some(light) if csv => Some(write_csv(&bake, light, &args.output.join(RECEIVERS))?),
        _ => None,
    };
    let bounces = runtime::bounces_in_words(operator.bounces());
    let report =
        Report { bounces, lightmap, volume, vertex_colours, csv_rows, files: names, seconds: session.seconds() };
    session.print("export", &report)?;
    session.finish(&report)
}

/// Makes the folder and refuses outputs that could not be written or would overwrite an input.
fn prepare(args: &Args, names: &[String], session: &Session) -> anyhow::Result<()> {
    if !args.output.is_dir() {
        std::fs::create_dir(&args.output).with_context(|| args.output.display().to_string())?;
    }
    let paths: Vec<PathBuf> = names.iter().map(|name| args.output.join(name)).collect();
    let (first, others) = paths.split_first().context("there is nothing to export")?;
    let mut outputs = session.outputs(first);
    outputs.extend(others.iter().map(|path| ("-o", path.as_path())));
    files::check_outputs(&outputs, &[("the bake", &args.bake), ("the lights", args.light.path())])
}

/// A bake under its lights.
struct Lit<'a> {
    bake: &'a Bake,
    relighter: &'a Relighter<'a>,
    light: &'a DirectLight<'a>,
    frame: &'a Frame,
    chosen: &'a Lighting,
    session: &'a Session,
}

impl Lit<'_> {
    /// Light of some receivers, the parts that were asked for.
    fn at(&self, points: &[SurfacePoint], receivers: &Receivers) -> anyhow::Result<PointLight> {
        let (samples, progress) = (Samples::default(), self.session.progress());
        let mut light =
            relight::light_at_points(self.relighter, self.light, points, receivers, self.frame, &samples, &progress);
        self.chosen.blank(&mut light.direct, &mut light.indirect);
        match light.direct.iter().chain(&light.indirect).flatten().all(|v| v.is_finite()) {
            true => Ok(light),
            false => bail!("{}", runtime::TOO_BRIGHT),
        }
    }

    /// Light of the receivers of the finer mesh.
    fn vertices(&self) -> anyhow::Result<PointLight> {
        let points = receivers_of(self.bake);
        let points = relight::surface_points(&self.bake.scene.mesh, &points.position, &points.normal);
        self.at(&points, &self.bake.receivers()?)
    }
}

/// Direct and indirect light together.
fn total(light: &PointLight) -> Vec<[f32; 3]> {
    let both = light.direct.iter().zip(&light.indirect);
    both.map(|(direct, indirect)| std::array::from_fn(|c| direct[c] + indirect[c])).collect()
}

/// The receivers of the finer mesh, in the axes of the scene file.
fn receivers_of(bake: &Bake) -> Points {
    let origin = bake.scene.mesh.origin;
    let in_file_axes = |p: &[f32; 3]| std::array::from_fn(|a| f64::from(p[a]) + origin[a]);
    Points::new(bake.transfer.position.iter().map(in_file_axes).collect(), bake.transfer.normal.clone())
}

fn write_csv(bake: &Bake, light: &PointLight, path: &Path) -> anyhow::Result<usize> {
    let row = |i: usize| light.direct[i].iter().chain(&light.indirect[i]).map(f32::to_string).collect();
    receivers_of(bake).write(path, &ANSWERS, row)?;
    Ok(light.direct.len())
}
