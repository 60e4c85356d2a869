//! The lights of a rig as lights without extent: quads, emitting triangles and the sky become several.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec2, Vec3};
use scene::{Light, LightRig};

use super::eye::{Eye, Lobe};
use crate::rivals::Setting;

/// Eyes of all lights: one each for points, spots and suns, `shared` for all quads and emitting triangles together, and as
/// many suns for the sky. Whether an eye is all of its light, too.
pub fn eyes(setting: &Setting, rig: &LightRig, shared: u32) -> Vec<(Eye, bool)> {
    let (centre, radius) = ball(setting);
    let local = |p: &[f64; 3]| (DVec3::from(*p) - DVec3::from(setting.scene.mesh.origin)).as_vec3();
    let unit = |d: &[f32; 3]| Vec3::from(*d).try_normalize().unwrap_or(Vec3::Z);
    let mut eyes = Vec::new();
    for light in &rig.lights {
        match light {
            Light::Point { position, intensity } => {
                let lobe = Lobe::Cone { intensity: Vec3::from(*intensity), penumbra: 0.0 };
                eyes.push((Eye::lamp(local(position), Vec3::Z, PI, lobe), true));
            }
            Light::Spot { position, direction, intensity, half_angle_deg, penumbra_deg } => {
                let lobe = Lobe::Cone { intensity: Vec3::from(*intensity), penumbra: penumbra_deg.to_radians() };
                let half_angle = half_angle_deg.to_radians();
                eyes.push((Eye::lamp(local(position), unit(direction), half_angle, lobe), true));
            }
            Light::Directional { direction, irradiance } => {
                eyes.push((Eye::sun(unit(direction), Vec3::from(*irradiance), centre, radius), true));
            }
            Light::Quad { .. } => {} // with all that glows
            Light::Sky { radiance } => {
                let irradiance = Vec3::from(*radiance) * (4.0 * PI / shared as f32);
                eyes.extend((0..shared).map(|i| (Eye::sun(spiral(i, shared), irradiance, centre, radius), false)));
            }
        }
    }
    let glows = setting.lights(rig).glows(shared, 0);
    eyes.extend(glows.iter().map(|glow| {
        let lobe = Lobe::Cosine { intensity: glow.power / shared as f32 };
        (Eye::lamp(glow.position, glow.normal, FRAC_PI_2, lobe), false)
    }));
    eyes
}

/// Centre and radius of a ball that holds the scene.
fn ball(setting: &Setting) -> (Vec3, f32) {
    let points = || setting.scene.mesh.positions.iter().map(|&p| Vec3::from(p));
    let (low, high) = points().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    let centre = 0.5 * (low + high);
    (centre, points().map(|p| p.distance(centre)).fold(0.0, f32::max))
}

/// Direction `i` of `n` that cover the sphere evenly (Fibonacci's spiral).
fn spiral(i: u32, n: u32) -> Vec3 {
    let z = 1.0 - (2.0 * i as f32 + 1.0) / n as f32;
    let angle = TAU * (f64::from(i) * 0.618_033_988_749_895).fract() as f32;
    ((1.0 - z * z).max(0.0).sqrt() * Vec2::from_angle(angle)).extend(z)
}
