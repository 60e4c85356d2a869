//! What a lamp or a camera sees: host side of `shaders/view.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

/// Rows that turn a point into view coordinates, see `shaders/view.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct View {
    pub right: [f32; 4],
    pub up: [f32; 4],
    pub forward: [f32; 4],
    pub reach: f32,
    pub perspective: u32,
    pub unused_a: u32,
    pub unused_b: u32,
}

/// A vector and the offset that puts `eye` at 0.
fn row(v: DVec3, eye: DVec3) -> [f32; 4] {
    v.extend(-v.dot(eye)).as_vec4().to_array()
}

impl View {
    /// A perspective from `eye` along the unit vector `forward`; `tangents` are those of half the fields of
    /// view along the unit vectors `right` and `up`.
    pub fn perspective(eye: DVec3, [right, up, forward]: [DVec3; 3], tangents: [f64; 2], near: f32) -> View {
        View {
            right: row(right / tangents[0], eye),
            up: row(up / tangents[1], eye),
            forward: row(forward, eye),
            reach: near,
            perspective: 1,
            ..View::default()
        }
    }

    /// A parallel view along the unit vector `forward` that holds a whole box with a margin, a share of its size.
    pub fn parallel(forward: DVec3, [low, high]: [Vec3; 2], margin: f64) -> View {
        let (right, up) = forward.any_orthonormal_pair();
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
        let gap = margin * half.length();
        let extent = |v: DVec3| v.abs().dot(half) + gap;
        let depth = extent(forward);
        View {
            right: row(right / extent(right), centre),
            up: row(up / extent(up), centre),
            forward: row(forward, centre - depth * forward),
            reach: (2.0 * depth) as f32,
            perspective: 0,
            ..View::default()
        }
    }

    /// The faces of a cube about `eye`: along the unit vector `axis`, to its four sides, and backwards.
    pub fn cube(eye: DVec3, axis: DVec3, near: f32) -> [View; 6] {
        let (s, t) = axis.any_orthonormal_pair();
        let face =
            |forward: DVec3, right: DVec3, up: DVec3| View::perspective(eye, [right, up, forward], [1.0; 2], near);
        [face(axis, s, t), face(s, t, axis), face(-s, t, axis), face(t, s, axis), face(-t, s, axis), face(-axis, s, t)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(view: &View, p: Vec3) -> [f32; 3] {
        [view.right, view.up, view.forward].map(|r| Vec3::new(r[0], r[1], r[2]).dot(p) + r[3])
    }

    #[test]
    fn every_direction_from_a_point_lies_in_a_face_of_its_cube() {
        let eye = DVec3::new(1.0, 2.0, 3.0);
        let views = View::cube(eye, DVec3::new(0.6, 0.0, 0.8), 0.01);
        for i in 0..200 {
            let [x, y, ..] = scene::Sobol::new(7).sample(i);
            let z = 2.0 * x - 1.0;
            let around = glam::Vec2::from_angle(std::f32::consts::TAU * y) * (1.0 - z * z).sqrt();
            let p = eye.as_vec3() + 5.0 * Vec3::new(around.x, around.y, z);
            let [x, y, z] = views.iter().map(|v| seen(v, p)).max_by(|a, b| a[2].total_cmp(&b[2])).expect("six views");
            assert!(z > 2.8 && x.abs() <= z * 1.0001 && y.abs() <= z * 1.0001, "{p}: {x} {y} {z}");
        }
    }

    #[test]
    fn a_parallel_view_holds_every_corner_of_the_box() {
        let bounds = [Vec3::new(-1.0, 0.0, 2.0), Vec3::new(3.0, 1.0, 2.0)];
        let view = View::parallel(DVec3::new(0.0, -0.6, 0.8), bounds, 0.01);
        for corner in 0..8 {
            let p = Vec3::from_array(std::array::from_fn(|a| bounds[corner >> a & 1][a]));
            let [x, y, z] = seen(&view, p);
            assert!(x.abs() < 1.0 && y.abs() < 1.0 && z > 0.0 && z < view.reach, "{p}: {x} {y} {z}");
        }
    }
}
