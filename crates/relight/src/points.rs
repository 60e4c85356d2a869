//! Light at given points: direct by rays, indirect as receivers have it.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use radfile::{Elements, Mesh, Progress};
use rayon::prelude::*;
use scene::SurfacePoint;

use crate::{DirectLight, Frame, Receivers, Relighter, Samples, direct::loose_point};

/// Irradiance at points, W/m².
#[derive(Clone, Debug, PartialEq)]
pub struct PointLight {
    /// Without any bounce.
    pub direct: Vec<[f32; 3]>,
    /// After one and more bounces.
    pub indirect: Vec<[f32; 3]>,
}

/// Points in the axes of the scene file (metres, f64) as points of the mesh.
///
/// # Panics
///
/// If there are not as many normals as positions: a bug in the caller.
pub fn surface_points(mesh: &Mesh, position: &[[f64; 3]], normal: &[[f32; 3]]) -> Vec<SurfacePoint> {
    assert_eq!(position.len(), normal.len(), "one normal a point");
    let origin = DVec3::from(mesh.origin);
    let local = |p: &[f64; 3]| (DVec3::from(*p) - origin).as_vec3();
    position.iter().zip(normal).map(|(p, n)| loose_point(local(p), Vec3::from(*n).normalize_or_zero())).collect()
}

/// Radiosity ρ (H⁰ + H) of patches and of their elements without emission, W/m²: what the last gather collects, one value
/// for each of its senders ([`Elements`]). Emitters are direct light. Each element has its own direct light, and the
/// indirect light of its patch.
///
/// # Panics
///
/// If the frame is of other elements: a bug in the caller.
pub fn radiosity(elements: &Elements, frame: &Frame) -> Vec<[f32; 3]> {
    assert_eq!(frame.element_direct.len(), elements.len(), "one value an element");
    assert_eq!(frame.indirect.len(), elements.patches(), "one value a patch");
    let of_patch = |patch: usize| {
        let indirect = frame.indirect[patch];
        elements.of(patch).map(move |e| {
            let (rho, direct) = (elements.reflectance[e], frame.element_direct[e]);
            std::array::from_fn(|c| rho[c] * (direct[c] + indirect[c]))
        })
    };
    let parts: Vec<[f32; 3]> = (0..elements.patches()).flat_map(of_patch).collect();
    [elements.mean(&parts), parts].concat()
}

/// Light at every point, the indirect part as `receivers` have it.
///
/// Interpolation takes the irradiance of the frame: as many bounces as it holds. A gather adds a bounce to it.
///
/// # Panics
///
/// If there are not as many receivers as points, or the frame is of other patches: a bug in the caller.
pub fn light_at_points(
    bake: &Relighter,
    light: &DirectLight,
    points: &[SurfacePoint],
    receivers: &Receivers,
    frame: &Frame,
    samples: &Samples,
    progress: &dyn Progress,
) -> PointLight {
    assert_eq!(receivers.len(), points.len(), "one receiver a point");
    progress.begin("direct light of points", points.len() as u64);
    let (sky, radiance) = (receivers.sky(), light.sky_radiance());
    let direct_at = |(i, point): (usize, &SurfacePoint)| {
        let direct = match sky {
            Some(seen) => {
                let (lamps, seen) = (light.irradiance_of_lamps(point, samples, i as u32), PI * f64::from(seen[i]));
                std::array::from_fn(|c| lamps[c] + seen * radiance[c])
            }
            None => light.irradiance(point, samples, i as u32),
        };
        progress.advance(1);
        direct.map(|e| e as f32)
    };
    let direct = points.par_iter().enumerate().map(direct_at).collect();
    PointLight { direct, indirect: receivers.indirect(bake, frame) }
}
