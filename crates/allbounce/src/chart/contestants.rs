//! The methods, in the order of the legend. One line each; settings are in the file of the method, those of
//! [`reference::rivals`] here.

use reference::rivals::{InstantParams, InstantRadiosity};

use super::{ground::Ground, judge::Judge, ours, paths, published};

/// A method.
pub struct Contestant {
    /// As `--methods` knows it.
    pub name: &'static str,
    /// As the chart shows it.
    pub label: &'static str,
    /// Enters all of its settings.
    pub compete: fn(&Ground, &mut Judge) -> anyhow::Result<()>,
}

/// All of them.
pub const ALL: &[Contestant] = &[
    Contestant { name: "gather", label: "Allbounce, last gather", compete: ours::gather },
    Contestant { name: "interpolate", label: "Allbounce, interpolated", compete: ours::interpolate },
    Contestant { name: "published", label: "as published in 2019", compete: published::compete },
    Contestant { name: "path-tracing", label: "path tracing", compete: paths::compete },
    Contestant { name: "instant", label: "instant radiosity", compete: instant },
    Contestant { name: "instant-clamped", label: "instant radiosity, clamped", compete: instant_clamped },
];

/// Paths from the lights.
const INSTANT: [u32; 5] = [16, 64, 256, 1024, 4096];
/// The part of the scene's diagonal within which a light is as bright as at its end.
const CLAMP: f32 = 0.1;

fn instant(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    instant_of(ground, judge, 0.0)
}

fn instant_clamped(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    // To the millimetre, so that it can be read.
    instant_of(ground, judge, (1e3 * CLAMP * ground.diagonal()).ceil() / 1e3)
}

fn instant_of(ground: &Ground, judge: &mut Judge, nearest: f32) -> anyhow::Result<()> {
    ground.some(&INSTANT).iter().try_for_each(|&paths| {
        judge.make(|| Ok(InstantRadiosity::new(ground.setting, InstantParams { paths, nearest, seed: 1 })))
    })
}
