//! Lights to try a scene with before anybody has said what will shine.
//!
//! Lamps hang where real ones could ([`Air`]). One rig has four lamps of which one is a panel, the next two points, and so on;
//! where the sun comes in, every fourth is sun and sky.

use glam::Vec3;
use scene::{Air, Light, LightRig, NO_TRIANGLE, Rays, Scene, Sobol, SurfacePoint, basis, hash};

use super::jury;

/// Lamps of a rig: one rig after another.
const LAMPS: [u32; 2] = [4, 2];
/// Every so many rigs is sun and sky.
const SUN: u32 = 4;
/// Edge of a panel, in diagonals of the scene.
const PANEL: f32 = 0.05;
/// Radiance of the sky beside a sun of 1 W/m².
const SKY: f32 = 0.1;
/// How far lamps hang from everything, in diagonals of the scene, and how often a place is looked for.
const CLEARANCE: f32 = 0.05;
const ATTEMPTS: u32 = 16;
const SEED: u32 = 0x11a3;

/// A rig and what it is.
pub struct Trial {
    pub name: String,
    pub rig: LightRig,
}

/// The rig of a number, the same for the same scene. `points` are points of its surfaces in the open.
pub fn rig(scene: &Scene, points: &[SurfacePoint], rays: &Rays, number: u32) -> Trial {
    let diagonal = jury::diagonal(points);
    let air = Air { rays, diagonal, point: point_of(points, rays) };
    let in_file_axes = |p: Vec3| std::array::from_fn(|a| f64::from(p[a]) + scene.mesh.origin[a]);
    let lamp = |k: u32| {
        let Hung { place, normal, .. } = hang(&air, hash(hash(SEED, number), k));
        if k % LAMPS[0] != LAMPS[0] - 1 {
            return Light::Point { position: in_file_axes(place), intensity: [1.0; 3] };
        }
        let edge = PANEL * diagonal;
        let (u, v) = basis(normal);
        let radiance = [1.0 / (edge * edge); 3];
        let corner = in_file_axes(place - 0.5 * edge * (u + v));
        Light::Quad { corner, edge_u: (edge * u).to_array(), edge_v: (edge * v).to_array(), radiance }
    };
    let sun = (number % SUN == SUN - 1).then(|| air.sun(&Sobol::new(hash(SEED, number)))).flatten();
    let (name, lights) = match sun {
        Some(towards) => {
            let sun = Light::Directional { direction: (-towards).to_array(), irradiance: [1.0; 3] };
            ("sun and sky".into(), vec![sun, Light::Sky { radiance: [SKY; 3] }])
        }
        None => {
            let count = LAMPS[number as usize % LAMPS.len()];
            (format!("{count} lamps in the air"), (0..count).map(lamp).collect())
        }
    };
    Trial { name, rig: LightRig { lights, ..LightRig::default() } }
}

/// Places in the air where there is room for a lamp; there may be none.
pub fn places(points: &[SurfacePoint], rays: &Rays, count: u32) -> Vec<Vec3> {
    let air = Air { rays, diagonal: jury::diagonal(points), point: point_of(points, rays) };
    let roomy = |hung: &Hung| hung.clear >= CLEARANCE * air.diagonal;
    (0..count).map(|k| hang(&air, hash(SEED ^ 1, k))).filter(roomy).map(|hung| hung.place).collect()
}

/// One of the points, a little off its surface, and its normal.
fn point_of<'a>(points: &'a [SurfacePoint], rays: &'a Rays) -> impl Fn([f32; 3]) -> (Vec3, Vec3) + 'a {
    move |[x, ..]| {
        let at = &points[((x * points.len() as f32) as usize).min(points.len() - 1)];
        (rays.off_surface(at.position, at.normal), at.normal)
    }
}

/// Where a lamp hangs.
struct Hung {
    place: Vec3,
    /// Of the surface that it hangs before.
    normal: Vec3,
    /// How far it is from everything, up to what is asked for.
    clear: f32,
}

/// The first place that is clear enough, or the clearest.
fn hang<P: Fn([f32; 3]) -> (Vec3, Vec3)>(air: &Air<P>, seed: u32) -> Hung {
    let most = CLEARANCE * air.diagonal;
    let tried = |attempt: u32| {
        let (place, normal) = air.place(&Sobol::new(hash(seed, attempt)));
        Hung { place, normal, clear: clearance(place, most, air.rays) }
    };
    let mut best = tried(0);
    for hung in (1..ATTEMPTS).map(tried) {
        if best.clear >= most {
            break;
        }
        if hung.clear > best.clear {
            best = hung;
        }
    }
    best
}

/// Distance of what is nearest along the axes and half way between them, at most `most`.
fn clearance(place: Vec3, most: f32, rays: &Rays) -> f32 {
    let steps = || [-1.0f32, 0.0, 1.0].into_iter();
    let directions = steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| Vec3::new(x, y, z))));
    let free = |towards: Vec3| rays.closest(place, towards.normalize(), most, NO_TRIANGLE).map_or(most, |hit| hit.t);
    directions.filter(|d| *d != Vec3::ZERO).map(free).fold(most, f32::min)
}

/// What the scene itself emits, if anything does.
pub fn own(scene: &Scene) -> Option<Trial> {
    let emits = scene.materials.materials.iter().any(|m| m.emission.iter().any(|&e| e > 0.0));
    let lights: Vec<Light> = scene.extras.lights.iter().map(|(_, light)| *light).collect();
    let rig = LightRig { use_scene_emission: true, lights, ..LightRig::default() };
    (emits || !rig.lights.is_empty()).then(|| Trial { name: "the scene's own".into(), rig })
}
