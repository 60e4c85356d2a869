//! Light that is constant on each patch: what methods on patches start from and end with.

use glam::{DVec3, Vec3};
use radfile::Patches;
use rayon::prelude::*;
use scene::{LightRig, NO_TRIANGLE, PatchSampler, Sobol, SurfacePoint, hash, land};

use super::Setting;

/// How direct light on patches is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchLight {
    /// Points on each patch whose light is averaged.
    pub points: u32,
    /// Pairs of rays a point where lights have extent.
    pub samples: u32,
}

/// A setting cut into patches.
pub struct OnPatches<'a> {
    setting: Setting<'a>,
    patches: &'a Patches,
    light: PatchLight,
    /// Those of a patch together.
    points: Vec<SurfacePoint>,
    /// The patch of every receiver, if there is any on its side.
    patch_of: Vec<Option<u32>>,
}

impl<'a> OnPatches<'a> {
    /// Draws the points of patches and looks up the patches of receivers.
    pub fn new(setting: Setting<'a>, patches: &'a Patches, light: PatchLight) -> OnPatches<'a> {
        let sampler = PatchSampler::new(patches);
        let of_patch = |patch: usize| {
            let (sobol, sampler) = (Sobol::new(hash(0x5261, patch as u32)), &sampler);
            (0..light.points).map(move |i| {
                let [x, y, ..] = sobol.sample(i);
                sampler.point(patch, x, y)
            })
        };
        let points = (0..patches.len()).flat_map(of_patch).collect();
        let patch_of = setting.receivers.par_iter().map(|receiver| patch_of(&setting, patches, receiver)).collect();
        OnPatches { setting, patches, light, points, patch_of }
    }

    /// Direct irradiance of every patch, W/m².
    pub fn direct(&self, rig: &LightRig) -> Vec<Vec3> {
        let lights = self.setting.lights(rig);
        let count = self.light.points as usize;
        let of_patch = |patch: usize| {
            let at = |k: usize| lights.irradiance(&self.points[k], self.light.samples, k as u32).as_dvec3();
            let sum: DVec3 = (patch * count..(patch + 1) * count).map(at).sum();
            (sum / count.max(1) as f64).as_vec3()
        };
        (0..self.patches.len()).into_par_iter().map(of_patch).collect()
    }

    /// At every receiver what its patch has; nothing where it has no patch.
    pub fn at_receivers(&self, light: impl Fn(usize) -> [f32; 3]) -> Vec<[f32; 3]> {
        self.patch_of.iter().map(|patch| patch.map_or([0.0; 3], |p| light(p as usize))).collect()
    }

    /// Bytes of points and patch numbers.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.points[..]) + size_of_val(&self.patch_of[..])) as u64
    }
}

/// The patch below a receiver, or else the nearest that faces its way.
fn patch_of(setting: &Setting, patches: &Patches, receiver: &SurfacePoint) -> Option<u32> {
    let SurfacePoint { position, normal, .. } = *receiver;
    // High enough for positions that were rounded below their surface.
    let above = position + 8.0 * setting.rays.gap() * normal;
    land(setting.rays, &patches.locator, above, -normal, NO_TRIANGLE)
        .filter(|landing| landing.position.distance(position) <= patches.locator.cell_size)
        .and_then(|landing| landing.patch)
        .or_else(|| {
            let distance = |&i: &u32| Vec3::from(patches.position[i as usize]).distance_squared(position);
            (0..patches.len() as u32)
                .filter(|&i| Vec3::from(patches.normal[i as usize]).dot(normal) > 0.0)
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        })
}
