//! Pictures: primary rays, direct light with shadow rays, indirect light from the receivers.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use radfile::{NO_RECEIVER, Progress, Side, Transfer, face_id};
use rayon::prelude::*;
use scene::{Camera, Hit, NO_TRIANGLE, Rays, Sobol, SurfacePoint, hash};

use crate::{DirectLight, Frame, Receivers, Relighter, Samples, view::View};

/// Receivers are looked for this high above the surface, relative to their distance: enough for flat
/// triangles, whose rounding is far smaller, and below everything that light could be hidden by.
const RAISED: f32 = 0.01;

/// Linear RGB radiance, W/(m² sr), rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Their radiance.
    pub pixels: Vec<[f32; 3]>,
}

/// Which light is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Parts {
    /// Everything: direct, indirect, emission, sky.
    #[default]
    All,
    /// Direct light as it is reflected to the eye, emission and sky.
    DirectOnly,
    /// Light of one and more bounces as it is reflected to the eye.
    IndirectOnly,
}

/// Size and quality of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Primary rays a pixel.
    pub samples: u32,
    /// Rays that look for shadows, for each primary ray.
    pub shadows: Samples,
    /// Which light is shown.
    pub parts: Parts,
}

impl Default for Look {
    fn default() -> Look {
        let shadows = Samples { area: 8, sky: 16 };
        Look { width: 512, height: 512, samples: 8, shadows, parts: Parts::All }
    }
}

/// What a picture shows: a bake, the lights of the frame, and the light of its patches.
pub struct Shown<'a> {
    /// The bake.
    pub bake: &'a Relighter<'a>,
    /// Its fine mesh and where its receivers are.
    pub transfer: &'a Transfer,
    /// How light comes to them.
    pub receivers: &'a Receivers<'a>,
    /// The lights.
    pub light: &'a DirectLight<'a>,
    /// The light of the patches.
    pub frame: &'a Frame,
}

/// The picture that `camera` takes.
pub fn render(shown: &Shown, camera: &Camera, look: &Look, progress: &dyn Progress) -> Image {
    let fine = &shown.transfer.fine;
    let corner = |t: usize| fine.triangle[t].map(|v| fine.vertex[v as usize]);
    let picture = Picture {
        shown,
        look,
        rays: Rays::from_triangles(fine.triangle.len(), corner),
        received: shown.receivers.indirect(shown.bake, shown.frame),
        view: View::new(camera, shown.bake.scene().mesh.origin, look.width, look.height),
    };
    progress.begin("rows of the picture", look.height as u64);
    let rows: Vec<Vec<[f32; 3]>> = (0..look.height)
        .into_par_iter()
        .map(|y| {
            let row = (0..look.width).map(|x| picture.pixel(x, y)).collect();
            progress.advance(1);
            row
        })
        .collect();
    Image { width: look.width, height: look.height, pixels: rows.concat() }
}

struct Picture<'a> {
    shown: &'a Shown<'a>,
    look: &'a Look,
    /// Over the fine mesh.
    rays: Rays,
    /// Indirect irradiance of the receivers.
    received: Vec<[f32; 3]>,
    view: View,
}

/// What a primary ray met.
struct Seen {
    point: SurfacePoint,
    side: Side,
    fine: Hit,
    /// Barycentric weights of the second and third corner in the triangle of the mesh.
    uv: [f32; 2],
}

impl Picture<'_> {
    fn pixel(&self, x: usize, y: usize) -> [f32; 3] {
        let number = (y * self.look.width + x) as u32;
        let sobol = Sobol::new(hash(0x91c7, number));
        let mut sum = [0.0; 3];
        for i in 0..self.look.samples {
            let [dx, dy, ..] = sobol.sample(i);
            let direction = self.view.direction(x as f64 + f64::from(dx), y as f64 + f64::from(dy));
            let radiance = self.radiance(direction, hash(number, i));
            sum = std::array::from_fn(|c| sum[c] + radiance[c]);
        }
        sum.map(|s: f64| (s / f64::from(self.look.samples)) as f32)
    }

    fn radiance(&self, direction: Vec3, seed: u32) -> [f64; 3] {
        let light = self.shown.light;
        let direct = self.look.parts != Parts::IndirectOnly;
        let Some(hit) = self.rays.closest(self.view.origin, direction, f32::INFINITY, NO_TRIANGLE) else {
            return if direct { light.sky_radiance() } else { [0.0; 3] };
        };
        let seen = self.seen(hit);
        if seen.side == Side::Back && light.is_one_sided() {
            return [0.0; 3];
        }
        let (surfaces, [u, v]) = (self.shown.bake.surfaces(), seen.uv);
        let mut irradiance = if direct { light.irradiance(&seen.point, &self.look.shadows, seed) } else { [0.0; 3] };
        if self.look.parts != Parts::DirectOnly {
            let indirect = self.indirect(&seen);
            irradiance = std::array::from_fn(|c| irradiance[c] + indirect[c]);
        }
        let rho = surfaces.reflectance(seen.point.triangle, u, v);
        let mut radiance: [f64; 3] = std::array::from_fn(|c| f64::from(rho[c]) * irradiance[c] / PI);
        if direct && seen.side == Side::Front && light.uses_scene_emission() {
            let emitted = surfaces.emission(seen.point.triangle, u, v);
            radiance = std::array::from_fn(|c| radiance[c] + f64::from(emitted[c]));
        }
        radiance
    }

    /// The point of the mesh itself under a hit on the fine mesh, whose vertices are rounded.
    fn seen(&self, fine: Hit) -> Seen {
        let mesh = &self.shown.bake.scene().mesh;
        let tessellation = &self.shown.transfer.fine;
        let [a, b, c] = tessellation.triangle[fine.triangle as usize]
            .map(|v| Vec3::from(tessellation.vertex[v as usize]).as_dvec3());
        let position = a + f64::from(fine.u) * (b - a) + f64::from(fine.v) * (c - a);
        let triangle = tessellation.source[fine.triangle as usize];
        let [a, b, c] = mesh.corners(triangle as usize).map(|p| Vec3::from(p).as_dvec3());
        let (u, v) = barycentric([a, b, c], position);
        let front = (b - a).cross(c - a).normalize_or_zero();
        let normal = if fine.side == Side::Front { front } else { -front };
        let position = a + u * (b - a) + v * (c - a);
        let point = SurfacePoint { position: position.as_vec3(), normal: normal.as_vec3(), triangle };
        Seen { point, side: fine.side, fine, uv: [u as f32, v as f32] }
    }

    /// Indirect irradiance between the receivers of the fine triangle. Receivers that the point
    /// cannot see do not count: the triangle may go on behind a wall that stands on it. Where none
    /// is seen the patch answers.
    fn indirect(&self, seen: &Seen) -> [f64; 3] {
        let Hit { triangle, u, v, .. } = seen.fine;
        let receivers = self.shown.transfer.fine.receiver[triangle as usize][seen.side as usize];
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for (receiver, weight) in receivers.into_iter().zip([1.0 - u - v, u, v]) {
            if receiver != NO_RECEIVER && weight > 0.0 && self.sees_receiver(seen, receiver as usize) {
                let light = self.received[receiver as usize];
                sum = std::array::from_fn(|c| sum[c] + f64::from(weight * light[c]));
                weights += f64::from(weight);
            }
        }
        if weights > 0.0 {
            return sum.map(|s| s / weights);
        }
        let face = face_id(seen.point.triangle, seen.side);
        let patch = self.shown.bake.patches().locator.patch_at(face, seen.point.position.to_array());
        patch.map_or([0.0; 3], |p| self.shown.frame.indirect[p as usize].map(f64::from))
    }

    fn sees_receiver(&self, seen: &Seen, receiver: usize) -> bool {
        let rays = self.shown.bake.rays();
        let position = Vec3::from(self.shown.transfer.position[receiver]);
        let normal = Vec3::from(self.shown.transfer.normal[receiver]);
        let high = 2.0 * rays.gap() + RAISED * position.distance(seen.point.position);
        let from = seen.point.position + high * seen.point.normal;
        rays.visible(from, position + high * normal, NO_TRIANGLE)
    }
}

/// Weights of the second and third corner at the point of the triangle's plane nearest to `p`.
fn barycentric([a, b, c]: [DVec3; 3], p: DVec3) -> (f64, f64) {
    let normal = (b - a).cross(c - a);
    let square = normal.length_squared();
    if square == 0.0 {
        return (0.0, 0.0);
    }
    ((p - a).cross(c - a).dot(normal) / square, (b - a).cross(p - a).dot(normal) / square)
}
