//! From container to container.

use radfile::{Builder, Container, FormFactors, Mesh, Patches, Progress, Record, Sink, Step, rests_on_operator};

use crate::{Error, Params, Report, Result, form_factors};

/// Reads mesh and patches, adds `formfactor.*`, and hands everything else through, except what was
/// made from earlier form factors.
///
/// # Errors
///
/// As [`form_factors`], and [`Error::Container`] for a container without mesh or patches.
pub fn run(input: &Container, params: &Params, step: Step, progress: &dyn Progress, sink: &mut Sink) -> Result<Report> {
    let (mesh, patches) = (Mesh::read(input)?, Patches::read(input)?);
    let (factors, report) = form_factors(&mesh, &patches, params, progress)?;
    let mut builder = Builder::from_input(input, |section| {
        !STALE.iter().any(|p| section.name.starts_with(p)) && !rests_on_operator(&section.name)
    });
    factors.write(&mut builder);
    builder.provenance(Some(input), step)?;
    sink(&builder).map_err(Error::from)?;
    Ok(report)
}

/// Sections that this stage replaces or makes worthless.
const STALE: [&str; 2] = [FormFactors::PREFIX, "series."];
