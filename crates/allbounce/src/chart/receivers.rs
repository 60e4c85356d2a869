//! Where light is asked for: points of the scene's surfaces, evenly by area, on sides that light can reach.

use anyhow::bail;
use glam::Vec3;
use radfile::{Mesh, Side};
use rayon::prelude::*;
use scene::{Rays, Scene, Sobol, SurfacePoint, cosine_direction, hash, square_to_triangle};

use crate::csv_points::Points;

/// Rays that look around from a side.
const RAYS: u32 = 64;
/// The share of them that meet front sides or the sky in the open. Within a solid, which may stand on a floor without a bottom of
/// its own, most meet backs.
const OPEN: f32 = 0.75;
/// Where less than this share of the candidates that see anything is in the open, the scene is modelled inside out.
const WOUND: f32 = 1.0 / 8.0;
/// Most candidates for each receiver.
const CANDIDATES: u32 = 64;

/// What is seen from a candidate.
struct Candidate {
    point: SurfacePoint,
    /// Any surface at all.
    any: bool,
    /// Hardly any backs.
    open: bool,
}

/// `count` points; the same for the same scene.
///
/// Outer sides of a lone room, which see nothing, do not count, nor do insides of solids, which see backs. Where hardly any side sees
/// fronts, windings tell nothing, and every side counts that sees something.
pub fn by_area(scene: &Scene, rays: &Rays, count: u32) -> anyhow::Result<Points> {
    let sums = area_sums(&scene.mesh);
    let (mut candidates, mut chosen) = (Vec::new(), Vec::new());
    for start in (0..CANDIDATES * count).step_by(count as usize) {
        let batch = (start..start + count).into_par_iter();
        candidates.extend(batch.filter_map(|k| candidate(&scene.mesh, rays, &sums, k)).collect::<Vec<_>>());
        chosen = usable(&candidates);
        if chosen.len() >= count as usize {
            break;
        }
    }
    if chosen.is_empty() {
        bail!("no side of a surface sees another surface, so that there is no indirect light");
    }
    chosen.truncate(count as usize);
    let origin = scene.mesh.origin;
    let in_file_axes = |p: &SurfacePoint| {
        let position = p.position.to_array();
        std::array::from_fn(|a| f64::from(position[a]) + origin[a])
    };
    let normal = chosen.iter().map(|p| p.normal.to_array()).collect();
    Ok(Points::new(chosen.iter().map(in_file_axes).collect(), normal))
}

fn usable(candidates: &[Candidate]) -> Vec<SurfacePoint> {
    let seeing = || candidates.iter().filter(|c| c.any);
    let wound = seeing().filter(|c| c.open).count() as f32 >= WOUND * seeing().count() as f32;
    seeing().filter(|c| c.open || !wound).map(|c| c.point).collect()
}

/// Areas of the triangles, summed up.
fn area_sums(mesh: &Mesh) -> Vec<f64> {
    let mut sum = 0.0;
    let area = |t: usize| {
        let [a, b, c] = mesh.corners(t).map(|p| Vec3::from(p).as_dvec3());
        sum += 0.5 * (b - a).cross(c - a).length();
        sum
    };
    (0..mesh.triangles.len()).map(area).collect()
}

/// Point `k` of the sequence and what it sees; `None` on a triangle without area.
fn candidate(mesh: &Mesh, rays: &Rays, sums: &[f64], k: u32) -> Option<Candidate> {
    let [x, u, v, side] = Sobol::new(1).sample(k);
    let total = *sums.last()?;
    let triangle = sums.partition_point(|&sum| sum <= f64::from(x) * total).min(sums.len() - 1);
    let [a, b, c] = mesh.corners(triangle).map(Vec3::from);
    let front = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize_or_zero().as_vec3();
    if front == Vec3::ZERO {
        return None;
    }
    let (s, t) = square_to_triangle(u, v);
    let normal = if mesh.one_sided || side < 0.5 { front } else { -front };
    let point = SurfacePoint { position: a + s * (b - a) + t * (c - a), normal, triangle: triangle as u32 };
    let sobol = Sobol::new(hash(2, k));
    let (origin, mut hits, mut backs) = (rays.off_surface(point.position, normal), 0, 0);
    for ray in 0..RAYS {
        let [x, y, ..] = sobol.sample(ray);
        if let Some(hit) = rays.closest(origin, cosine_direction(normal, x, y), f32::INFINITY, point.triangle) {
            (hits, backs) = (hits + 1, backs + u32::from(hit.side == Side::Back));
        }
    }
    Some(Candidate { point, any: hits > 0, open: (RAYS - backs) as f32 >= OPEN * RAYS as f32 })
}
