//! The methods, in the order of the legend. One line each; settings are in the file of the method, those of
//! [`reference::rivals`] here.

use radfile::{FormFactors, Record};
use reference::rivals::{
    ConeParams, Harmonics, HarmonicsParams, InstantParams, InstantRadiosity, LightPropagationVolumes, PatchLight,
    Radiosity, ReflectiveShadowMaps, ShadowMapParams, Shooting, ShootingParams, VolumeParams, VoxelCones,
};

use super::{ground::Ground, judge::Judge, ours, paths, published};

/// A method.
pub struct Contestant {
    /// As `--methods` knows it.
    pub name: &'static str,
    /// As the chart shows it.
    pub label: &'static str,
    /// Enters its settings as the judge chooses.
    pub compete: fn(&Ground, &mut Judge) -> anyhow::Result<()>,
}

/// All of them.
pub const ALL: &[Contestant] = &[
    Contestant { name: "gather", label: "Allbounce, last gather", compete: ours::gather },
    Contestant { name: "interpolate", label: "Allbounce, interpolated", compete: ours::interpolate },
    Contestant { name: "published", label: "as published in 2019", compete: published::compete },
    Contestant { name: "path-tracing", label: "path tracing", compete: paths::compete },
    Contestant { name: "radiosity", label: "classical radiosity", compete: radiosity },
    Contestant { name: "shooting", label: "progressive refinement", compete: shooting },
    Contestant { name: "instant", label: "instant radiosity", compete: instant },
    Contestant { name: "instant-clamped", label: "instant radiosity, clamped", compete: instant_clamped },
    Contestant { name: "shadow-maps", label: "reflective shadow maps", compete: shadow_maps },
    Contestant { name: "volumes", label: "light propagation volumes", compete: volumes },
    Contestant { name: "cones", label: "voxel cones", compete: cones },
    Contestant { name: "harmonics", label: "harmonic transfer", compete: harmonics },
];

/// Direct light on patches, as Allbounce has it in the chart.
const PATCH_LIGHT: PatchLight = PatchLight { points: 16, samples: 1 };
/// Patches and bounces.
const RADIOSITY: [(u32, u32); 7] = [(200, 8), (500, 8), (1000, 8), (2500, 8), (5000, 8), (1000, 3), (1000, 16)];
/// Patches and most shots.
const SHOOTING: [(u32, u32); 5] = [(200, 400), (500, 1000), (1000, 2000), (2500, 5000), (2500, 500)];
/// What may be left unshot; it is spread evenly, as the authors do.
const UNSHOT: f64 = 0.02;
/// Paths from the lights.
const INSTANT: [u32; 5] = [16, 64, 256, 1024, 4096];
/// The part of the scene's diagonal within which a light is as bright as at its end.
const CLAMP: f32 = 0.1;
/// Pixels along a map, and samples of a receiver.
const SHADOW_MAPS: [(usize, u32); 3] = [(128, 100), (128, 400), (256, 1600)];
/// Cells along a cascade, and steps.
const VOLUMES: [(u32, u32); 5] = [(6, 24), (8, 32), (8, 64), (16, 64), (32, 64)];
/// Cells along the scene, cones, and bounces.
const CONES: [(u32, u32, u32); 6] = [(16, 6, 2), (16, 24, 8), (32, 24, 4), (32, 24, 8), (64, 24, 8), (128, 24, 8)];
/// Bands, and points in the air.
const HARMONICS: [(usize, usize); 4] = [(3, 8), (4, 32), (5, 32), (4, 128)];

fn radiosity(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    judge.choice.of(&RADIOSITY).iter().try_for_each(|&(patches, bounces)| {
        let dense = ground.all_bounces(patches)?;
        let factors = FormFactors::read(&dense.container)?;
        let mut rival = Radiosity::new(ground.setting, &dense.patches, &factors, bounces, PATCH_LIGHT);
        judge.enter(dense.factors_seconds, &mut rival)
    })
}

fn shooting(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    judge.choice.of(&SHOOTING).iter().try_for_each(|&(patches, shots)| {
        let dense = ground.all_bounces(patches)?;
        let factors = FormFactors::read(&dense.container)?;
        let params = ShootingParams { shots, unshot: UNSHOT, ambient: true };
        let mut rival = Shooting::new(ground.setting, &dense.patches, &factors, params, PATCH_LIGHT);
        judge.enter(dense.factors_seconds, &mut rival)
    })
}

fn instant(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    instant_of(ground, judge, 0.0)
}

fn instant_clamped(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    // To the millimetre, so that it can be read.
    instant_of(ground, judge, (1e3 * CLAMP * ground.diagonal()).ceil() / 1e3)
}

fn instant_of(ground: &Ground, judge: &mut Judge, nearest: f32) -> anyhow::Result<()> {
    judge.choice.of(&INSTANT).iter().try_for_each(|&paths| {
        judge.make(|| Ok(InstantRadiosity::new(ground.setting, InstantParams { paths, nearest, seed: 1 })))
    })
}

fn shadow_maps(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    judge.choice.of(&SHADOW_MAPS).iter().try_for_each(|&(side, samples)| {
        let params = ShadowMapParams { side, samples, ..ShadowMapParams::default() };
        judge.make(|| Ok(ReflectiveShadowMaps::new(ground.setting, params)))
    })
}

fn volumes(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    judge.choice.of(&VOLUMES).iter().try_for_each(|&(cells, steps)| {
        let params = VolumeParams { cells, steps, ..VolumeParams::default() };
        judge.make(|| Ok(LightPropagationVolumes::new(ground.setting, params)))
    })
}

fn cones(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    judge.choice.of(&CONES).iter().try_for_each(|&(resolution, cones, bounces)| {
        let params = ConeParams { resolution, cones, bounces, ..ConeParams::default() };
        let need = VoxelCones::bytes_needed(&ground.setting, &params);
        ground.session.ask_memory("voxel cones", need, "leave them out (--methods)")?;
        judge.make(|| Ok(VoxelCones::new(ground.setting, params)))
    })
}

fn harmonics(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    judge.choice.of(&HARMONICS).iter().try_for_each(|&(bands, centres)| {
        let params = HarmonicsParams { bands, centres, ..HarmonicsParams::default() };
        let need = Harmonics::bytes_needed(ground.setting.receivers.len(), &params);
        ground.session.ask_memory("harmonic transfer", need, "take fewer receivers (--receivers)")?;
        judge.make(|| Ok(Harmonics::new(ground.setting, params, &ground.session.progress())))
    })
}
