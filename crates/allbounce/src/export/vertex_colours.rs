//! The finer mesh with the light of its vertices as their colours.

use std::path::Path;

use glam::Vec3;
use radfile::{FineMesh, NO_RECEIVER};
use relight::PointLight;
use scene::{Scene, Surfaces};
use serde::Serialize;
use serde_json::json;

use super::{
    Lit,
    surface::{Corner, Sets, Surface},
    total,
};
use crate::files;

/// What [`write()`] writes.
pub const FILE: &str = "vertex_colours.glb";

/// What was written, for people.
#[derive(Serialize)]
pub struct Report {
    vertices: usize,
    triangles: usize,
    /// W/m² that a colour of 1 stands for.
    irradiance_of_white: f32,
}

/// Writes the sides of the fine triangles that receive. A viewer shows reflectance times irradiance.
///
/// glTF wants colours up to 1, so they are in parts of the brightest.
pub fn write(lit: &Lit, light: &PointLight, folder: &Path) -> anyhow::Result<Report> {
    let (scene, fine) = (&lit.bake.scene, &lit.bake.transfer.fine);
    let irradiance = total(light);
    let brightest = irradiance.as_flattened().iter().fold(0.0f32, |m, e| m.max(*e));
    let white = if brightest > 0.0 { brightest } else { 1.0 };
    let mut surface = Surface::default();
    for (t, source) in fine.source.iter().enumerate() {
        for side in [0, 1] {
            let receivers = fine.receiver[t][side];
            if receivers.contains(&NO_RECEIVER) {
                continue;
            }
            let corner = |k: usize| {
                let [r, g, b] = irradiance[receivers[k] as usize].map(|e| (e / white).clamp(0.0, 1.0));
                Corner { colour: [r, g, b, 1.0], ..place(scene, lit.relighter.surfaces(), fine, t, k) }
            };
            let order = if side == 0 { [0, 1, 2] } else { [0, 2, 1] };
            surface.add(scene.mesh.triangle_material[*source as usize], order.map(corner));
        }
    }
    let sets = Sets { count: usize::from(!scene.mesh.uv.is_empty()), ..Sets::default() };
    let extras = json!({ "irradiance_of_white": white, "unit": "W/m^2" });
    files::write(&folder.join(FILE), &surface.to_glb(scene, sets, true, extras)?)?;
    let [vertices, triangles] = surface.size();
    Ok(Report { vertices, triangles, irradiance_of_white: white })
}

/// A corner of a fine triangle with the texture coordinates of the triangle that it was cut from.
fn place(scene: &Scene, surfaces: &Surfaces, fine: &FineMesh, triangle: usize, corner: usize) -> Corner {
    let position = fine.vertex[fine.triangle[triangle][corner] as usize];
    let (mesh, source) = (&scene.mesh, fine.source[triangle]);
    let mut placed = Corner { position, ..Corner::default() };
    if !mesh.uv.is_empty() {
        let (u, v) = surfaces.weights_at(source, Vec3::from(position));
        let [a, b, c] = mesh.triangles[source as usize].map(|vertex| mesh.uv[vertex as usize]);
        placed.uv[0] = std::array::from_fn(|k| (1.0 - u - v) * a[k] + u * b[k] + v * c[k]);
    }
    placed
}
