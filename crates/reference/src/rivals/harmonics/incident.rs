//! Incident light in spherical harmonics: what the run time of precomputed transfer starts from.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use scene::{Light, LightRig, NO_TRIANGLE, SurfacePoint};

use super::{
    basis::{Basis, MAX_FUNCTIONS},
    centres::Centres,
};
use crate::{path_tracer::Glow, rivals::Setting};

/// Coefficients of radiance, one for each function of the basis, RGB, W/(m² sr).
pub type Coefficients = [Vec3; MAX_FUNCTIONS];

/// Light from outside of the scene: suns and the sky.
pub fn distant(rig: &LightRig, basis: &Basis) -> Coefficients {
    let mut light = [Vec3::ZERO; MAX_FUNCTIONS];
    for one in &rig.lights {
        match one {
            Light::Directional { direction, irradiance } => {
                let towards = -Vec3::from(*direction).normalize_or_zero();
                add(&mut light, basis, towards, Vec3::from(*irradiance));
            }
            // Y of band 0 is 1 / √4π.
            Light::Sky { radiance } => light[0] += Vec3::from(*radiance) * (4.0 * std::f32::consts::PI).sqrt(),
            Light::Point { .. } | Light::Spot { .. } | Light::Quad { .. } => {}
        }
    }
    light
}

/// Light from within the scene, as each centre sees it: points, spots, quads and emitting surfaces.
pub struct Nearby<'a> {
    setting: &'a Setting<'a>,
    basis: &'a Basis,
    /// Each lamp by itself, and where it is.
    lamps: Vec<(Vec3, crate::rivals::Lights<'a>)>,
    glows: Vec<Glow>,
}

impl<'a> Nearby<'a> {
    /// `samples` points stand for quads and emitting surfaces.
    pub fn new(setting: &'a Setting<'a>, basis: &'a Basis, rig: &LightRig, samples: u32, seed: u32) -> Nearby<'a> {
        let origin = DVec3::from(setting.scene.mesh.origin);
        let lamp = |light: &Light| match light {
            Light::Point { position, .. } | Light::Spot { position, .. } => {
                let alone = LightRig { lights: vec![*light], ..LightRig::default() };
                Some(((DVec3::from(*position) - origin).as_vec3(), setting.lights(&alone)))
            }
            Light::Directional { .. } | Light::Quad { .. } | Light::Sky { .. } => None,
        };
        let lamps = rig.lights.iter().filter_map(lamp).collect();
        Nearby { setting, basis, lamps, glows: setting.lights(rig).glows(samples, seed) }
    }

    /// What one centre sees.
    pub fn at(&self, centre: Vec3) -> Coefficients {
        let mut light = [Vec3::ZERO; MAX_FUNCTIONS];
        for (position, lamp) in &self.lamps {
            let Some(towards) = (*position - centre).try_normalize() else { continue };
            // A surface that faces the lamp receives its radiance integrated over the directions to it.
            let facing = SurfacePoint { position: centre, normal: towards, triangle: NO_TRIANGLE };
            add(&mut light, self.basis, towards, lamp.irradiance(&facing, 0, 0));
        }
        let share = 1.0 / self.glows.len().max(1) as f32;
        for glow in &self.glows {
            let way = glow.position - centre;
            let Some(towards) = way.try_normalize() else { continue };
            let leaving = -glow.normal.dot(towards);
            if leaving > 0.0 && self.setting.rays.visible(centre, glow.position, NO_TRIANGLE) {
                add(&mut light, self.basis, towards, glow.power * (share * leaving / way.length_squared()));
            }
        }
        light
    }
}

/// As [`Nearby::at`] for all centres, on all threads.
pub fn nearby(nearby: &Nearby, centres: &Centres) -> Vec<Coefficients> {
    centres.0.par_iter().map(|&c| nearby.at(c)).collect()
}

fn add(light: &mut Coefficients, basis: &Basis, towards: Vec3, irradiance: Vec3) {
    light.iter_mut().zip(basis.at(towards)).for_each(|(light, y)| *light += y * irradiance);
}
