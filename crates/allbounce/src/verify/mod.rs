//! `allbounce verify`: the identities of light transport, held against any container of the chain.
//!
//! Each line gives the number of its equation in `docs/theory.md`, which derives it.

mod check;
mod form_factors;
mod light;
mod operator;
mod patches;
mod transfer;

use std::{fmt::Write, path::PathBuf};

use anyhow::{Context, bail};
use radfile::{Container, Elements, FormFactors, Mesh, Patches, Record, Transfer};

use self::check::Check;
use crate::{files, numbers, session::Session};

/// Check the identities that hold for any scene: reciprocity, row sums, furnace, energy, transfer.
///
/// Numbers in brackets are those of the equations in docs/theory.md.
/// Exit: 0 all hold, 1 some do not or the input is refused, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    /// Container of any stage, or a bake
    file: PathBuf,
    /// Largest mean deviation of furnace identity and energy balance through the packed operator
    #[arg(long, value_name = "X", default_value_t = 0.02, value_parser = numbers::tolerance)]
    packed_tolerance: f64,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let c = files::open(&args.file)?;
    let name = || args.file.display().to_string();
    let checks = identities(&c, args.packed_tolerance).with_context(name)?;
    let mut text = String::new();
    for check in &checks {
        writeln!(text, "{}", check.line())?;
    }
    files::print(&text)?;
    session.finish(&checks)?;
    let asked = checks.iter().filter(|c| c.asked()).count();
    match checks.iter().filter(|c| c.fails()).count() {
        0 => Ok(()),
        failed => bail!("{}: {failed} of {asked} identities do not hold", name()),
    }
}

/// Every identity that the container has the numbers for.
fn identities(c: &Container, packed_tolerance: f64) -> anyhow::Result<Vec<Check>> {
    let patches = Patches::read(c)?;
    let mut checks = vec![patches::pieces(&patches)];
    if c.has("formfactor.values") {
        checks.extend(form_factors::form_factors(&FormFactors::read(c)?, &patches, Mesh::read(c)?.one_sided)?);
    }
    if c.has("series.values") {
        checks.extend(operator::dense(c, &patches)?);
    }
    if relight::Operator::is_in(c) {
        checks.extend(operator::packed(c, &patches, packed_tolerance)?);
    }
    let elements = Elements::read_or_whole(c, &patches)?;
    checks.push(transfer::elements(&elements, &patches));
    if c.has("transfer.position") {
        checks.push(transfer::transfer(&Transfer::read(c)?, &elements)?);
    }
    Ok(checks)
}
