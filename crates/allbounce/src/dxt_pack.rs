//! `allbounce dxt-pack`: the operator as block-compressed textures.

use std::path::{Path, PathBuf};

use anyhow::Context;
use radfile::{BlockFormat, Container, PackedOperator, Progress, Record, Sink, Step};

use crate::{
    files, numbers,
    session::Session,
    stage::{self, Stage, patch_count},
};

/// Pack the operator into block-compressed textures and a list of outliers.
///
/// Reads patches and operator. Adds the packed operator; drops the dense matrices unless told to keep them.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    stage: stage::Args<Options>,
    /// Also write the textures for other tools: one texture array, a layer a tile and channel
    #[arg(long, value_name = "FILE.dds")]
    dds: Option<PathBuf>,
}

/// Options of this stage.
#[derive(clap::Args)]
pub struct Options {
    /// Block format and value map
    #[arg(long, value_enum, default_value = "bc4-sqrt")]
    format: Format,
    /// Share of the values that are kept apart as they are too large for the map [0..=1]
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = numbers::share)]
    outliers: f64,
    /// Span of the logarithm of `paper` and `bc4-log`
    #[arg(long, value_name = "S", default_value_t = 6.0, value_parser = numbers::span)]
    shift: f32,
    /// Keep form factors and the dense operator in the file
    #[arg(long)]
    keep_dense: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    /// As published: logarithm, three channels in one BC1 texture
    Paper,
    /// Logarithm, one BC4 texture a channel
    Bc4Log,
    /// Square root, one BC4 texture a channel
    Bc4Sqrt,
}

impl Options {
    fn params(&self) -> dxt_pack::Params {
        let (format, map) = match self.format {
            Format::Paper => (BlockFormat::Bc1, dxt_pack::MapKind::Log),
            Format::Bc4Log => (BlockFormat::Bc4, dxt_pack::MapKind::Log),
            Format::Bc4Sqrt => (BlockFormat::Bc4, dxt_pack::MapKind::Sqrt),
        };
        dxt_pack::Params {
            format,
            map,
            outliers: self.outliers,
            shift: self.shift,
            keep_dense: self.keep_dense,
            ..dxt_pack::Params::default()
        }
    }
}

impl Stage for Options {
    const NAME: &'static str = "dxt-pack";
    type Report = dxt_pack::Report;

    fn text(&self) -> String {
        let name =
            clap::ValueEnum::to_possible_value(&self.format).map_or_else(String::new, |v| v.get_name().to_owned());
        let shift =
            if matches!(self.format, Format::Bc4Sqrt) { String::new() } else { format!(" --shift {}", self.shift) };
        let keep = if self.keep_dense { " --keep-dense" } else { "" };
        format!("--format {name} --outliers {}{shift}{keep}", self.outliers)
    }

    fn memory(&self, input: &Container) -> anyhow::Result<(u64, &'static str)> {
        let need = dxt_pack::memory_needed(patch_count(input)? as usize, 3, &self.params());
        Ok((need, "use fewer patches (voxel-simplify --patches N)"))
    }

    fn apply(&self, input: &Container, step: Step, p: &dyn Progress, sink: &mut Sink) -> anyhow::Result<Self::Report> {
        Ok(dxt_pack::run(input, &self.params(), step, p, sink)?)
    }
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    if let Some(dds) = &args.dds {
        let (input, output) = (&args.stage.input, &args.stage.output);
        files::check_outputs(&[("--dds", dds)], &[("its own input", input), ("the output of -o", output)])?;
    }
    stage::run(&args.stage, session)?;
    match &args.dds {
        Some(path) => export(&args.stage.output, path, session),
        None => Ok(()),
    }
}

/// Writes the textures of a packed container as a DDS file.
fn export(packed: &Path, path: &Path, session: &Session) -> anyhow::Result<()> {
    let container = files::open(packed)?;
    let textures = dxt_pack::dds(&PackedOperator::read(&container)?).with_context(|| packed.display().to_string())?;
    files::write(path, &textures)?;
    session.say(&format!("wrote {}", path.display()));
    Ok(())
}
