//! One trial bake: so many patches, up to the packed operator, and its error.
//!
//! The parts of an error ε: packing ε/8, noise of form factors ε/4, the solve nothing (it is exact); patches get what is left
//! (docs/decisions/0015, which corrects the budget rule of docs/design.md).

use radfile::Container;
use series::Precision;

use super::{
    Args,
    chain::{Log, keep, taken},
    climb::Kind,
};
use crate::{
    hmatrix,
    packing::Wanted,
    series as solve,
    session::Session,
    stage::{self, Stage},
    voxel_simplify,
};

/// Part of the error that packing may cause, and noise of the form factors.
const PACKING: f64 = 0.125;
const NOISE: f64 = 0.25;
/// What operators can be packed with.
pub const PACKABLE: [f64; 2] = [0.0005, 0.5];
/// Most patches of a bake that adaptive ones are made by.
const PILOT: u64 = 4000;

/// A bake that lacks only its receivers.
pub struct Rung {
    pub patches: u64,
    pub kind: Kind,
    /// Up to the packed operator.
    pub baked: Container,
    /// Up to the dense operator, where adaptive patches can be made by it.
    pub pilot: Option<Container>,
    pub log: Log,
    /// RMS of indirect irradiance, median of the rigs that steer.
    pub error: f64,
}

/// Bakes about so many patches for an error; `pilot` makes them adaptive.
pub fn bake(
    args: &Args,
    patches: u32,
    error: f64,
    pilot: Option<&Container>,
    session: &Session,
) -> anyhow::Result<Rung> {
    let (quiet, mut log, mut slot) = (session.brief(), Log::default(), None);
    let options = args.voxel_simplify.of_patches(patches);
    log.add(&voxel_simplify::apply(&args.scene, &options, pilot, &quiet, &mut keep(&mut slot))?)?;
    let simple = taken(slot)?;
    let factors = log.link(&args.formfactor.of_error(NOISE * error), &simple, &quiet)?;
    drop(simple);
    let summed = log.link(&solve::Options::all_bounces(precision(&factors, session)?), &factors, &quiet)?;
    drop(factors);
    let ordered = log.link(&args.permute, &summed, &quiet)?;
    let wanted = Wanted { error: Some((PACKING * error).clamp(PACKABLE[0], PACKABLE[1])), keep_dense: false };
    let packing = hmatrix::Packing { options: args.hmatrix.clone(), wanted };
    let baked = log.link(&packing, &ordered, &quiet)?;
    let patches = stage::patch_count(&baked)?;
    let kind = if pilot.is_some() { Kind::Adaptive } else { Kind::Uniform };
    let pilot = (pilot.is_none() && patches <= PILOT).then_some(summed);
    Ok(Rung { patches, kind, baked, pilot, log, error: f64::INFINITY })
}

/// f64 unless only f32 fits into memory.
fn precision(factors: &Container, session: &Session) -> anyhow::Result<Precision> {
    let (need, _) = solve::Options::all_bounces(Precision::F64).memory(factors)?;
    Ok(if session.ask_memory("series", need, "").is_ok() { Precision::F64 } else { Precision::F32 })
}
