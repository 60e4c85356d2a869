//! Other ways to light a still scene under lights that change, to hold Allbounce against.
//!
//! Each is a folder or file of its own, made from its source. What the authors leave open is set to what was best in small closed
//! rooms and the Cornell box, and whoever holds a rival against others tries several settings. None shares more with the
//! product than [`crate::PathTracer`] does. All see the same scene, lights and receivers, and spread their work over
//! the threads of the current rayon pool, but for what goes one step after the other: the shots of progressive refinement.

mod cones;
mod harmonics;
mod instant;
mod lpv;
mod on_patches;
mod radiosity;
mod rsm;
mod setting;
mod shooting;

pub use cones::{ConeParams, VoxelCones};
pub use harmonics::{Harmonics, HarmonicsParams};
pub use instant::{InstantParams, InstantRadiosity};
pub use lpv::{LightPropagationVolumes, VolumeParams};
pub use on_patches::PatchLight;
pub use radiosity::{Radiosity, product};
pub use rsm::{ReflectiveShadowMaps, ShadowMapParams};
pub use setting::{Lights, Setting};
pub use shooting::{Shooting, ShootingParams};

use radfile::Progress;
use scene::LightRig;

/// A method, prepared for one [`Setting`].
pub trait Rival {
    /// What it is called and how it is set, as a chart labels it: `instant radiosity, 1024 lights`.
    fn name(&self) -> String;

    /// Irradiance after one and more bounces at every receiver, W/m². All of what a change of the lights costs is done here,
    /// and nothing is kept from one call to the next that the lights decide.
    fn indirect(&mut self, rig: &LightRig, progress: &dyn Progress) -> Vec<[f32; 3]>;

    /// Bytes that it keeps from one change of the lights to the next, beyond the scene itself.
    fn bytes(&self) -> u64;
}
