//! `allbounce dxt-pack`: the operator as block-compressed textures.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::builder::PossibleValuesParser;
use dxt_pack::{MapKind, Outliers, Params};
use radfile::{BlockFormat, Container, PackedOperator, Progress, Record, Sink, Step};

use crate::{
    files, numbers,
    session::Session,
    stage::{self, Stage, patch_count},
};

/// Pack the operator into block-compressed textures, a list of outliers and a basis of its colour.
///
/// Reads patches and operator. Adds the packed operator; drops the dense matrices unless told to keep them.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    stage: stage::Args<Options>,
    /// Also write the texture for other tools, without outliers and colour
    #[arg(long, value_name = "FILE.dds")]
    dds: Option<PathBuf>,
}

/// Options of this stage.
#[derive(clap::Args)]
pub struct Options {
    /// As published: logarithm, all of the matrix and its three channels in one BC1 texture (paper); logarithm or
    /// square root, half of its luma in a BC4 texture, colour as a basis of low rank (bc4-log, bc4-sqrt)
    /// [default: bc4-sqrt]
    #[arg(long, value_parser = PossibleValuesParser::new(Params::PRESETS.map(|(name, _)| name)))]
    pub format: Option<String>,
    /// Share of the values that are kept apart as they are too large for the map: a number 0..=1, or `auto`, which is
    /// 0.01 for `paper` and what --error takes for the others
    #[arg(long, value_name = "SHARE", default_value = "auto", value_parser = outliers)]
    outliers: Outliers,
    /// Error of light that outliers and colour of `bc4-log` and `bc4-sqrt` keep within, with as few bytes as they can
    #[arg(long, value_name = "E", default_value = "1%", value_parser = numbers::relative_error)]
    error: f64,
    /// Span of the logarithm of `paper` and `bc4-log`
    #[arg(long, value_name = "S", default_value_t = 6.0, value_parser = numbers::span)]
    shift: f32,
    /// Keep form factors and the dense operator in the file
    #[arg(long)]
    pub keep_dense: bool,
}

impl Options {
    fn format(&self) -> &str {
        self.format.as_deref().unwrap_or("bc4-sqrt")
    }

    fn params(&self) -> Params {
        let named = Params::PRESETS.into_iter().find(|(name, _)| *name == self.format());
        let preset = named.map_or_else(Params::default, |(_, preset)| preset);
        Params { outliers: self.outliers, error: self.error, shift: self.shift, keep_dense: self.keep_dense, ..preset }
    }
}

/// A share, or `auto`.
fn outliers(text: &str) -> Result<Outliers, String> {
    if text == "auto" { Ok(Outliers::Auto) } else { numbers::share(text).map(Outliers::Share) }
}

impl Stage for Options {
    const NAME: &'static str = "dxt-pack";
    type Report = dxt_pack::Report;

    fn text(&self) -> String {
        let logarithmic = self.params().map == MapKind::Log;
        let shift = if logarithmic { format!(" --shift {}", self.shift) } else { String::new() };
        let keep = if self.keep_dense { " --keep-dense" } else { "" };
        format!("--format {} --outliers {}{shift}{keep}", self.format(), self.outliers)
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
