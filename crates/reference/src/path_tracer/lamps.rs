//! Lights without extent: points, spots, suns.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};
use scene::{Light, LightRig, NO_TRIANGLE};

use super::{CountedRays, Photon, Vertex, emission::Sphere};

/// All lights without extent.
pub struct Lamps(Vec<Lamp>);

enum Lamp {
    /// `cone` is that of a spot. Intensity in W/sr.
    Point { position: Vec3, intensity: Vec3, cone: Option<Cone> },
    /// `towards` is the unit vector to the light; irradiance on a surface that faces it, W/m².
    Directional { towards: Vec3, irradiance: Vec3 },
}

/// Angles in radians.
struct Cone {
    axis: Vec3,
    half_angle: f32,
    penumbra: f32,
}

impl Lamps {
    /// The lamps of a rig, about the local origin.
    pub fn new(rig: &LightRig, origin: [f64; 3]) -> Lamps {
        let local = |p: &[f64; 3]| (DVec3::from(*p) - DVec3::from(origin)).as_vec3();
        let lamp = |light: &Light| match light {
            Light::Point { position, intensity } => {
                Some(Lamp::Point { position: local(position), intensity: Vec3::from(*intensity), cone: None })
            }
            Light::Spot { position, direction, intensity, half_angle_deg, penumbra_deg } => {
                let axis = Vec3::from(*direction).normalize_or_zero();
                let (half_angle, penumbra) = (half_angle_deg.to_radians(), penumbra_deg.to_radians());
                let cone = Some(Cone { axis, half_angle, penumbra });
                Some(Lamp::Point { position: local(position), intensity: Vec3::from(*intensity), cone })
            }
            Light::Directional { direction, irradiance } => {
                let towards = -Vec3::from(*direction).normalize_or_zero();
                Some(Lamp::Directional { towards, irradiance: Vec3::from(*irradiance) })
            }
            Light::Quad { .. } | Light::Sky { .. } => None,
        };
        Lamps(rig.lights.iter().filter_map(lamp).collect())
    }

    /// Flux of each lamp into a scene within `bounds`, W, mean of the channels; that of spots as if they had no penumbra.
    pub fn fluxes(&self, bounds: &Sphere) -> Vec<f32> {
        let mean = |v: Vec3| v.element_sum() / 3.0;
        let flux = |lamp: &Lamp| match lamp {
            Lamp::Point { intensity, cone, .. } => mean(*intensity) * solid_angle(cone.as_ref()),
            Lamp::Directional { irradiance, .. } => mean(*irradiance) * bounds.cross_section(),
        };
        self.0.iter().map(flux).collect()
    }

    /// A photon of one lamp; two numbers choose its way.
    pub fn photon(&self, lamp: usize, bounds: &Sphere, [x, y]: [f32; 2]) -> Photon {
        match &self.0[lamp] {
            Lamp::Point { position, intensity, cone } => {
                let solid_angle = solid_angle(cone.as_ref());
                let axis = cone.as_ref().map_or(Vec3::Z, |c| c.axis);
                // 1 - cos θ is uniform over a cone.
                let drop = x * solid_angle / (2.0 * PI);
                let (s, t) = axis.any_orthonormal_pair();
                let (sin, cos) = (2.0 * PI * y).sin_cos();
                let aside = (drop * (2.0 - drop)).max(0.0).sqrt();
                let direction = (aside * (cos * s + sin * t) + (1.0 - drop) * axis).normalize_or_zero();
                let strength = cone.as_ref().map_or(1.0, |c| c.strength(direction));
                let flux = *intensity * (strength * solid_angle);
                Photon { origin: *position, direction, flux, triangle: NO_TRIANGLE }
            }
            Lamp::Directional { towards, irradiance } => Photon {
                origin: bounds.before(-*towards, [x, y]),
                direction: -*towards,
                flux: *irradiance * bounds.cross_section(),
                triangle: NO_TRIANGLE,
            },
        }
    }

    /// Irradiance of all lamps, W/m²: exact.
    pub fn all(&self, at: &Vertex, rays: &CountedRays) -> Vec3 {
        let lit = |lamp: &Lamp| {
            let light = lamp.unshadowed(at);
            if light != Vec3::ZERO && lamp.is_seen(at, rays) { light } else { Vec3::ZERO }
        };
        self.0.iter().map(lit).sum()
    }

    /// Irradiance of all lamps, W/m², estimated with one shadow ray: a lamp is chosen in proportion to what it
    /// would give unshadowed. `x` in [0, 1) chooses.
    pub fn one(&self, at: &Vertex, rays: &CountedRays, mut x: f32) -> Vec3 {
        let (mut total, mut chosen) = (0.0, None);
        for lamp in &self.0 {
            let light = lamp.unshadowed(at);
            let strength = light.element_sum();
            if strength > 0.0 {
                total += strength;
                // Each lamp takes the place of the one before with its share of the sum so far.
                let share = strength / total;
                if x < share {
                    (chosen, x) = (Some((lamp, light / strength)), x / share);
                } else {
                    x = (x - share) / (1.0 - share);
                }
            }
        }
        match chosen {
            Some((lamp, colour)) if lamp.is_seen(at, rays) => total * colour,
            _ => Vec3::ZERO,
        }
    }
}

impl Lamp {
    /// Irradiance if nothing is in the way.
    fn unshadowed(&self, at: &Vertex) -> Vec3 {
        match self {
            Lamp::Point { position, intensity, cone } => {
                let way = *position - at.position;
                let distance = way.length();
                let facing = at.normal.dot(way) / distance;
                let strength = cone.as_ref().map_or(1.0, |c| c.strength(-way));
                // A point in the lamp itself has no direction to it: NaN, which is not above 0.
                if facing > 0.0 { *intensity * (strength * facing / distance / distance) } else { Vec3::ZERO }
            }
            Lamp::Directional { towards, irradiance } => *irradiance * at.normal.dot(*towards).max(0.0),
        }
    }

    fn is_seen(&self, at: &Vertex, rays: &CountedRays) -> bool {
        match self {
            Lamp::Point { position, .. } => rays.visible(at, *position),
            Lamp::Directional { towards, .. } => rays.escapes(at, *towards),
        }
    }
}

/// Of a cone, or of all directions, sr.
fn solid_angle(cone: Option<&Cone>) -> f32 {
    let half_angle = cone.map_or(PI, |c| c.half_angle);
    4.0 * PI * (0.5 * half_angle).sin().powi(2)
}

impl Cone {
    /// 1 inside the cone and 0 outside; over the penumbra, the last degrees inside, smooth in the angle.
    fn strength(&self, way: Vec3) -> f32 {
        let angle = self.axis.cross(way).length().atan2(self.axis.dot(way)); // exact for small angles, too
        if self.penumbra > 0.0 {
            let x = ((self.half_angle - angle) / self.penumbra).clamp(0.0, 1.0);
            x * x * (3.0 - 2.0 * x)
        } else {
            if angle <= self.half_angle { 1.0 } else { 0.0 }
        }
    }
}
