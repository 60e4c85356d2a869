//! `allbounce voxel-simplify`: a scene file in, patches out.

use std::path::{Path, PathBuf};

use anyhow::Context;
use radfile::{Container, Sink};
use scene::{ImportOptions, ImportReport};
use serde::Serialize;
use voxel_simplify::{Mode, Params, Pilot, Report, Resolution};

use crate::{
    files::{self, DiskFolder},
    numbers,
    session::Session,
    stage::{self, StageReport},
};

/// Clip the scene's triangles to voxels and group them to patches.
///
/// Writes mesh, materials and patches. Exit: 0 done, 1 input refused, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    /// Scene: .obj (with .mtl), .gltf or .glb; metres
    pub scene: PathBuf,
    /// Container to write
    #[arg(short, long, value_name = "OUT.rad")]
    pub output: PathBuf,
    /// Small patches where light changes, large ones where it does not, as a coarse bake of the same scene tells:
    /// a container after formfactor and series, of some hundred patches
    #[arg(long, value_name = "PILOT.rad", conflicts_with = "voxel")]
    adaptive: Option<PathBuf>,
    #[command(flatten)]
    pub options: Options,
}

/// Patches where no number is given.
const WANTED: u32 = 2500;
/// Fewest and most patches of a pilot.
const PILOT: [u32; 2] = [100, 1000];

/// Options of this stage.
#[derive(Clone, clap::Args)]
pub struct Options {
    /// Edge of a voxel, such as 0.25m
    #[arg(long, value_name = "LENGTH", value_parser = numbers::metres, conflicts_with = "patches")]
    voxel: Option<f32>,
    /// Number of patches to aim at; finds the voxel size [default: 2500]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    patches: Option<u32>,
    /// How triangles become patches
    #[arg(long, value_enum, default_value = "clusters")]
    mode: ModeName,
    /// Back sides neither reflect nor receive (emission always leaves the front)
    #[arg(long)]
    one_sided: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum ModeName {
    /// Connected pieces of the real triangles that face the same way
    Clusters,
    /// The paper's axis-aligned voxel faces, for comparison; area is not conserved
    Faces,
}

impl Options {
    fn params(&self) -> Params {
        let resolution = match (self.voxel, self.patches) {
            (Some(edge), _) => Resolution::Voxel(edge),
            (None, patches) => Resolution::Patches(patches.unwrap_or(WANTED)),
        };
        let mode = match self.mode {
            ModeName::Clusters => Mode::Clusters,
            ModeName::Faces => Mode::Faces,
        };
        Params { resolution, mode, ..Params::default() }
    }

    /// Whether patches are sides of voxels.
    pub fn is_of_faces(&self) -> bool {
        matches!(self.mode, ModeName::Faces)
    }

    /// Options of the coarse bake that adaptive patches are made by.
    pub fn of_pilot(&self) -> Options {
        let wanted = self.patches.unwrap_or(WANTED);
        Options { voxel: None, patches: Some((wanted / 4).clamp(PILOT[0], PILOT[1])), ..self.clone() }
    }

    /// The same for so many patches.
    pub fn of_patches(&self, patches: u32) -> Options {
        Options { voxel: None, patches: Some(patches), ..self.clone() }
    }

    /// Back sides neither reflect nor receive.
    pub fn import(&self) -> ImportOptions {
        ImportOptions { one_sided: self.one_sided }
    }

    fn text(&self) -> String {
        let size = match self.params().resolution {
            Resolution::Voxel(edge) => format!("--voxel {edge}m"),
            Resolution::Patches(n) => format!("--patches {n}"),
        };
        let mode = if matches!(self.mode, ModeName::Faces) { " --mode faces" } else { "" };
        format!("{size}{mode}{}", if self.one_sided { " --one-sided" } else { "" })
    }
}

/// What the stage reports.
#[derive(Serialize)]
pub struct Numbers {
    scene: ImportReport,
    #[serde(flatten)]
    patches: Report,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let pilot = args.adaptive.as_deref();
    let inputs: Vec<(&str, &Path)> =
        [("the scene", args.scene.as_path())].into_iter().chain(pilot.map(|p| ("the pilot", p))).collect();
    files::check_outputs(&session.outputs(&args.output), &inputs)?;
    let sink: &mut Sink = &mut |b| b.write_file(&args.output);
    let report = match pilot {
        None => apply(&args.scene, &args.options, None, session, sink)?,
        Some(path) => {
            let container = files::open(path)?;
            apply(&args.scene, &args.options, Some(&container), session, sink)?
        }
    };
    session.finish(&report)
}

/// Imports a scene, makes patches, adaptive ones where there is a pilot, and hands the container to `sink`.
pub fn apply(
    path: &Path,
    options: &Options,
    pilot: Option<&Container>,
    session: &Session,
    sink: &mut Sink,
) -> anyhow::Result<StageReport<Numbers>> {
    let start = session.seconds();
    let (folder, name) = DiskFolder::of(path)?;
    let named = || path.display().to_string();
    let (scene, imported) = scene::import(&name, &folder, options.import()).with_context(named)?;
    let mut inputs = folder.inputs();
    inputs.extend(pilot.map(|pilot| ("pilot".into(), radfile::digest(pilot.as_bytes()))));
    let adaptive = if pilot.is_some() { " --adaptive" } else { "" };
    let step = stage::step("voxel-simplify", options.text() + adaptive, inputs);
    let pilot = pilot.map(Pilot::read).transpose().context("the pilot")?;
    let progress = session.progress();
    let report =
        voxel_simplify::run(&scene, &options.params(), pilot.as_ref(), step, &progress, sink).with_context(named)?;
    drop(progress);
    let seconds = session.seconds() - start;
    let report =
        StageReport { stage: "voxel-simplify", seconds, numbers: Numbers { scene: imported, patches: report } };
    session.print("voxel-simplify", &report)?;
    Ok(report)
}
