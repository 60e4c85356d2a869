//! `allbounce dxt-pack`: the operator as block-compressed textures.

use std::path::{Path, PathBuf};

use clap::builder::PossibleValuesParser;
use dxt_pack::{MapKind, Outliers, Params};
use radfile::{BlockFormat, Container, PackedOperator, Progress, Record, Sink, Step};

use crate::{
    files, numbers,
    packing::Wanted,
    session::Session,
    stage::{self, Stage, patch_count},
};

/// Pack the operator into block-compressed textures, a list of outliers and a basis of its colour.
///
/// Reads patches and operator. Adds the packed operator; drops the dense matrices unless told to keep them.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    stage: stage::Args<Packing>,
    /// Also write the texture for other tools, without outliers and colour
    #[arg(long, value_name = "FILE.dds")]
    dds: Option<PathBuf>,
    /// The same as KTX2
    #[arg(long, value_name = "FILE.ktx2")]
    ktx2: Option<PathBuf>,
}

/// Options of this stage.
#[derive(Clone, clap::Args)]
pub struct Options {
    /// As published: logarithm, all of the matrix and its three channels in one BC1 texture (paper); logarithm or
    /// square root, half of its luma in a BC4 texture, colour as a basis of low rank (bc4-log, bc4-sqrt)
    /// [default: bc4-sqrt]
    #[arg(long, value_parser = PossibleValuesParser::new(Params::PRESETS.map(|(name, _)| name)))]
    pub format: Option<String>,
    /// Share of the values that are kept apart as they are too large for the map: a number 0..=1, or `auto`, which is
    /// 0.01 for `paper` and what --operator-error takes for the others
    #[arg(long, value_name = "SHARE", default_value = "auto", value_parser = outliers)]
    outliers: Outliers,
    /// Span of the logarithm of `paper` and `bc4-log`
    #[arg(long, value_name = "S", default_value_t = 6.0, value_parser = numbers::span)]
    shift: f32,
}

// A doc comment here would stand in the stage's help.
#[derive(clap::Args)]
pub struct Packing {
    #[command(flatten)]
    pub options: Options,
    #[command(flatten)]
    pub wanted: Wanted,
}

impl Options {
    fn format(&self) -> &str {
        self.format.as_deref().unwrap_or("bc4-sqrt")
    }
}

impl Packing {
    fn params(&self) -> Params {
        let Packing { options, wanted } = self;
        let named = Params::PRESETS.into_iter().find(|(name, _)| *name == options.format());
        let preset = named.map_or_else(Params::default, |(_, preset)| preset);
        let (error, keep_dense) = (wanted.error.unwrap_or(preset.error), wanted.keep_dense);
        Params { outliers: options.outliers, error, shift: options.shift, keep_dense, ..preset }
    }
}

/// A share, or `auto`.
fn outliers(text: &str) -> Result<Outliers, String> {
    if text == "auto" { Ok(Outliers::Auto) } else { numbers::share(text).map(Outliers::Share) }
}

impl Stage for Packing {
    const NAME: &'static str = "dxt-pack";
    type Report = dxt_pack::Report;

    fn text(&self) -> String {
        let logarithmic = self.params().map == MapKind::Log;
        let shift = if logarithmic { format!(" --shift {}", self.options.shift) } else { String::new() };
        let outliers = match self.options.outliers {
            Outliers::Auto => "auto".to_owned(),
            Outliers::Share(share) => share.to_string(),
        };
        let format = self.options.format();
        // What is as published has no error to keep within.
        let wanted = match self.params().format {
            BlockFormat::Bc1 => self.wanted.keep_dense_text().to_owned(),
            BlockFormat::Bc4 => format!(" {}", self.wanted.text(self.params().error)),
        };
        format!("--format {format} --outliers {outliers}{shift}{wanted}")
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
    let (input, output) = (&args.stage.input, &args.stage.output);
    let exports = [("--dds", &args.dds), ("--ktx2", &args.ktx2)];
    let exports: Vec<(&str, &Path)> =
        exports.iter().filter_map(|(option, path)| path.as_ref().map(|p| (*option, p.as_path()))).collect();
    files::check_outputs(&exports, &[("its own input", input), ("the output of -o", output)])?;
    stage::run(&args.stage, session)?;
    if exports.is_empty() {
        return Ok(());
    }
    let container = files::open(output)?;
    let packed = PackedOperator::read(&container)?;
    for (option, path) in exports {
        let bytes = if option == "--dds" { dxt_pack::dds(&packed)? } else { dxt_pack::ktx2(&packed) };
        files::write(path, &bytes)?;
        session.say(&format!("wrote {}", path.display()));
    }
    Ok(())
}
