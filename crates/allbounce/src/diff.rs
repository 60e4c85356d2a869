//! `allbounce diff`: the numeric difference of two containers.

use std::path::PathBuf;

use anyhow::bail;
use radfile::Tolerance;

use crate::{files, session::Session};

/// Compare two containers section by section, with tolerances.
///
/// Exit: 0 equal within the tolerances, 1 different, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    /// One container
    a: PathBuf,
    /// The other
    b: PathBuf,
    /// Largest absolute difference of a number [default: 0, or any if --rms is given]
    #[arg(long, value_name = "X")]
    abs: Option<f64>,
    /// Largest RMS difference of a section, relative to its RMS [default: any]
    #[arg(long, value_name = "X")]
    rms: Option<f64>,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let (a, b) = (files::open(&args.a)?, files::open(&args.b)?);
    let tolerance = match (args.abs, args.rms) {
        (None, None) => Tolerance::EXACT,
        (abs, rms) => Tolerance::new(abs, rms),
    };
    let report = radfile::diff(&a, &b, tolerance);
    session.print("diff", &report)?;
    session.finish(&report)?;
    if !report.equal {
        bail!("{} and {} differ beyond the tolerance", args.a.display(), args.b.display());
    }
    Ok(())
}
