//! Surfaces that emit: quads of the rig and emissive triangles of the scene.
//!
//! Irradiance of an area light is its closed form (`polygon.rs`) times the fraction of it that is
//! visible, which is estimated with stratified samples weighted by cos cos / r². So a light in full
//! view carries no noise at all, whatever the number of samples.
//! Source: E. Heitz, S. Hill, M. McGuire, Combining Analytic Direct Illumination and Stochastic
//! Shadows, 2018. Scenes with very many emissive triangles go another way (`crowd.rs`).

use glam::{DVec3, Vec3};
use radfile::Mesh;
use scene::{Rays, Sobol, Surfaces, hash, square_to_triangle};

use crate::{crowd::Crowd, direct::Samples, polygon::irradiance_per_radiance};

/// So many emitters are always lit from in closed form,
const FEW: usize = 64;
/// and so many for each sample that there is to spend.
const FEW_PER_SAMPLE: usize = 4;

/// A place that receives light.
pub struct Receiver {
    /// Moved off its surface.
    pub position: Vec3,
    pub normal: Vec3,
}

/// One emitting polygon.
pub struct Emitter {
    corners: Vec<DVec3>,
    normal: DVec3,
    area: f64,
    source: Source,
    /// Samples are drawn this much closer to the middle, so that rounding does not put them through the next wall.
    shrink: f64,
}

enum Source {
    /// A quad of the rig; it does not occlude.
    Quad([f64; 3]),
    /// An emissive triangle of the mesh.
    Triangle(u32),
}

/// Emitters that share one number of samples.
pub struct Group {
    emitters: Vec<Emitter>,
    crowd: Crowd,
}

/// A point of an emitter.
pub struct Sample {
    pub point: DVec3,
    pub radiance: [f64; 3],
}

impl Emitter {
    /// A parallelogram that emits along `u` × `v`; `None` if it has no area.
    pub fn quad(corner: DVec3, u: DVec3, v: DVec3, radiance: [f32; 3], gap: f32) -> Option<Emitter> {
        Emitter::new(vec![corner, corner + u, corner + u + v, corner + v], Source::Quad(radiance.map(f64::from)), gap)
    }

    /// A triangle of the mesh; `None` if it has no area.
    pub fn triangle(mesh: &Mesh, triangle: u32, gap: f32) -> Option<Emitter> {
        let corners = mesh.corners(triangle as usize).map(|p| Vec3::from(p).as_dvec3());
        Emitter::new(corners.to_vec(), Source::Triangle(triangle), gap)
    }

    fn new(corners: Vec<DVec3>, source: Source, gap: f32) -> Option<Emitter> {
        let cross = (corners[1] - corners[0]).cross(corners[corners.len() - 1] - corners[0]);
        let normal = cross.try_normalize()?;
        let area = cross.length() * if corners.len() == 3 { 0.5 } else { 1.0 };
        let perimeter: f64 = (0..corners.len()).map(|i| corners[i].distance(corners[(i + 1) % corners.len()])).sum();
        // The middle keeps at least two thirds of 2 area / perimeter from every edge.
        let shrink = (6.0 * f64::from(gap) * perimeter / (2.0 * area)).min(1.0);
        Some(Emitter { corners, normal, area, source, shrink })
    }

    /// The point at `(x, y)` of the unit square, uniform over the area.
    pub fn sample(&self, surfaces: &Surfaces, x: f32, y: f32) -> Sample {
        let (u, v) = if self.corners.len() == 3 { square_to_triangle(x, y) } else { (x, y) };
        let at = |u: f64, v: f64| {
            let a = self.corners[0];
            a + u * (self.corners[1] - a) + v * (self.corners[self.corners.len() - 1] - a)
        };
        let middle = self.corners.iter().sum::<DVec3>() / self.corners.len() as f64;
        let radiance = match self.source {
            Source::Quad(radiance) => radiance,
            Source::Triangle(t) => surfaces.emission(t, u, v).map(f64::from),
        };
        Sample { point: at(u.into(), v.into()).lerp(middle, self.shrink), radiance }
    }

    /// Mean of the three channels of the radiance, over sixteen points.
    pub fn mean_radiance(&self, surfaces: &Surfaces) -> f64 {
        let sobol = Sobol::new(1);
        let brightness = |i| {
            let [x, y, ..] = sobol.sample(i);
            self.sample(surfaces, x, y).radiance.iter().sum::<f64>() / 3.0
        };
        (0..16).map(brightness).sum::<f64>() / 16.0
    }

    /// One-sided area, m².
    pub fn area(&self) -> f64 {
        self.area
    }

    /// The triangle of the mesh that it is.
    pub fn mesh_triangle(&self) -> Option<u32> {
        match self.source {
            Source::Quad(_) => None,
            Source::Triangle(t) => Some(t),
        }
    }

    /// Irradiance per radiance with nothing in between; 0 behind the emitter.
    fn unoccluded(&self, at: &Receiver) -> f64 {
        let point = at.position.as_dvec3();
        if (point - self.corners[0]).dot(self.normal) <= 0.0 {
            return 0.0;
        }
        irradiance_per_radiance(&self.corners, point, at.normal.as_dvec3())
    }

    /// cos cos / r² towards a sample, 0 if it is not seen from its front.
    pub fn transport(&self, at: &Receiver, sample: &Sample) -> f64 {
        let way = sample.point - at.position.as_dvec3();
        let square = way.length_squared();
        let cosines = at.normal.as_dvec3().dot(way).max(0.0) * (-self.normal.dot(way)).max(0.0);
        if square > 0.0 { cosines / (square * square) } else { 0.0 }
    }

    /// Whether nothing stands between a place and a sample.
    pub fn sees(&self, rays: &Rays, at: &Receiver, sample: &Sample) -> bool {
        let point = sample.point.as_vec3();
        match self.source {
            Source::Quad(_) => rays.visible(at.position, point, scene::NO_TRIANGLE),
            Source::Triangle(t) => rays.visible(at.position, rays.off_surface(point, self.normal.as_vec3()), t),
        }
    }

    /// Means of `count` samples: of radiance times transport where they are seen, and of transport seen or not.
    fn look(&self, light: &Light, at: &Receiver, count: u32, seed: u32) -> ([f64; 3], f64) {
        let sobol = Sobol::new(seed);
        let (mut seen, mut all) = ([0.0; 3], 0.0);
        for i in 0..count {
            let [x, y, ..] = sobol.sample(i);
            let sample = self.sample(light.surfaces, x, y);
            let transport = self.transport(at, &sample);
            all += transport;
            if transport > 0.0 && self.sees(light.rays, at, &sample) {
                seen = std::array::from_fn(|c| seen[c] + transport * sample.radiance[c]);
            }
        }
        (seen.map(|s| s / f64::from(count)), all / f64::from(count))
    }
}

/// What some places see of one emitter.
#[derive(Clone, Default)]
struct View {
    /// Sum of the closed forms.
    unoccluded: f64,
    /// Sums of the means of [`Emitter::look`].
    seen: [f64; 3],
    all: f64,
}

impl View {
    fn add(&mut self, unoccluded: f64, (seen, all): ([f64; 3], f64)) {
        self.unoccluded += unoccluded;
        self.seen = std::array::from_fn(|c| self.seen[c] + seen[c]);
        self.all += all;
    }

    /// Sum of the irradiances.
    fn irradiance(&self) -> [f64; 3] {
        if self.all > 0.0 { self.seen.map(|s| self.unoccluded * s / self.all) } else { [0.0; 3] }
    }
}

/// What is needed beside the emitters.
pub struct Light<'a> {
    pub rays: &'a Rays,
    pub surfaces: &'a Surfaces<'a>,
}

impl Group {
    /// Emitters that share one number of samples.
    pub fn new(emitters: Vec<Emitter>, surfaces: &Surfaces) -> Group {
        let crowd = Crowd::new(&emitters, surfaces);
        Group { emitters, crowd }
    }

    /// Mean irradiance of the group over some places, W/m²; each has a seed.
    pub fn irradiance(&self, light: &Light, places: &[(Receiver, u32)], samples: &Samples) -> [f64; 3] {
        let sum = if self.emitters.len() <= FEW.max(FEW_PER_SAMPLE * samples.area as usize) {
            self.in_closed_form(light, places, samples.area)
        } else {
            let of =
                |(at, seed): &(Receiver, u32)| self.crowd.irradiance(&self.emitters, light, at, samples.area, *seed);
            places.iter().map(of).fold([0.0; 3], add)
        };
        sum.map(|s| s / places.len() as f64)
    }

    /// Each emitter in closed form; half of the samples go where light would come from without shadows.
    ///
    /// The fraction that is visible is taken of all places at once: a ratio of few samples is biased, so those of a
    /// place that has one for each emitter must not be divided by themselves.
    fn in_closed_form(&self, light: &Light, places: &[(Receiver, u32)], samples: u32) -> [f64; 3] {
        let mut views = vec![View::default(); self.emitters.len()];
        for (at, seed) in places {
            let unoccluded: Vec<f64> = self.emitters.iter().map(|e| e.unoccluded(at)).collect();
            let brightest: f64 = unoccluded.iter().sum();
            let in_view = unoccluded.iter().filter(|u| **u > 0.0).count() as f64;
            for (number, (emitter, &own)) in self.emitters.iter().zip(&unoccluded).enumerate() {
                if own > 0.0 {
                    let share = 0.5 * own / brightest + 0.5 / in_view;
                    let count = (share * f64::from(samples)).ceil() as u32;
                    views[number].add(own, emitter.look(light, at, count, hash(*seed, number as u32)));
                }
            }
        }
        views.iter().map(View::irradiance).fold([0.0; 3], add)
    }
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] + b[c])
}
