//! Photons: light that sets out, for methods that start at the lights.

use std::f32::consts::PI;

use glam::Vec3;
use radfile::Mesh;
use scene::NO_TRIANGLE;

use super::{
    PathTracer,
    random::{Group, PathNumbers},
};

/// Flux along a ray.
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    /// Where it sets out, local axes, metres: on the light, or outside of the scene.
    pub origin: Vec3,
    /// Unit vector.
    pub direction: Vec3,
    /// W, over the density with which this photon was chosen: the mean over photons is the flux of all lights.
    pub flux: Vec3,
    /// The triangle that emitted it, or [`NO_TRIANGLE`].
    pub triangle: u32,
}

/// The photons of all lights: bright lights send more.
pub struct Emission<'a> {
    tracer: &'a PathTracer<'a>,
    bounds: Sphere,
    lamps: usize,
    /// Up to each lamp, then the lights with extent, then the sky: the share of all photons; empty in the dark.
    cumulative: Vec<f32>,
}

impl PathTracer<'_> {
    /// The photons of the lights.
    pub fn emission(&self) -> Emission<'_> {
        let bounds = Sphere::around(self.mesh);
        let mut fluxes = self.lamps.fluxes(&bounds);
        let lamps = fluxes.len();
        fluxes.push(self.area.flux());
        fluxes.push(self.sky.element_sum() / 3.0 * 4.0 * PI * bounds.cross_section());
        let total: f64 = fluxes.iter().map(|&f| f64::from(f)).sum();
        let mut sum = 0.0;
        let share = |flux: f32| {
            sum += f64::from(flux);
            (sum / total) as f32
        };
        let cumulative = if total > 0.0 { fluxes.into_iter().map(share).collect() } else { vec![] };
        Emission { tracer: self, bounds, lamps, cumulative }
    }
}

impl Emission<'_> {
    /// One photon of those that `numbers.batch` chooses; `None` in the dark.
    pub fn photon(&self, numbers: PathNumbers) -> Option<Photon> {
        let ([pick, inner, ..], [x, y, dx, dy]) = (numbers.at(0, Group::Choices), numbers.at(0, Group::Directions));
        let source = self.cumulative.partition_point(|&c| c <= pick).min(self.cumulative.len().checked_sub(1)?);
        let before = if source == 0 { 0.0 } else { self.cumulative[source - 1] };
        let share = self.cumulative[source] - before;
        let photon = match source.checked_sub(self.lamps) {
            None => self.tracer.lamps.photon(source, &self.bounds, [x, y]),
            Some(0) => self.tracer.area.photon([inner, x, y], [dx, dy])?,
            Some(_) => self.sky([x, y], [dx, dy]),
        };
        Some(Photon { flux: photon.flux / share, ..photon })
    }

    /// From anywhere outside, with directions uniform over the sphere.
    fn sky(&self, place: [f32; 2], [x, y]: [f32; 2]) -> Photon {
        let z = 1.0 - 2.0 * x;
        let (sin, cos) = (2.0 * PI * y).sin_cos();
        let aside = (1.0 - z * z).max(0.0).sqrt();
        let direction = Vec3::new(aside * cos, aside * sin, z);
        let flux = self.tracer.sky * (4.0 * PI * self.bounds.cross_section());
        Photon { origin: self.bounds.before(direction, place), direction, flux, triangle: NO_TRIANGLE }
    }
}

/// A ball that the scene lies in.
pub struct Sphere {
    middle: Vec3,
    radius: f32,
}

impl Sphere {
    fn around(mesh: &Mesh) -> Sphere {
        let points = || mesh.positions.iter().map(|&p| Vec3::from(p));
        let low = points().reduce(Vec3::min).unwrap_or_default();
        let high = points().reduce(Vec3::max).unwrap_or_default();
        let middle = 0.5 * (low + high);
        // A little more, for what lies on the ball to be above its surface.
        Sphere { middle, radius: 1.001 * points().map(|p| p.distance(middle)).fold(0.0, f32::max) }
    }

    /// Area that it shows to parallel light, m².
    pub fn cross_section(&self) -> f32 {
        PI * self.radius * self.radius
    }

    /// A point of the disk through which light of this direction comes in, uniform.
    pub fn before(&self, direction: Vec3, [x, y]: [f32; 2]) -> Vec3 {
        let (s, t) = direction.any_orthonormal_pair();
        let (sin, cos) = (2.0 * PI * y).sin_cos();
        self.middle + self.radius * (x.sqrt() * (cos * s + sin * t) - direction)
    }
}
