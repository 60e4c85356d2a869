//! The stage between two containers.

use radfile::{
    Builder, Certificate, Container, FormFactors, HierarchicalOperator, Kernel, Operator, Patches, Progress, Record,
    Sink, Step, outlasts_packing,
};
use rayon::prelude::*;

use crate::{Error, HMatrix, Params, Report, Result, compress};

/// Reads `patches.*` and, for all bounces, `series.*`, for one bounce `formfactor.*`; adds `hmatrix.*`.
///
/// Everything is handed on except what was packed before and, unless `keep_dense`, the dense operator and the form
/// factors; what the patches see of the sky stays, because a frame needs it.
///
/// # Errors
///
/// What [`compress`] refuses, and [`Error::Container`] if a section is missing or broken.
pub fn run(input: &Container, params: &Params, step: Step, progress: &dyn Progress, sink: &mut Sink) -> Result<Report> {
    let patches = Patches::read(input)?;
    let operator = match params.kernel {
        Kernel::AllBounces => Operator::read(input)?,
        Kernel::OneBounce => one_bounce(&FormFactors::read(input)?, &patches)?,
    };
    let (matrix, report) = compress(&operator, &patches, params, progress)?;
    let packed = HierarchicalOperator {
        certificate: Certificate {
            n: operator.n as u32,
            channels: operator.channels as u32,
            kernel: params.kernel,
            bounces: if params.kernel == Kernel::OneBounce { None } else { operator.bounces },
            error_wanted: params.error,
            probes: report.probes as u32,
            l2_mean: report.l2_mean,
            vis99: report.vis99,
        },
        blocks: matrix.to_bytes().into(),
    };
    let mut builder = Builder::from_input(input, |s| outlasts_packing(&s.name, params.keep_dense));
    packed.write(&mut builder);
    builder.provenance(Some(input), step)?;
    sink(&builder)?;
    Ok(report)
}

/// W = A^{1/2} F A^{-1/2} as an operator of one channel, docs/theory.md (5.1). Takes 4 n² bytes.
///
/// # Errors
///
/// [`Error::PatchCount`].
pub fn one_bounce(factors: &FormFactors, patches: &Patches) -> Result<Operator<'static>> {
    let n = patches.len();
    if factors.len() != n {
        return Err(Error::PatchCount { operator: factors.len(), patches: n });
    }
    let root: Vec<f64> = patches.area.iter().map(|a| f64::from(*a).sqrt()).collect();
    let mut values = vec![0.0; n * n];
    values.par_chunks_mut(n.max(1)).enumerate().for_each(|(i, row)| {
        for (j, (w, f)) in row.iter_mut().zip(factors.row(i)).enumerate() {
            *w = (f64::from(*f) * root[i] / root[j]) as f32;
        }
    });
    Ok(Operator { n, channels: 1, bounces: Some(1), values: values.into() })
}

/// Reads the packed operator of a container, ready for products, and what is said of it.
///
/// # Errors
///
/// [`Error::Container`], [`Error::Short`] and [`Error::Damaged`] for a stream that is no operator, [`Error::Certificate`].
pub fn read(container: &Container) -> Result<(HMatrix, Certificate)> {
    let packed = HierarchicalOperator::read(container)?;
    let matrix = HMatrix::from_bytes(&packed.blocks)?;
    let certificate = packed.certificate;
    let named = |n: usize, channels: usize| format!("{n} patches and {channels} channels");
    let found = named(matrix.patches(), matrix.channels());
    let expected = named(certificate.n as usize, certificate.channels as usize);
    if found != expected {
        return Err(Error::Certificate { found, expected });
    }
    Ok((matrix, certificate))
}
