//! Watertight ray-triangle test, four triangles at a time.
//!
//! The ray is sheared to the z axis and the edges are tested in 2-D. Two triangles that share an
//! edge compute the same number for it, so no ray slips between them; where single precision
//! gives zero, the sign is found in double precision, in which the products are exact.
//!
//! Source: S. Woop, C. Benthin, I. Wald, Watertight Ray/Triangle Intersection, JCGT 2(1), 2013.

use glam::{BVec4A, Vec3, Vec4};

/// Four triangles, one a lane.
pub struct Quad {
    /// Corner, then axis. Lanes without a triangle are NaN, which meets nothing.
    corners: [[Vec4; 3]; 3],
    /// Numbers of the triangles.
    pub triangle: [u32; 4],
    /// Whether this is the last of its leaf.
    pub last: bool,
}

/// A ray, prepared for testing many triangles.
#[derive(Clone, Copy)]
pub struct ShearedRay {
    origin: [Vec4; 3],
    /// Axes: `axis[2]` is the largest component of the direction, the others keep the winding.
    axis: [usize; 3],
    shear: [Vec4; 3],
}

/// Where a ray meets the triangles of a quad. Only lanes in `lanes` mean something.
pub struct Meetings {
    /// Bit k: the line through the ray meets triangle k.
    pub lanes: u32,
    /// Distance in lengths of the ray's direction; may be negative.
    pub t: Vec4,
    /// Barycentric weights of the second and third corner.
    pub u: Vec4,
    pub v: Vec4,
    /// Bit k: the ray comes from the side on which the corners turn counter-clockwise.
    pub front: u32,
}

impl Quad {
    /// Up to four triangles with their numbers.
    pub fn new(triangles: &[(u32, [[f32; 3]; 3])]) -> Quad {
        let lane = |k: usize, corner: usize, axis: usize| triangles.get(k).map_or(f32::NAN, |t| t.1[corner][axis]);
        let lanes = |corner, axis| Vec4::from_array(std::array::from_fn(|k| lane(k, corner, axis)));
        Quad {
            corners: std::array::from_fn(|corner| std::array::from_fn(|axis| lanes(corner, axis))),
            triangle: std::array::from_fn(|k| triangles.get(k).map_or(u32::MAX, |t| t.0)),
            last: false,
        }
    }

    /// Corners of the triangle in lane `k`.
    pub fn corners_of(&self, k: usize) -> [Vec3; 3] {
        self.corners.map(|corner| Vec3::from(corner.map(|axis| axis[k])))
    }
}

impl ShearedRay {
    pub fn new(origin: Vec3, direction: Vec3) -> ShearedRay {
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
        let origin = origin.to_array();
        ShearedRay {
            origin: [kx, ky, kz].map(|k| Vec4::splat(origin[k])),
            axis: [kx, ky, kz],
            shear: shear.map(Vec4::splat),
        }
    }

    /// Tests four triangles; `None` if none is met.
    #[inline(always)]
    pub fn meet(&self, quad: &Quad) -> Option<Meetings> {
        let [kx, ky, kz] = self.axis;
        let [sx, sy, sz] = self.shear;
        let [ox, oy, oz] = self.origin;
        let project = |p: &[Vec4; 3]| {
            let z = p[kz] - oz;
            [p[kx] - ox - sx * z, p[ky] - oy - sy * z, z]
        };
        let [a, b, c] = [project(&quad.corners[0]), project(&quad.corners[1]), project(&quad.corners[2])];
        let mut u = c[0] * b[1] - c[1] * b[0];
        let mut v = a[0] * c[1] - a[1] * c[0];
        let mut w = b[0] * a[1] - b[1] * a[0];
        let mut inside = agree(u, v, w);
        if !inside.any() {
            return None; // a zero agrees with either sign, so the exact test could not find more
        }
        if (u.cmpeq(Vec4::ZERO) | v.cmpeq(Vec4::ZERO) | w.cmpeq(Vec4::ZERO)).any() {
            (u, v, w) = (exact(c, b), exact(a, c), exact(b, a));
            inside = agree(u, v, w);
        }
        let determinant = u + v + w;
        // Seen exactly edge-on: a neighbour answers.
        let lanes = (inside & determinant.cmpne(Vec4::ZERO)).bitmask();
        let inverse = 1.0 / determinant;
        let weight = [u * inverse, v * inverse, w * inverse];
        let t = (weight[0] * a[2] + weight[1] * b[2] + weight[2] * c[2]) * sz;
        let front = determinant.cmpgt(Vec4::ZERO).bitmask();
        (lanes != 0).then_some(Meetings { lanes, t, u: weight[1], v: weight[2], front })
    }
}

/// Lanes in which no two of the numbers have opposite signs.
#[inline(always)]
fn agree(u: Vec4, v: Vec4, w: Vec4) -> BVec4A {
    u.min(v).min(w).cmpge(Vec4::ZERO) | u.max(v).max(w).cmple(Vec4::ZERO)
}

/// The edge number p × q with the right sign: products of two `f32` are exact in `f64`.
#[cold]
fn exact(p: [Vec4; 3], q: [Vec4; 3]) -> Vec4 {
    let lane = |k: usize| f64::from(p[0][k]) * f64::from(q[1][k]) - f64::from(p[1][k]) * f64::from(q[0][k]);
    Vec4::from_array(std::array::from_fn(|k| lane(k) as f32))
}
