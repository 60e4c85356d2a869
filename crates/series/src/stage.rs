//! The stage between two containers.

use radfile::{Builder, Container, FormFactors, Patches, Progress, Record, Sink, Step, rests_on_operator};

use crate::{Error, Params, Report, all_bounces};

/// Reads `patches.*` and `formfactor.*`, adds `series.*`.
///
/// An older operator and whatever was packed from it are dropped; everything else is handed through.
///
/// # Errors
///
/// Those of [`all_bounces`], and [`Error::Container`].
pub fn run(
    input: &Container,
    params: &Params,
    step: Step,
    progress: &dyn Progress,
    sink: &mut Sink,
) -> Result<Report, Error> {
    let patches = Patches::read(input)?;
    let factors = FormFactors::read(input)?;
    let (operator, report) = all_bounces(&patches, &factors, params, progress)?;
    let stale = |name: &str| name.starts_with("series.") || rests_on_operator(name);
    let mut builder = Builder::from_input(input, |section| !stale(&section.name));
    operator.write(&mut builder);
    builder.provenance(Some(input), step)?;
    sink(&builder)?;
    Ok(report)
}
