//! Lights with extent: quads and emitting triangles.
//!
//! Each is found in two ways, by a point chosen on the light and by the direction in which a path goes on. The
//! balance heuristic (Veach 1997, §9.2.2) weighs them, so near lights are as calm as far ones.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};
use radfile::{Mesh, Side};
use scene::{Hit, Light, LightRig, NO_TRIANGLE, Scene, Sobol, Surfaces};

use super::{CountedRays, Photon, Vertex, random::cosine_direction};

/// Texels that say how bright a triangle is beside others.
const PROBES: u32 = 16;

/// All lights with extent.
pub struct AreaLights<'a> {
    surfaces: &'a Surfaces<'a>,
    /// Quads first.
    emitters: Vec<Emitter>,
    quads: usize,
    /// Mean radiance times area of all, W/sr.
    power: f64,
    /// Up to each emitter, the part of all power.
    cumulative: Vec<f32>,
    /// For each triangle of the mesh the density of its points among all that are chosen, 1/m²; empty if
    /// emitting materials do not shine.
    triangle_density: Vec<f32>,
}

/// A point of a light with extent, chosen among all in proportion to their power.
#[derive(Clone, Copy, Debug)]
pub struct Glow {
    /// Local axes, metres; raised off its surface.
    pub position: Vec3,
    /// Unit normal of the side that emits.
    pub normal: Vec3,
    /// Radiance over the density of such points, W/sr: over many of them its mean is radiance integrated over area.
    pub power: Vec3,
}

/// A flat light, raised off its own plane so that what it lies on does not hide it.
struct Emitter {
    corner: Vec3,
    edge_u: Vec3,
    edge_v: Vec3,
    /// Unit normal of the side that emits.
    normal: Vec3,
    /// Area in m², times mean radiance.
    power: f64,
    /// Density of its points among all that are chosen, 1/m².
    density: f32,
    kind: Kind,
}

enum Kind {
    /// Between both edges.
    Quad { radiance: Vec3 },
    /// Half of that: a triangle of the mesh.
    Triangle(u32),
}

impl<'a> AreaLights<'a> {
    /// The quads of a rig and, if it says so, the emitting materials of the scene.
    pub fn new(scene: &Scene, surfaces: &'a Surfaces<'a>, rig: &LightRig, gap: f32) -> AreaLights<'a> {
        let mut emitters: Vec<Emitter> =
            rig.lights.iter().filter_map(|l| Emitter::quad(l, scene.mesh.origin, gap)).collect();
        let quads = emitters.len();
        let mut triangle_density = Vec::new();
        if rig.use_scene_emission {
            triangle_density = vec![0.0; scene.mesh.triangles.len()];
            let triangles = surfaces.emitters();
            emitters.extend(triangles.iter().filter_map(|&t| Emitter::triangle(&scene.mesh, t, surfaces, gap)));
        }
        let total: f64 = emitters.iter().map(|e| e.power).sum();
        let (mut sum, mut cumulative) = (0.0, Vec::with_capacity(emitters.len()));
        for emitter in &mut emitters {
            sum += emitter.power;
            cumulative.push((sum / total) as f32);
            emitter.density = (emitter.power / total / f64::from(emitter.area())) as f32;
            if let Kind::Triangle(t) = emitter.kind {
                triangle_density[t as usize] = emitter.density;
            }
        }
        AreaLights { surfaces, emitters, quads, power: total, cumulative, triangle_density }
    }

    /// Flux of all, W, mean of the channels; about right where emission is textured.
    pub fn flux(&self) -> f32 {
        PI * self.power as f32
    }

    /// A photon of theirs: the first three numbers choose where it starts, the others where it goes.
    pub fn photon(&self, place: [f32; 3], [x, y]: [f32; 2]) -> Option<Photon> {
        let (emitter, u, v) = self.place(place)?;
        let triangle = match emitter.kind {
            Kind::Quad { .. } => NO_TRIANGLE,
            Kind::Triangle(t) => t,
        };
        Some(Photon {
            origin: emitter.at(u, v),
            direction: cosine_direction(emitter.normal, x, y),
            flux: self.radiance(emitter, u, v) * (PI / emitter.density),
            triangle,
        })
    }

    /// A point on a light: which, and its shares of the edges.
    fn place(&self, [pick, x, y]: [f32; 3]) -> Option<(&Emitter, f32, f32)> {
        let number = self.cumulative.partition_point(|&c| c <= pick).min(self.emitters.len().saturating_sub(1));
        let emitter = self.emitters.get(number)?;
        let (u, v) = emitter.point(x, y);
        Some((emitter, u, v))
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.emitters.is_empty()
    }

    /// One way to the irradiance, W/m²: from a point on a light, which the three numbers choose.
    pub fn chosen(&self, at: &Vertex, rays: &CountedRays, place: [f32; 3]) -> Vec3 {
        let Some((emitter, u, v)) = self.place(place) else { return Vec3::ZERO };
        let target = emitter.at(u, v);
        let way = target - at.position;
        let square = way.length_squared();
        let direction = way / square.sqrt();
        let (facing, leaving) = (at.normal.dot(direction), -emitter.normal.dot(direction));
        if !(facing > 0.0 && leaving > 0.0) {
            return Vec3::ZERO;
        }
        let light = self.radiance(emitter, u, v) * balanced(facing, emitter.density * square / leaving);
        if light != Vec3::ZERO && rays.visible(at, target) { light } else { Vec3::ZERO }
    }

    /// A point on a light, which the three numbers choose; `None` where there are no such lights.
    pub fn glow(&self, place: [f32; 3]) -> Option<Glow> {
        let (emitter, u, v) = self.place(place)?;
        Some(Glow {
            position: emitter.at(u, v),
            normal: emitter.normal,
            power: self.radiance(emitter, u, v) / emitter.density,
        })
    }

    /// The other way: from what is seen in `direction`, chosen with density cos θ / π, where the ray ends at `hit`.
    pub fn met(&self, at: &Vertex, direction: Vec3, hit: Option<&Hit>) -> Vec3 {
        let facing = at.normal.dot(direction);
        let mut light = Vec3::ZERO;
        if let Some(hit) = hit.filter(|h| h.side == Side::Front) {
            let radiance = self.emission(hit);
            if radiance != Vec3::ZERO {
                light += radiance * balanced(facing, self.density_towards(hit, direction));
            }
        }
        for quad in &self.emitters[..self.quads] {
            let leaving = -quad.normal.dot(direction);
            if let Some(t) = quad.meets(at.position, direction, leaving, hit.map_or(f32::INFINITY, |h| h.t)) {
                let Kind::Quad { radiance } = quad.kind else { continue };
                light += radiance * balanced(facing, quad.density * t * t / leaving);
            }
        }
        light
    }

    /// Radiance that the surface itself sends towards the ray that hit it, W/(m² sr).
    pub fn emission(&self, hit: &Hit) -> Vec3 {
        if self.triangle_density.is_empty() || hit.side == Side::Back {
            return Vec3::ZERO;
        }
        Vec3::from(self.surfaces.emission(hit.triangle, hit.u, hit.v))
    }

    /// Density per solid angle with which [`AreaLights::chosen`] would have chosen this point.
    fn density_towards(&self, hit: &Hit, direction: Vec3) -> f32 {
        let density = self.triangle_density[hit.triangle as usize];
        if density == 0.0 {
            return 0.0; // no texel that was probed shines: found by directions alone
        }
        let leaving = -self.normal_of(hit.triangle).dot(direction);
        if leaving > 0.0 { density * hit.t * hit.t / leaving } else { 0.0 }
    }

    fn normal_of(&self, triangle: u32) -> Vec3 {
        let found = self.emitters[self.quads..].binary_search_by_key(&triangle, |e| match e.kind {
            Kind::Triangle(t) => t,
            Kind::Quad { .. } => 0,
        });
        found.map_or(Vec3::ZERO, |i| self.emitters[self.quads + i].normal)
    }

    fn radiance(&self, emitter: &Emitter, u: f32, v: f32) -> Vec3 {
        match emitter.kind {
            Kind::Quad { radiance } => radiance,
            Kind::Triangle(t) => Vec3::from(self.surfaces.emission(t, u, v)),
        }
    }
}

/// cos θ over the sum of both densities, that of points on lights and cos θ / π: what radiance is multiplied by,
/// whichever way it was found.
fn balanced(facing: f32, density_of_lights: f32) -> f32 {
    facing / (density_of_lights + facing / PI)
}

impl Emitter {
    fn quad(light: &Light, origin: [f64; 3], gap: f32) -> Option<Emitter> {
        let Light::Quad { corner, edge_u, edge_v, radiance } = light else { return None };
        let radiance = Vec3::from(*radiance);
        let corner = (DVec3::from(*corner) - DVec3::from(origin)).as_vec3();
        let mean = f64::from(radiance.element_sum()) / 3.0;
        Emitter::new(corner, Vec3::from(*edge_u), Vec3::from(*edge_v), gap, mean, Kind::Quad { radiance })
    }

    fn triangle(mesh: &Mesh, triangle: u32, surfaces: &Surfaces, gap: f32) -> Option<Emitter> {
        let [a, b, c] = mesh.corners(triangle as usize).map(Vec3::from);
        let (sobol, mut sum) = (Sobol::new(triangle), 0.0);
        for i in 0..PROBES {
            let [x, y, ..] = sobol.sample(i);
            let (u, v) = square_to_triangle(x, y);
            sum += surfaces.emission(triangle, u, v).iter().map(|&e| f64::from(e)).sum::<f64>();
        }
        Emitter::new(a, b - a, c - a, gap, sum / f64::from(3 * PROBES), Kind::Triangle(triangle))
    }

    /// `None` for a light without area or without radiance.
    fn new(corner: Vec3, edge_u: Vec3, edge_v: Vec3, gap: f32, mean: f64, kind: Kind) -> Option<Emitter> {
        let normal = edge_u.cross(edge_v).try_normalize()?;
        let mut emitter =
            Emitter { corner: corner + gap * normal, edge_u, edge_v, normal, power: 0.0, density: 0.0, kind };
        emitter.power = mean * f64::from(emitter.area());
        (emitter.power > 0.0).then_some(emitter)
    }

    fn area(&self) -> f32 {
        let both = self.edge_u.cross(self.edge_v).length();
        if matches!(self.kind, Kind::Quad { .. }) { both } else { 0.5 * both }
    }

    /// Shares of the edges, uniform over the light.
    fn point(&self, x: f32, y: f32) -> (f32, f32) {
        if matches!(self.kind, Kind::Quad { .. }) { (x, y) } else { square_to_triangle(x, y) }
    }

    /// The point at these shares of the edges.
    fn at(&self, u: f32, v: f32) -> Vec3 {
        self.corner + u * self.edge_u + v * self.edge_v
    }

    /// Distance at which a ray meets the parallelogram on its emitting side, below `limit`.
    fn meets(&self, origin: Vec3, direction: Vec3, leaving: f32, limit: f32) -> Option<f32> {
        let t = self.normal.dot(origin - self.corner) / leaving;
        let inside = origin + t * direction - self.corner;
        // Coordinates along the edges, by Cramer's rule in the plane.
        let (square, n) = (self.edge_u.cross(self.edge_v).length(), self.normal);
        let (u, v) = (inside.cross(self.edge_v).dot(n) / square, self.edge_u.cross(inside).dot(n) / square);
        (leaving > 0.0 && t > 0.0 && t < limit && (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v)).then_some(t)
    }
}

/// Weights of the second and third corner, uniform over a triangle. Not `scene`'s, which places the rays of form
/// factors: what is judged by this path tracer must not err with it.
fn square_to_triangle(x: f32, y: f32) -> (f32, f32) {
    let s = x.sqrt();
    (1.0 - s, y * s)
}
