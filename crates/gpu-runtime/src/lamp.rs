//! From a lights file to lamps with shadow views: host side of `shaders/lamp.wgsl`.
//!
//! Lights come in the scene file's axes and leave in local ones. A quad becomes points in the middle of
//! equal parts (midpoint rule), each with the views of its hemisphere.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use scene::{Light, LightRig};

use crate::{Error, Result, emitters::Emitter, view::View};

/// One lamp, see `shaders/lamp.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Lamp {
    pub views: [View; 6],
    pub position: [f32; 3],
    pub kind: u32,
    pub axis: [f32; 3],
    pub view_count: u32,
    pub colour: [f32; 3],
    pub resolution: u32,
    pub half_angle: f32,
    pub penumbra: f32,
    pub area: f32,
    pub unused: u32,
}

const POINT: u32 = 0;
const SPOT: u32 = 1;
const DIRECTIONAL: u32 = 2;
const SURFACE: u32 = 3;

/// Spots up to this half angle have one view, wider ones a cube: near 90° a single view spends its texels badly.
const NARROW_DEG: f32 = 60.0;

/// What shines in a frame.
pub struct Lamps {
    /// In the order of the file, then those of shining surfaces.
    pub lamps: Vec<Lamp>,
    /// Radiance of the sky, W/(m² sr).
    pub sky: [f32; 3],
}

/// What making lamps needs to know of the scene.
pub struct Studio {
    /// Local origin in the scene file's axes.
    pub origin: DVec3,
    /// Lower and upper corner of the mesh, local axes.
    pub bounds: [Vec3; 2],
    /// Samples of the scene's shining surfaces.
    pub emitters: Vec<Emitter>,
    /// Points on a quad.
    pub light_samples: u32,
    /// Edge of a shadow map, texels.
    pub resolution: u32,
}

impl Studio {
    /// What lies nearer to a lamp than this casts no shadow, metres.
    fn near(&self) -> f32 {
        1e-4 * (self.bounds[1] - self.bounds[0]).length().max(1e-6)
    }

    /// The lamps of a lights file.
    pub fn lamps(&self, rig: &LightRig) -> Result<Lamps> {
        let mut all = Lamps { lamps: Vec::new(), sky: [0.0; 3] };
        for (i, light) in rig.lights.iter().enumerate() {
            let bad = |what: &str| Error::Input { what: format!("light {i} ({}): {what}", light.kind()) };
            match *light {
                Light::Point { position, intensity } => all.lamps.push(self.point(position, intensity)),
                Light::Spot { position, direction, intensity, half_angle_deg, penumbra_deg } => {
                    let axis = unit(direction).ok_or_else(|| bad("its direction has no length"))?;
                    all.lamps.push(self.spot(position, axis, intensity, half_angle_deg, penumbra_deg));
                }
                Light::Directional { direction, irradiance } => {
                    let axis = unit(direction).ok_or_else(|| bad("its direction has no length"))?;
                    all.lamps.push(self.directional(axis, irradiance));
                }
                Light::Quad { corner, edge_u, edge_v, radiance } => {
                    let edges = [edge_u, edge_v].map(|e| Vec3::from(e).as_dvec3());
                    let normal = edges[0].cross(edges[1]).try_normalize().ok_or_else(|| bad("it has no area"))?;
                    self.quad(corner, edges, normal, radiance, &mut all.lamps);
                }
                Light::Sky { radiance } => all.sky = std::array::from_fn(|c| all.sky[c] + radiance[c]),
            }
        }
        if rig.use_scene_emission {
            all.lamps.extend(self.emitters.iter().map(|e| self.surface(e)));
        }
        Ok(all)
    }

    fn local(&self, position: [f64; 3]) -> DVec3 {
        DVec3::from(position) - self.origin
    }

    fn point(&self, position: [f64; 3], colour: [f32; 3]) -> Lamp {
        let eye = self.local(position);
        let (position, views) = (eye.as_vec3().to_array(), View::cube(eye, DVec3::Z, self.near()));
        Lamp { views, view_count: 6, position, kind: POINT, colour, resolution: self.resolution, ..Lamp::default() }
    }

    fn spot(&self, position: [f64; 3], axis: DVec3, colour: [f32; 3], half_angle: f32, penumbra: f32) -> Lamp {
        let eye = self.local(position);
        let (views, view_count) = if half_angle > NARROW_DEG {
            (View::cube(eye, axis, self.near()), 6)
        } else {
            let (right, up) = axis.any_orthonormal_pair();
            // Two texels of margin, so that the border of the cone has neighbours.
            let tangent = f64::from(half_angle).to_radians().tan() * (1.0 + 4.0 / f64::from(self.resolution));
            let mut views = [View::default(); 6];
            views[0] = View::perspective(eye, [right, up, axis], [tangent; 2], self.near());
            (views, 1)
        };
        Lamp {
            views,
            view_count,
            position: eye.as_vec3().to_array(),
            axis: axis.as_vec3().to_array(),
            kind: SPOT,
            colour,
            resolution: self.resolution,
            half_angle: half_angle.to_radians(),
            penumbra: penumbra.to_radians(),
            ..Lamp::default()
        }
    }

    fn directional(&self, axis: DVec3, colour: [f32; 3]) -> Lamp {
        let mut views = [View::default(); 6];
        views[0] = View::parallel(axis, self.bounds, 4.0 / f64::from(self.resolution));
        let axis = axis.as_vec3().to_array();
        Lamp { views, view_count: 1, axis, kind: DIRECTIONAL, colour, resolution: self.resolution, ..Lamp::default() }
    }

    fn quad(&self, corner: [f64; 3], edges: [DVec3; 2], normal: DVec3, radiance: [f32; 3], lamps: &mut Vec<Lamp>) {
        let [across, along] = split(self.light_samples, edges[0].length() / edges[1].length());
        let area = (edges[0].cross(edges[1]).length() / f64::from(across * along)) as f32;
        for k in 0..across * along {
            let u = (f64::from(k % across) + 0.5) / f64::from(across);
            let v = (f64::from(k / across) + 0.5) / f64::from(along);
            let position = self.local(corner) + u * edges[0] + v * edges[1];
            lamps.push(self.surface(&Emitter { position, normal, radiance, area }));
        }
    }

    /// A small shining surface. It is one of many, so half the resolution serves.
    fn surface(&self, emitter: &Emitter) -> Lamp {
        Lamp {
            views: View::cube(emitter.position, emitter.normal, self.near()),
            // All but the one backwards.
            view_count: 5,
            position: emitter.position.as_vec3().to_array(),
            axis: emitter.normal.as_vec3().to_array(),
            kind: SURFACE,
            colour: emitter.radiance,
            resolution: (self.resolution / 2).max(1),
            area: emitter.area,
            ..Lamp::default()
        }
    }
}

/// A direction as a unit vector.
fn unit(direction: [f32; 3]) -> Option<DVec3> {
    Vec3::from(direction).as_dvec3().try_normalize()
}

/// About `count` equal parts of a rectangle whose first edge is `aspect` times the second, nearly square ones.
fn split(count: u32, aspect: f64) -> [u32; 2] {
    let count = f64::from(count.max(1));
    let across = (count * aspect).sqrt().round().clamp(1.0, count);
    [across as u32, (count / across).round().max(1.0) as u32]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn studio() -> Studio {
        Studio {
            origin: DVec3::new(1000.0, 0.0, 0.0),
            bounds: [Vec3::ZERO, Vec3::ONE],
            emitters: vec![],
            light_samples: 16,
            resolution: 64,
        }
    }

    fn rig(light: Light) -> LightRig {
        LightRig { lights: vec![light], ..LightRig::default() }
    }

    #[test]
    fn lights_move_to_local_axes() {
        let light = Light::Point { position: [1000.5, 0.25, 0.0], intensity: [1.0; 3] };
        let lamps = studio().lamps(&rig(light)).unwrap().lamps;
        assert_eq!((lamps.len(), lamps[0].position), (1, [0.5, 0.25, 0.0]));
    }

    #[test]
    fn the_points_of_a_quad_share_its_area_and_mean_position() {
        let light = Light::Quad {
            corner: [1000.0, 1.0, 0.0],
            edge_u: [2.0, 0.0, 0.0],
            edge_v: [0.0, 0.0, 0.5],
            radiance: [3.0; 3],
        };
        let lamps = studio().lamps(&rig(light)).unwrap().lamps;
        assert_eq!(lamps.len(), 16, "8 x 2");
        let area: f32 = lamps.iter().map(|l| l.area).sum();
        let mean: Vec3 = lamps.iter().map(|l| Vec3::from(l.position)).sum::<Vec3>() / 16.0;
        assert!((area - 1.0).abs() < 1e-6 && (mean - Vec3::new(1.0, 1.0, 0.25)).length() < 1e-6, "{area} {mean}");
        assert!(lamps.iter().all(|l| l.axis == [0.0, -1.0, 0.0] && l.resolution == 32 && l.view_count == 5));
    }

    #[test]
    fn skies_add_up() {
        let mut two = rig(Light::Sky { radiance: [1.0, 2.0, 3.0] });
        two.lights.push(Light::Sky { radiance: [0.5; 3] });
        assert_eq!(studio().lamps(&two).unwrap().sky, [1.5, 2.5, 3.5]);
    }

    #[test]
    fn wide_spots_see_all_around_and_narrow_ones_once() {
        for (half_angle_deg, views) in [(30.0, 1), (60.0, 1), (61.0, 6), (180.0, 6)] {
            let (position, direction, intensity) = ([0.0; 3], [0.0, 0.0, -2.0], [1.0; 3]);
            let light = Light::Spot { position, direction, intensity, half_angle_deg, penumbra_deg: 0.0 };
            assert_eq!(studio().lamps(&rig(light)).unwrap().lamps[0].view_count, views, "{half_angle_deg}");
        }
    }

    #[test]
    fn lights_without_direction_or_area_are_named() {
        let flat = Light::Quad { corner: [0.0; 3], edge_u: [1.0; 3], edge_v: [2.0; 3], radiance: [1.0; 3] };
        let still = Light::Directional { direction: [0.0; 3], irradiance: [1.0; 3] };
        for (light, text) in [(flat, "light 0 (quad): it has no area"), (still, "light 0 (directional): its direction")]
        {
            let error = studio().lamps(&rig(light)).err().expect("an unusable light").to_string();
            assert!(error.starts_with(text), "{error}");
        }
    }
}
