//! Scenes made by hand, and how they are measured.
#![allow(dead_code, reason = "every test file uses a part of it")]

use glam::Vec3;
use radfile::{Material, Quiet};
use reference::{PathTracer, PointEstimate, PointReport, Sampling, Stop};
use scene::{LightRig, Rays, Scene, Surfaces};

/// A scene without any surface yet.
pub fn empty() -> Scene {
    Scene::default()
}

/// Adds a material and returns its number.
pub fn paint(scene: &mut Scene, reflectance: [f32; 3], emission: [f32; 3]) -> u32 {
    let (reflectance_texture, emission_texture) = (None, None);
    let name = "paint".into();
    scene.materials.materials.push(Material { name, reflectance, reflectance_texture, emission, emission_texture });
    scene.materials.materials.len() as u32 - 1
}

/// Adds a parallelogram whose front is along `u` × `v`.
pub fn sheet(scene: &mut Scene, material: u32, corner: Vec3, u: Vec3, v: Vec3) {
    let mesh = &mut scene.mesh;
    let first = mesh.positions.len() as u32;
    mesh.positions.extend([corner, corner + u, corner + u + v, corner + v].map(|p| p.to_array()));
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    mesh.triangle_material.extend([material; 2]);
}

/// Adds a box; the fronts look inwards.
pub fn room(scene: &mut Scene, material: u32, low: Vec3, size: Vec3) {
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    for (corner, u, v) in [(low, z, x), (low + y, x, z), (low, y, z), (low + x, z, y), (low, x, y), (low + z, y, x)] {
        sheet(scene, material, corner, u, v);
    }
}

/// A closed room of one paint, `size` metres about (0, 0, 0)..size.
pub fn furnace(reflectance: f32, emission: f32, size: Vec3) -> Scene {
    let mut scene = empty();
    let wall = paint(&mut scene, [reflectance; 3], [emission; 3]);
    room(&mut scene, wall, Vec3::ZERO, size);
    scene
}

/// A lights file.
pub fn rig(lights: &str) -> LightRig {
    LightRig::from_json(&format!(r#"{{"lights":[{lights}]}}"#)).expect("lights of the tests are sound")
}

/// The emission of the scene and nothing else.
pub fn emission() -> LightRig {
    LightRig { use_scene_emission: true, ..LightRig::default() }
}

/// Receivers: position and normal.
pub type At = ([f64; 3], [f32; 3]);

/// Evaluates points.
pub fn trace(scene: &Scene, rig: &LightRig, at: &[At], stop: Stop, seed: u32) -> (Vec<PointEstimate>, PointReport) {
    let (position, normal): (Vec<[f64; 3]>, Vec<[f32; 3]>) = at.iter().copied().unzip();
    with(scene, rig, |tracer| tracer.points(&position, &normal, &Sampling { stop, seed }, &Quiet))
}

/// Hands a tracer to `work`.
pub fn with<T>(scene: &Scene, rig: &LightRig, work: impl FnOnce(&PathTracer) -> T) -> T {
    let rays = Rays::new(&scene.mesh);
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials).expect("textures of the tests are sound");
    work(&PathTracer::new(scene, &surfaces, &rays, rig))
}

/// One point, `samples` paths.
pub fn one(scene: &Scene, rig: &LightRig, position: [f64; 3], normal: [f32; 3], samples: u32) -> PointEstimate {
    trace(scene, rig, &[(position, normal)], Stop::Samples(samples), 1).0[0]
}

#[track_caller]
pub fn close(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance * wanted.abs(), "{found}, expected {wanted}");
}

/// Asserts that a value lies within `sigmas` standard errors of what it should be, and that the error is small.
#[track_caller]
pub fn within(found: reference::Measured, wanted: f64, sigmas: f64, largest_error: f64) {
    for c in 0..3 {
        let (value, error) = (found.value[c], found.error[c]);
        assert!((value - wanted).abs() <= sigmas * error + 1e-5 * wanted, "{value} ± {error}, expected {wanted}");
        assert!(error <= largest_error * wanted, "± {error} of {wanted} is more than {largest_error}");
    }
}
