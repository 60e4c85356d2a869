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
    /// Largest absolute difference of a number [default: 0, unlimited if --rms is given]
    #[arg(long, value_name = "X")]
    abs: Option<f64>,
    /// Largest RMS difference of a section, relative to its RMS [default: unlimited]
    #[arg(long, value_name = "X")]
    rms: Option<f64>,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let (a, b) = (files::open(&args.a)?, files::open(&args.b)?);
    let report = radfile::diff(&a, &b, Tolerance::new(args.abs, args.rms));
    session.print("diff", &report)?;
    session.finish(&report)?;
    if !report.equal {
        bail!("{} and {} differ beyond the tolerance", args.a.display(), args.b.display());
    }
    Ok(())
}
