//! `allbounce diff`: the numeric difference of two containers.

use std::path::PathBuf;

use anyhow::bail;
use radfile::{SectionDiff, Tolerance, Verdict};

use crate::{files, numbers, session::Session};

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
    #[arg(long, value_name = "X", value_parser = numbers::tolerance)]
    abs: Option<f64>,
    /// Largest RMS difference of a section, relative to its RMS [default: unlimited]
    #[arg(long, value_name = "X", value_parser = numbers::tolerance)]
    rms: Option<f64>,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let (a, b) = (files::open(&args.a)?, files::open(&args.b)?);
    let report = radfile::diff(&a, &b, Tolerance::new(args.abs, args.rms));
    let lines = report.sections.iter().filter(|s| s.verdict != Verdict::Same).map(line);
    let same = report.sections.iter().filter(|s| s.verdict == Verdict::Same).count();
    files::print(&format!("{}{same} sections are the same\n", lines.collect::<String>()))?;
    session.finish(&report)?;
    let beyond = |s: &&SectionDiff| !matches!(s.verdict, Verdict::Same | Verdict::Within | Verdict::Unjudged);
    match report.sections.iter().find(beyond) {
        Some(first) => {
            bail!(
                "{} and {} differ beyond the tolerance, first in {}",
                args.a.display(),
                args.b.display(),
                line(first).trim()
            )
        }
        None => Ok(()),
    }
}

/// One section in words.
fn line(s: &SectionDiff) -> String {
    let (name, none) = (&s.name, String::from("nothing"));
    match s.verdict {
        Verdict::Shape | Verdict::Missing | Verdict::Extra => {
            let (a, b) = (s.a.as_ref().unwrap_or(&none), s.b.as_ref().unwrap_or(&none));
            format!("{name}: {a} against {b}\n")
        }
        Verdict::Within | Verdict::Beyond => format!(
            "{name}: {} elements differ, by {:.3e} at most, at {:?}; relative RMS {:.3e}\n",
            s.differing,
            s.largest,
            s.index.as_deref().unwrap_or(&[]),
            s.relative_rms
        ),
        Verdict::Same | Verdict::Unjudged => format!("{name}: {} elements differ, not judged\n", s.differing),
    }
}
