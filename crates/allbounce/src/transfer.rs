//! `allbounce transfer`: how patch light comes to the vertices of a finer mesh.

use clap::ValueEnum;
use radfile::{Container, Progress, Sink, Step};
use transfer::{GatherParams, LightmapParams, VolumeParams};

use crate::{numbers, stage::Stage};

/// Tessellate the mesh and find, for each vertex and side, how light comes to it.
///
/// Reads scene and patches. Adds the finer mesh, and for each receiver packed form factors of all that it sees, or
/// normalised weights over patches nearby; the texels of a lightmap and the probes of an
/// irradiance volume where asked for.
#[derive(Clone, clap::Args)]
pub struct Options {
    /// How light comes to vertices [default: gather; interpolate where the operator holds some bounces only]
    #[arg(id = "transfer", long = "transfer", value_name = "MODE", value_enum)]
    mode: Option<Mode>,
    /// Longest edge of the finer mesh, such as 0.1m [default: the voxel size, or the extent of adaptive patches]
    #[arg(long, value_name = "LENGTH", value_parser = numbers::metres)]
    edge: Option<f32>,
    /// Rays of each receiver of the gather [default: 1024]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=1 << 16))]
    gather_rays: Option<u32>,
    /// Error of the receivers' light that packing the gather may cause, 0.05% to 50%: L2, mean over probe lights
    /// [default: 1%]
    #[arg(long, value_name = "E", value_parser = numbers::operator_error)]
    gather_error: Option<f64>,
    /// Make a lightmap of about so many texels as well, by the scene's second texture coordinates (TEXCOORD_1 of glTF) where
    /// they fit, otherwise unwrapped [without a number: 65536]
    #[arg(long, value_name = "TEXELS", num_args = 0..=1, default_missing_value = "65536",
        value_parser = clap::value_parser!(u32).range(16..=1 << 22))]
    lightmap: Option<u32>,
    /// Texels around each piece of an unwrapped lightmap that filters may read [default: 2]
    #[arg(long, value_name = "N", requires = "lightmap", value_parser = clap::value_parser!(u32).range(1..=64))]
    lightmap_padding: Option<u32>,
    /// Make an irradiance volume as well, such as 0.5m: a grid of probes over the scene, at most so far apart, each with the
    /// irradiance of the six directions along the axes
    #[arg(long, value_name = "SPACING", value_parser = numbers::metres)]
    volume: Option<f32>,
}

/// How light comes to receivers.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Mode {
    /// From all that they see, parts of patches: the most accurate
    Gather,
    /// Between the irradiances of patches around them: the fastest to bake
    Interpolate,
}

impl Options {
    /// Vertices that interpolate, and no other receivers.
    pub fn interpolated(&self) -> Options {
        Options { mode: Some(Mode::Interpolate), lightmap: None, lightmap_padding: None, volume: None, ..self.clone() }
    }

    /// Receivers that gather by so many rays, packed to an error.
    pub fn gathered(&self, rays: u32, error: f64) -> Options {
        Options { mode: Some(Mode::Gather), gather_rays: Some(rays), gather_error: Some(error), ..self.clone() }
    }

    /// Whether receivers besides those of the mesh are asked for, which must gather.
    pub fn asks_for_more(&self) -> bool {
        self.lightmap.is_some() || self.volume.is_some()
    }

    fn params(&self, input: &Container) -> anyhow::Result<transfer::Params> {
        let cut = radfile::bounces_held(input)?.is_some();
        let mode = match self.mode {
            Some(Mode::Gather) => transfer::Mode::Gather,
            Some(Mode::Interpolate) => transfer::Mode::Interpolate,
            None if cut => transfer::Mode::Interpolate,
            None => transfer::Mode::Gather,
        };
        let default = transfer::Params::default();
        let gather = GatherParams { rays: self.gather_rays.unwrap_or(default.gather.rays), ..default.gather };
        let gather_error = self.gather_error.unwrap_or(default.gather_error);
        let padding = self.lightmap_padding.unwrap_or(LightmapParams::default().padding);
        let lightmap = self.lightmap.map(|texels| LightmapParams { texels, padding });
        let volume = self.volume.map(|spacing| VolumeParams { spacing, ..VolumeParams::default() });
        Ok(transfer::Params { mode, edge: self.edge, gather, gather_error, lightmap, volume, ..default })
    }
}

impl Stage for Options {
    const NAME: &'static str = "transfer";
    type Report = transfer::Report;

    fn text(&self) -> String {
        let mode = self.mode.and_then(|m| m.to_possible_value()).map(|m| format!("--mode {}", m.get_name()));
        let edge = self.edge.map(|edge| format!("--edge {edge}m"));
        let rays = self.gather_rays.map(|rays| format!("--gather-rays {rays}"));
        let error = self.gather_error.map(|error| format!("--gather-error {error}"));
        let lightmap = self.lightmap.map(|texels| format!("--lightmap {texels}"));
        let padding = self.lightmap_padding.map(|texels| format!("--lightmap-padding {texels}"));
        let volume = self.volume.map(|spacing| format!("--volume {spacing}m"));
        [mode, edge, rays, error, lightmap, padding, volume].into_iter().flatten().collect::<Vec<_>>().join(" ")
    }

    fn memory(&self, input: &Container) -> anyhow::Result<(u64, &'static str)> {
        let need = transfer::memory_needed(input, &self.params(input)?)?;
        Ok((
            need,
            "take a longer --edge, fewer --gather-rays, a smaller --lightmap, a longer --volume, or --mode interpolate",
        ))
    }

    fn apply(&self, input: &Container, step: Step, p: &dyn Progress, sink: &mut Sink) -> anyhow::Result<Self::Report> {
        Ok(transfer::run(input, &self.params(input)?, step, p, sink)?)
    }
}
