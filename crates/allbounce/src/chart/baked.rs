//! The stages of a bake up to the ordered dense operator, as `allbounce bake` runs them, and how long they take.

use formfactor::Budget;
use permute::Order;
use radfile::{Container, Patches, Record, Step};
use reference::rivals::Setting;
use voxel_simplify::{Mode, Pilot, Resolution};

use crate::{
    session::Session,
    stage::{self, kept},
};

/// Rays a patch, as `allbounce bake` sends them.
const RAYS: u32 = 4096;

/// How an operator is made.
pub struct Recipe {
    /// About so many patches.
    patches: u32,
    mode: Mode,
    series: series::Params,
    order: Order,
}

/// A dense operator in its order.
pub struct Dense {
    pub container: Container,
    pub patches: Patches,
    /// What it took up to the form factors.
    pub factors_seconds: f64,
    /// What all of it took.
    pub seconds: f64,
}

impl Recipe {
    /// As `allbounce bake` does.
    pub fn all_bounces(patches: u32) -> Recipe {
        Recipe { patches, mode: Mode::Clusters, series: series::Params::default(), order: Order::default() }
    }

    /// Sides of voxels, so many bounces, greedy order.
    pub fn published(patches: u32, bounces: u32) -> Recipe {
        Recipe { patches, mode: Mode::Faces, series: series::Params::first_bounces(bounces), order: Order::Greedy }
    }
}

/// Runs the stages; a `pilot` makes patches adaptive, and its time counts.
pub fn bake(recipe: &Recipe, pilot: Option<&Dense>, setting: &Setting, session: &Session) -> anyhow::Result<Dense> {
    let (start, progress) = (session.seconds(), session.progress());
    let params = voxel_simplify::Params {
        resolution: Resolution::Patches(recipe.patches),
        mode: recipe.mode,
        ..voxel_simplify::Params::default()
    };
    let earlier = pilot.map_or(0.0, |pilot| pilot.seconds);
    let pilot = pilot.map(|pilot| Pilot::read(&pilot.container)).transpose()?;
    let simple = kept(|sink| {
        Ok(voxel_simplify::run(setting.scene, &params, pilot.as_ref(), step("voxel-simplify"), &progress, sink)
            .map(drop)?)
    })?;
    let n = stage::patch_count(&simple)? as usize;
    let budget = Budget::Rays(RAYS);
    let need = formfactor::memory_needed(n, budget).max(recipe.series.memory_needed(n, 3));
    session.ask_memory("the bake", need, "leave the method out (--methods)")?;
    let params = formfactor::Params { budget, seed: 1 };
    let factors = kept(|sink| Ok(formfactor::run(&simple, &params, step("formfactor"), &progress, sink).map(drop)?))?;
    let factors_seconds = earlier + session.seconds() - start;
    let summed = kept(|sink| Ok(series::run(&factors, &recipe.series, step("series"), &progress, sink).map(drop)?))?;
    let params = permute::Params { order: recipe.order };
    let container = kept(|sink| Ok(permute::run(&summed, &params, step("permute"), &progress, sink).map(drop)?))?;
    let patches = Patches::read(&container)?;
    Ok(Dense { container, patches, factors_seconds, seconds: earlier + session.seconds() - start })
}

/// Provenance that nobody reads: the containers stay in memory.
pub fn step(stage: &str) -> Step {
    stage::step(stage, String::new(), vec![])
}
