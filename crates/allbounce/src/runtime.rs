//! A bake opened for relighting: what `relight` and `render` share.

use std::path::Path;

use anyhow::Context;
use radfile::{Container, Elements, Patches, Record, Transfer};
use relight::{Operator, Parts, Receivers};
use scene::{Camera, LightRig, Scene};

use crate::{files, session::Session};

/// Everything of a bake but the operator, which stays in the container.
pub struct Bake {
    pub container: Container,
    pub scene: Scene,
    pub patches: Patches,
    pub elements: Elements,
    pub transfer: Transfer,
}

impl Bake {
    /// Opens a self-contained bake.
    pub fn open(path: &Path) -> anyhow::Result<Bake> {
        let container = files::open(path)?;
        let read = || -> anyhow::Result<(Scene, Patches, Elements, Transfer)> {
            let patches = Patches::read(&container)?;
            let elements = Elements::read_or_whole(&container, &patches)?;
            Ok((Scene::read(&container)?, patches, elements, Transfer::read(&container)?))
        };
        let (scene, patches, elements, transfer) = read().with_context(|| path.display().to_string())?;
        Ok(Bake { container, scene, patches, elements, transfer })
    }

    /// The packed operator.
    pub fn operator(&self) -> anyhow::Result<Operator<'_>> {
        Ok(Operator::read(&self.container)?)
    }

    /// How light comes to the receivers.
    pub fn receivers(&self) -> anyhow::Result<Receivers<'_>> {
        Ok(Receivers::new(&self.transfer.weights, self.elements.senders())?)
    }

    /// What each patch sees of the sky.
    pub fn sky(&self) -> anyhow::Result<&[f32]> {
        Ok(radfile::read_sky(&self.container)?)
    }
}

/// Bounces of a frame in words.
pub fn bounces_in_words(bounces: Option<u32>) -> String {
    bounces.map_or_else(|| "all".into(), |k| format!("the first {k}"))
}

/// Share of the surface above which emitting materials are more than lamps.
const LARGE_GLOW: f64 = 0.03;

/// Share of the patches' area that emits.
fn glowing_share(bake: &Bake) -> f64 {
    let area = |emitting: bool| -> f64 {
        let counts = |i: &usize| !emitting || bake.patches.emission[*i] != [0.0; 3];
        (0..bake.patches.len()).filter(counts).map(|i| f64::from(bake.patches.area[i])).sum()
    };
    area(true) / area(false)
}

/// Said where an answer is not finite.
pub const TOO_BRIGHT: &str = "the lights are too bright for single precision; lower their intensities";

/// Which processor computes a frame.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub enum Backend {
    /// Ray-traced shadows, products on all cores
    Cpu,
    /// Shadow maps and textures through wgpu
    Gpu,
}

/// Options that choose the light, and who computes it.
#[derive(clap::Args)]
pub struct LightOptions {
    #[command(flatten)]
    pub chosen: Lighting,
    /// Which processor computes the frame
    #[arg(long, value_enum, default_value = "cpu")]
    pub backend: Backend,
}

impl LightOptions {
    /// As [`Lighting::rig`]; warns where a GPU takes too few samples.
    pub fn rig(&self, bake: &Bake, session: &Session) -> anyhow::Result<LightRig> {
        let rig = self.chosen.rig(bake, session)?;
        if self.backend == Backend::Gpu && rig.use_scene_emission && glowing_share(bake) > LARGE_GLOW {
            session.warn("large surfaces emit, which the GPU samples at 64 points in all; near them use --backend cpu");
        }
        Ok(rig)
    }
}

/// Options that choose the light.
#[derive(clap::Args)]
pub struct Lighting {
    /// Lights of the frame, JSON; `scene` takes the lights of the scene file
    #[arg(long, value_name = "L.json")]
    lights: std::path::PathBuf,
    /// Only light without any bounce
    #[arg(long, conflicts_with = "indirect_only")]
    direct_only: bool,
    /// Only light of one bounce and more
    #[arg(long)]
    indirect_only: bool,
}

impl Lighting {
    /// Which light is asked for.
    pub fn parts(&self) -> Parts {
        match (self.direct_only, self.indirect_only) {
            (true, _) => Parts::DirectOnly,
            (_, true) => Parts::IndirectOnly,
            _ => Parts::All,
        }
    }

    /// Sets the light that was not asked for to zero.
    pub fn blank(&self, direct: &mut [[f32; 3]], indirect: &mut [[f32; 3]]) {
        match self.parts() {
            Parts::All => {}
            Parts::DirectOnly => indirect.fill([0.0; 3]),
            Parts::IndirectOnly => direct.fill([0.0; 3]),
        }
    }

    /// The lights file.
    pub fn path(&self) -> &Path {
        &self.lights
    }

    /// Reads the lights file, or takes the scene's own lights; warns where nothing can shine.
    pub fn rig(&self, bake: &Bake, session: &Session) -> anyhow::Result<LightRig> {
        rig(&self.lights, &bake.scene, session)
    }
}

/// Reads a lights file, or takes the scene's own lights for `scene`; warns where nothing can shine.
pub fn rig(path: &Path, scene: &Scene, session: &Session) -> anyhow::Result<LightRig> {
    let rig = if path.as_os_str() == "scene" {
        let lights = scene.extras.lights.iter().map(|(_, light)| *light).collect();
        LightRig { use_scene_emission: true, lights, ..LightRig::default() }
    } else {
        LightRig::from_json(&files::text(path)?).with_context(|| path.display().to_string())?
    };
    let emits = scene.materials.materials.iter().any(|m| m.emission.iter().any(|&e| e > 0.0));
    if rig.lights.is_empty() && !(rig.use_scene_emission && emits) {
        session.warn("there are no lights, and no emitting material is used: every answer is dark");
    }
    Ok(rig)
}

/// Reads a camera file, or takes the scene's first camera for `scene`.
pub fn camera(path: &Path, scene: &Scene) -> anyhow::Result<Camera> {
    if path.as_os_str() == "scene" {
        let first = scene.extras.cameras.first().context("--camera scene: the scene file has no camera")?;
        return Ok(first.1);
    }
    Camera::from_json(&files::text(path)?).with_context(|| path.display().to_string())
}
