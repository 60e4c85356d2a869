//! Watertight ray-triangle test.
//!
//! The ray is sheared to the z axis and the edges are tested in 2-D. Two triangles that share an
//! edge compute the same number for it, so no ray slips between them; where single precision
//! gives zero, the sign is found in double precision, in which the products are exact.
//!
//! Source: S. Woop, C. Benthin, I. Wald, Watertight Ray/Triangle Intersection, JCGT 2(1), 2013.

use glam::Vec3A;

/// A ray, prepared for testing many triangles.
#[derive(Clone, Copy)]
pub struct ShearedRay {
    origin: [f32; 3],
    /// Axes: `axis[2]` is the largest component of the direction, the others keep the winding.
    axis: [usize; 3],
    shear: [f32; 3],
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Barycentric weight of the second corner.
    pub u: f32,
    /// Barycentric weight of the third corner.
    pub v: f32,
    /// Whether the ray comes from the side on which the corners turn counter-clockwise.
    pub front: bool,
}

impl ShearedRay {
    pub fn new(origin: Vec3A, direction: Vec3A) -> ShearedRay {
        let d = direction.to_array();
        let magnitude = direction.abs().to_array();
        let kz = if magnitude[0] > magnitude[1] && magnitude[0] > magnitude[2] {
            0
        } else if magnitude[1] > magnitude[2] {
            1
        } else {
            2
        };
        let (mut kx, mut ky) = ((kz + 1) % 3, (kz + 2) % 3);
        if d[kz] < 0.0 {
            std::mem::swap(&mut kx, &mut ky);
        }
        let shear = [d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]];
        ShearedRay { origin: origin.to_array(), axis: [kx, ky, kz], shear }
    }

    /// Tests one triangle; `t` may be negative.
    #[inline(always)]
    pub fn meet(&self, corners: &[[f32; 3]; 3]) -> Option<Meeting> {
        let [kx, ky, kz] = self.axis;
        let [sx, sy, sz] = self.shear;
        let o = self.origin;
        let project = |p: &[f32; 3]| {
            let z = p[kz] - o[kz];
            [p[kx] - o[kx] - sx * z, p[ky] - o[ky] - sy * z, z]
        };
        let [a, b, c] = [project(&corners[0]), project(&corners[1]), project(&corners[2])];
        let mut u = c[0] * b[1] - c[1] * b[0];
        let mut v = a[0] * c[1] - a[1] * c[0];
        let mut w = b[0] * a[1] - b[1] * a[0];
        if u == 0.0 || v == 0.0 || w == 0.0 {
            let exact = |p: [f32; 3], q: [f32; 3]| {
                (f64::from(p[0]) * f64::from(q[1]) - f64::from(p[1]) * f64::from(q[0])) as f32
            };
            (u, v, w) = (exact(c, b), exact(a, c), exact(b, a));
        }
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None; // seen exactly edge-on; a neighbour answers
        }
        let inverse = 1.0 / determinant;
        let t = (u * a[2] + v * b[2] + w * c[2]) * sz * inverse;
        Some(Meeting { t, u: v * inverse, v: w * inverse, front: determinant > 0.0 })
    }
}
