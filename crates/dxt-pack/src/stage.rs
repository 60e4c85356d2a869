//! The stage on containers.

use radfile::{Builder, Container, Operator, Patches, Progress, Record, Sink, Step, outlasts_packing};

use crate::{Params, Report, Result, pack};

/// Packs the operator of a container.
///
/// Everything is handed on except the dense operator and the form factors, which are dropped unless
/// `keep_dense`; what the patches see of the sky stays, because a frame needs it.
///
/// # Errors
///
/// What [`pack()`] refuses, and [`crate::Error::Container`] if a section is missing or broken.
pub fn run(input: &Container, params: &Params, step: Step, progress: &dyn Progress, sink: &mut Sink) -> Result<Report> {
    let operator = Operator::read(input)?;
    let patches = Patches::read(input)?;
    let (packed, report) = pack(&operator, &patches, params, progress)?;
    let mut builder = Builder::from_input(input, |s| outlasts_packing(&s.name, params.keep_dense));
    packed.write(&mut builder);
    builder.provenance(Some(input), step)?;
    sink(&builder)?;
    Ok(report)
}
