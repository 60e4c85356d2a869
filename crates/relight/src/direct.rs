//! Direct irradiance: light that no surface has reflected yet.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use scene::{LightRig, NO_TRIANGLE, Rays, Scene, Sobol, SurfacePoint, Surfaces, cosine_direction, hash};

use crate::emitters::{self, Emitter, Group, Receiver};

/// How many rays look for shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Samples {
    /// Rays a quad, and for all emissive triangles together.
    pub area: u32,
    /// Rays to the sky.
    pub sky: u32,
}

impl Default for Samples {
    /// Enough for 1 % of a shadowed value.
    fn default() -> Samples {
        Samples { area: 256, sky: 1024 }
    }
}

/// The lights of a rig over the geometry of a scene.
pub struct DirectLight<'a> {
    rays: &'a Rays,
    surfaces: &'a Surfaces<'a>,
    lamps: Vec<Lamp>,
    groups: Vec<Group>,
    sky: [f64; 3],
    /// Only front sides receive.
    one_sided: bool,
    emission: bool,
}

/// A light without extent.
enum Lamp {
    Point { position: DVec3, intensity: [f64; 3], cone: Option<Cone> },
    Directional { direction: DVec3, irradiance: [f64; 3] },
}

/// The cone of a spot; angles in radians.
struct Cone {
    axis: DVec3,
    half_angle: f64,
    penumbra: f64,
}

impl<'a> DirectLight<'a> {
    /// The lights of `rig`, which are in the axes of the scene file, over the triangles of `rays`.
    pub fn new(scene: &Scene, surfaces: &'a Surfaces<'a>, rays: &'a Rays, rig: &LightRig) -> DirectLight<'a> {
        let origin = DVec3::from(scene.mesh.origin);
        let mut light = DirectLight {
            rays,
            surfaces,
            lamps: vec![],
            groups: vec![],
            sky: [0.0; 3],
            one_sided: scene.mesh.one_sided,
            emission: rig.use_scene_emission,
        };
        for l in &rig.lights {
            light.add(l, origin);
        }
        if rig.use_scene_emission {
            let triangles = surfaces.emitters();
            let emitters = triangles.iter().filter_map(|&t| Emitter::triangle(&scene.mesh, t, rays.gap()));
            light.groups.push(Group::new(emitters.collect(), surfaces));
        }
        light
    }

    fn add(&mut self, light: &scene::Light, origin: DVec3) {
        let unit = |v: &[f32; 3]| Vec3::from(*v).as_dvec3().normalize_or_zero();
        let local = |p: &[f64; 3]| DVec3::from(*p) - origin;
        match light {
            scene::Light::Point { position, intensity } => {
                let intensity = intensity.map(f64::from);
                self.lamps.push(Lamp::Point { position: local(position), intensity, cone: None });
            }
            scene::Light::Spot { position, direction, intensity, half_angle_deg, penumbra_deg } => {
                let half_angle = f64::from(*half_angle_deg).to_radians();
                let cone = Cone { axis: unit(direction), half_angle, penumbra: f64::from(*penumbra_deg).to_radians() };
                let (position, intensity) = (local(position), intensity.map(f64::from));
                self.lamps.push(Lamp::Point { position, intensity, cone: Some(cone) });
            }
            scene::Light::Directional { direction, irradiance } => {
                let irradiance = irradiance.map(f64::from);
                self.lamps.push(Lamp::Directional { direction: unit(direction), irradiance });
            }
            scene::Light::Quad { corner, edge_u, edge_v, radiance } => {
                let [u, v] = [edge_u, edge_v].map(|e| Vec3::from(*e).as_dvec3());
                let quad = Emitter::quad(local(corner), u, v, *radiance, self.rays.gap());
                self.groups.push(Group::new(quad.into_iter().collect(), self.surfaces));
            }
            scene::Light::Sky { radiance } => self.sky = std::array::from_fn(|c| self.sky[c] + f64::from(radiance[c])),
        }
    }

    /// Irradiance at a point of a surface, W/m², sky included.
    ///
    /// The triangle of the point does not shade it; [`NO_TRIANGLE`] if it is not known. `seed` chooses
    /// the samples: points with different seeds have independent noise.
    pub fn irradiance(&self, at: &SurfacePoint, samples: &Samples, seed: u32) -> [f64; 3] {
        let lamps = self.irradiance_of_lamps(at, samples, seed);
        let sky = self.irradiance_of_sky(at, samples.sky, seed);
        std::array::from_fn(|c| lamps[c] + sky[c])
    }

    /// Irradiance of everything but the sky, W/m².
    pub fn irradiance_of_lamps(&self, at: &SurfacePoint, samples: &Samples, seed: u32) -> [f64; 3] {
        self.mean_irradiance_of_lamps(&[*at], samples, |_| seed)
    }

    /// The same, mean over points; point i has the seed `seed(i)`, and `samples` are those of one point.
    pub fn mean_irradiance_of_lamps(
        &self,
        points: &[SurfacePoint],
        samples: &Samples,
        seed: impl Fn(u32) -> u32,
    ) -> [f64; 3] {
        let receiver =
            |p: &SurfacePoint| Receiver { position: self.rays.off_surface(p.position, p.normal), normal: p.normal };
        let light = emitters::Light { rays: self.rays, surfaces: self.surfaces };
        let lamps = points.iter().flat_map(|p| {
            let at = receiver(p);
            self.lamps.iter().map(move |l| self.lamp(l, &at, p.triangle).map(|e| e / points.len() as f64))
        });
        let groups = (0..).zip(&self.groups).map(|(number, group)| {
            let place = |(i, p): (u32, &SurfacePoint)| (receiver(p), hash(seed(i), number));
            group.irradiance(&light, &(0..).zip(points).map(place).collect::<Vec<_>>(), samples)
        });
        lamps.chain(groups).fold([0.0; 3], |sum, e| std::array::from_fn(|c| sum[c] + e[c]))
    }

    /// Irradiance of the sky: π · radiance · the part of cosine-weighted directions that leave the scene.
    fn irradiance_of_sky(&self, at: &SurfacePoint, samples: u32, seed: u32) -> [f64; 3] {
        if self.sky == [0.0; 3] || samples == 0 {
            return [0.0; 3];
        }
        let origin = self.rays.off_surface(at.position, at.normal);
        let sobol = Sobol::new(hash(seed, u32::MAX));
        let escapes = |i: &u32| {
            let [x, y, ..] = sobol.sample(*i);
            self.rays.escapes(origin, cosine_direction(at.normal, x, y), at.triangle)
        };
        let open = (0..samples).filter(escapes).count();
        self.sky.map(|l| PI * l * open as f64 / f64::from(samples))
    }

    /// Radiance of the sky, W/(m² sr).
    pub fn sky_radiance(&self) -> [f64; 3] {
        self.sky
    }

    /// Whether emissive materials of the scene shine.
    pub fn uses_scene_emission(&self) -> bool {
        self.emission
    }

    /// Whether only front sides receive light.
    pub fn is_one_sided(&self) -> bool {
        self.one_sided
    }

    fn lamp(&self, lamp: &Lamp, at: &Receiver, triangle: u32) -> [f64; 3] {
        let normal = at.normal.as_dvec3();
        match lamp {
            Lamp::Point { position, intensity, cone } => {
                let way = *position - at.position.as_dvec3();
                let square = way.length_squared();
                let facing = normal.dot(way) / (square * square.sqrt());
                let strength = facing * cone.as_ref().map_or(1.0, |c| c.strength(-way));
                let lit = strength > 0.0
                    && strength.is_finite()
                    && self.rays.visible(at.position, position.as_vec3(), triangle);
                if lit { intensity.map(|i| i * strength) } else { [0.0; 3] }
            }
            Lamp::Directional { direction, irradiance } => {
                let facing = -normal.dot(*direction);
                let lit = facing > 0.0 && self.rays.escapes(at.position, -direction.as_vec3(), triangle);
                if lit { irradiance.map(|e| e * facing) } else { [0.0; 3] }
            }
        }
    }
}

impl Cone {
    /// 1 inside the cone, 0 outside; smooth over the penumbra, which lies inside.
    fn strength(&self, way: DVec3) -> f64 {
        let angle = self.axis.angle_between(way);
        if self.penumbra > 0.0 {
            let x = ((self.half_angle - angle) / self.penumbra).clamp(0.0, 1.0);
            x * x * (3.0 - 2.0 * x)
        } else {
            f64::from(angle <= self.half_angle)
        }
    }
}

/// A point whose triangle is not known.
pub(crate) fn loose_point(position: Vec3, normal: Vec3) -> SurfacePoint {
    SurfacePoint { position, normal, triangle: NO_TRIANGLE }
}
