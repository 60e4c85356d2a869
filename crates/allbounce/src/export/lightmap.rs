//! The lightmap of a bake as pictures, and the scene with its coordinates.

use std::{f32::consts::PI, path::Path};

use glam::Vec3;
use radfile::{Gathered, Lightmap, Record};
use relight::{Image, Receivers};
use scene::{Scene, SurfacePoint, Surfaces};
use serde::Serialize;
use serde_json::json;

use super::{
    Lit,
    surface::{Corner, Sets, Surface},
    total,
};
use crate::{files, pictures};

const IRRADIANCE: &str = FILES[0];
const IRRADIANCE_PNG: &str = FILES[1];
const RADIANCE: &str = FILES[2];
const RADIANCE_PNG: &str = FILES[3];
const SCENE: &str = FILES[4];
/// What [`write()`] writes.
pub const FILES: [&str; 5] =
    ["lightmap.exr", "lightmap.png", "lightmap_radiance.exr", "lightmap_radiance.png", "scene.glb"];

/// What was written, for people.
#[derive(Serialize)]
pub struct Report {
    width: u32,
    height: u32,
    receivers: usize,
    mean_irradiance: [f64; 3],
    /// Factor on irradiance, m²/W, before the PNG is clipped to white.
    exposure: f32,
    /// The same of radiance, (m² sr)/W.
    radiance_exposure: f32,
    /// The set of the scene that has the lightmap's coordinates.
    texcoord: usize,
}

pub fn write(lit: &Lit, folder: &Path) -> anyhow::Result<Report> {
    let scene = &lit.bake.scene;
    let map = Lightmap::read(&lit.bake.container)?;
    let gathered = Gathered::read(&lit.bake.container, Lightmap::PREFIX, map.receivers())?;
    let receivers = Receivers::gathered(&gathered, lit.bake.elements.senders())?;
    let points: Vec<SurfacePoint> = (0..map.receivers()).map(|r| point(&map, r)).collect();
    let irradiance = total(&lit.at(&points, &receivers)?);
    let surfaces = lit.relighter.surfaces();
    let radiance: Vec<[f32; 3]> =
        points.iter().zip(&irradiance).map(|(point, light)| reflected(surfaces, point, light)).collect();
    let exposure = picture(&map, &irradiance, folder, [IRRADIANCE, IRRADIANCE_PNG])?;
    let radiance_exposure = picture(&map, &radiance, folder, [RADIANCE, RADIANCE_PNG])?;
    let texcoord = usize::from(!scene.mesh.uv.is_empty());
    files::write(&folder.join(SCENE), &mapped(scene, &map, texcoord)?)?;
    let mean = |c: usize| irradiance.iter().map(|e| f64::from(e[c])).sum::<f64>() / irradiance.len().max(1) as f64;
    Ok(Report {
        width: map.width,
        height: map.height,
        receivers: map.receivers(),
        mean_irradiance: std::array::from_fn(mean),
        exposure,
        radiance_exposure,
        texcoord,
    })
}

fn point(map: &Lightmap, receiver: usize) -> SurfacePoint {
    SurfacePoint {
        position: Vec3::from(map.position[receiver]),
        normal: Vec3::from(map.normal[receiver]),
        triangle: map.triangle[receiver],
    }
}

/// Radiance that a point reflects, W/(m² sr).
fn reflected(surfaces: &Surfaces, point: &SurfacePoint, irradiance: &[f32; 3]) -> [f32; 3] {
    let (u, v) = surfaces.weights_at(point.triangle, point.position);
    let rho = surfaces.reflectance(point.triangle, u, v);
    std::array::from_fn(|c| rho[c] * irradiance[c] / PI)
}

/// Values of the receivers as linear and as tone-mapped picture; returns the exposure of the second.
fn picture(map: &Lightmap, values: &[[f32; 3]], folder: &Path, names: [&str; 2]) -> anyhow::Result<f32> {
    let image = Image { width: map.width as usize, height: map.height as usize, pixels: map.fill(values) };
    let [linear, shown] = names.map(|name| folder.join(name));
    pictures::write(&linear, &image, None)?;
    Ok(pictures::write(&shown, &image, None)?.unwrap_or(1.0))
}

/// The scene with the lightmap's coordinates as set `texcoord`.
fn mapped(scene: &Scene, map: &Lightmap, texcoord: usize) -> anyhow::Result<Vec<u8>> {
    let mesh = &scene.mesh;
    let own = !mesh.emission_uv.is_empty();
    let sets = Sets { count: texcoord + 1 + usize::from(own), base: 0, emission: if own { texcoord + 1 } else { 0 } };
    let mut surface = Surface::default();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let corner = |k: usize| {
            let v = triangle[k] as usize;
            let mut corner = Corner { position: mesh.positions[v], ..Corner::default() };
            if let Some(uv) = mesh.uv.get(v) {
                corner.uv[sets.base] = *uv;
            }
            if own {
                corner.uv[sets.emission] = mesh.emission_uv[v];
            }
            corner.uv[texcoord] = map.corner_uv[t][k];
            corner
        };
        surface.add(mesh.triangle_material[t], std::array::from_fn(corner));
    }
    let extras = json!({ "lightmap": { "irradiance": IRRADIANCE, "radiance": RADIANCE, "texCoord": texcoord } });
    surface.to_glb(scene, sets, false, extras)
}
