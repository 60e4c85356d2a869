//! Instant radiosity: few strong photons become lights.
//!
//! Source: A. Keller, Instant radiosity, SIGGRAPH 1997. Quasi-random paths leave the lights; wherever one lands, a
//! diffuse light is put that stands for all light which that landing reflects, and receivers add these lights up, each
//! with its shadow ray instead of the paper's shadow buffer. Lights near a receiver give bright spots, as the geometry
//! term cos cos / r² grows without bound; it is usually clamped, which loses light in corners (T. Kollig, A. Keller,
//! Illumination in the presence of weak singularities, MCQMC 2004).

use glam::{DVec3, Vec3};
use radfile::Progress;
use rayon::prelude::*;
use scene::{LightRig, SurfacePoint};

use super::{Rival, Setting};
use crate::path_tracer::Landing;

/// How lights are placed and added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstantParams {
    /// Paths from the lights; each places one light or more, 1 / (1 - ρ) in a closed room of reflectance ρ. Powers of two
    /// are stratified best.
    pub paths: u32,
    /// The geometry term is at most that of two facing points at this distance, metres; 0 does not limit it.
    pub nearest: f32,
    /// Chooses the paths: means over seeds of unlimited answers have no bias.
    pub seed: u32,
}

/// Instant radiosity over a setting.
pub struct InstantRadiosity<'a> {
    setting: Setting<'a>,
    params: InstantParams,
}

impl<'a> InstantRadiosity<'a> {
    /// Nothing is prepared.
    pub fn new(setting: Setting<'a>, params: InstantParams) -> InstantRadiosity<'a> {
        InstantRadiosity { setting, params }
    }

    /// Irradiance of all virtual lights at one receiver, W/m².
    fn gather(&self, lights: &[VirtualLight], receiver: &SurfacePoint) -> [f32; 3] {
        let rays = self.setting.rays;
        let at = rays.off_surface(receiver.position, receiver.normal);
        let largest = self.params.nearest.powi(2).recip(); // infinity if not limited
        let mut sum = DVec3::ZERO;
        for light in lights {
            let way = light.position - at;
            let square = way.length_squared();
            // Both cosines, each still times the distance.
            let (facing, leaving) = (receiver.normal.dot(way), -light.normal.dot(way));
            if facing > 0.0 && leaving > 0.0 && rays.visible(at, light.position, receiver.triangle) {
                let geometry = (facing * leaving / (square * square)).min(largest);
                sum += (geometry * light.intensity).as_dvec3();
            }
        }
        sum.as_vec3().to_array()
    }
}

impl Rival for InstantRadiosity<'_> {
    fn name(&self) -> String {
        let InstantParams { paths, nearest, .. } = self.params;
        let clamped = if nearest > 0.0 { format!(", clamped at {nearest} m") } else { String::new() };
        format!("instant radiosity, {paths} paths{clamped}")
    }

    fn indirect(&mut self, rig: &LightRig, progress: &dyn Progress) -> Vec<[f32; 3]> {
        let landings = self.setting.lights(rig).landings(self.params.paths, u32::MAX, self.params.seed);
        let lights: Vec<VirtualLight> = landings.iter().filter_map(VirtualLight::new).collect();
        progress.begin("receivers", self.setting.receivers.len() as u64);
        let one = |receiver| {
            let light = self.gather(&lights, receiver);
            progress.advance(1);
            light
        };
        self.setting.receivers.par_iter().map(one).collect()
    }

    fn bytes(&self) -> u64 {
        0
    }
}

/// A diffuse light on a surface, which is raised a little.
struct VirtualLight {
    position: Vec3,
    normal: Vec3,
    /// Along the normal, W/sr.
    intensity: Vec3,
}

impl VirtualLight {
    /// What a landing reflects; `None` on black.
    fn new(landing: &Landing) -> Option<VirtualLight> {
        let intensity = landing.flux * landing.reflectance / std::f32::consts::PI;
        let light = VirtualLight { position: landing.position, normal: landing.normal, intensity };
        (intensity != Vec3::ZERO).then_some(light)
    }
}
