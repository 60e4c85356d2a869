//! The coarse bake that adaptive patches are made by: uniform patches, a few rays, all bounces.

use std::path::Path;

use anyhow::bail;
use formfactor::Budget;
use radfile::{Container, Quiet};
use series::Params;

use crate::{
    session::Session,
    stage::{self, kept},
    voxel_simplify,
};

/// Rays a patch.
const RAYS: u32 = 1024;

/// Makes the pilot of a bake with these options.
pub fn make(scene: &Path, options: &voxel_simplify::Options, session: &Session) -> anyhow::Result<Container> {
    if options.is_of_faces() {
        bail!("--adaptive joins clusters; leave out --mode faces");
    }
    let simple = kept(|sink| voxel_simplify::apply(scene, &options.of_pilot(), None, session, sink).map(drop))?;
    let patches = stage::patch_count(&simple)? as usize;
    let budget = Budget::Rays(RAYS);
    let need = formfactor::memory_needed(patches, budget).max(series::memory_needed(patches, 3));
    session.ask_memory("the pilot", need, "ask for fewer patches (--patches N)")?;
    let step = |stage: &str| stage::step(stage, String::new(), vec![]);
    let params = formfactor::Params { budget, seed: 1 };
    let factors = kept(|sink| Ok(formfactor::run(&simple, &params, step("formfactor"), &Quiet, sink).map(drop)?))?;
    kept(|sink| Ok(series::run(&factors, &Params::default(), step("series"), &Quiet, sink).map(drop)?))
}
