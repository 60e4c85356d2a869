//! What the tests share: meshes made of quads, scene files, and readers of a lightmap.
#![allow(dead_code)] // each test program uses its part

#[path = "../../../scene/tests/disk/mod.rs"]
mod disk;

use std::{io::Write, path::Path};

use disk::Disk;
use glam::Vec3;
use lightmap::{Atlas, Report, Size, UnwrapParams, texels, unwrap};
use radfile::{Lightmap, Mesh, Quiet};
use scene::{ImportOptions, Rays, import};

/// Adds a quad, counter-clockwise seen from its front.
pub fn quad(mesh: &mut Mesh, corners: [[f32; 3]; 4]) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(corners);
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    mesh.triangle_material.extend([0, 0]);
}

/// Adds the sides of a box: −x, +x, −y, +y, −z, +z, as far as `wanted`; fronts look outside, or inside.
pub fn cuboid(mesh: &mut Mesh, low: [f32; 3], high: [f32; 3], outside: bool, wanted: [bool; 6]) {
    for side in (0..6).filter(|&s| wanted[s]) {
        let (axis, far) = (side / 2, side % 2 == 1);
        let corner = |u: f32, v: f32| {
            let mut p = [0.0; 3];
            p[axis] = if far { high[axis] } else { low[axis] };
            for (k, s) in [(1, u), (2, v)] {
                let a = (axis + k) % 3;
                p[a] = low[a] + s * (high[a] - low[a]);
            }
            p
        };
        let mut corners = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        if far != outside {
            corners.reverse();
        }
        quad(mesh, corners);
    }
}

pub const ALL: [bool; 6] = [true; 6];

/// A room of 4 × 4 × 3 metres, its fronts inside; triangles 8 and 9 are the floor, at z = 0.
pub fn room() -> Mesh {
    let mut mesh = Mesh::default();
    cuboid(&mut mesh, [0.0; 3], [4.0, 4.0, 3.0], false, ALL);
    mesh
}

/// A scene file below the root of the workspace; `None`, with a printed reason, where it is not there.
pub fn load(path: &str) -> Option<Mesh> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    if !file.exists() {
        // Not println!, whose lines are swallowed when a test passes.
        writeln!(std::io::stderr(), "skipped: {path} is not beside this checkout").expect("standard error");
        return None;
    }
    let folder = Disk(file.parent().expect("a folder").to_owned());
    let name = file.file_name().and_then(|n| n.to_str()).expect("a name");
    Some(import(name, &folder, ImportOptions::default()).expect(path).0.mesh)
}

/// Unwraps to a number of texels and places receivers.
pub fn lightmap(mesh: &Mesh, size: Size) -> (Atlas, Lightmap, Report) {
    let atlas = unwrap(mesh, &UnwrapParams { size, fast: true, ..UnwrapParams::default() }, &Quiet).expect("an atlas");
    let (lightmap, report) = texels(mesh, &atlas, &Rays::new(mesh), &Quiet);
    lightmap.check(mesh.triangles.len()).expect("a legal record");
    (atlas, lightmap, report)
}

/// Place on the mesh of the middle of every texel of one triangle, whether it receives or not.
pub fn middles(mesh: &Mesh, map: &Lightmap, triangle: usize) -> Vec<(u32, Vec3)> {
    let [a, b, c] = mesh.corners(triangle).map(Vec3::from);
    let corners = flat(map, triangle);
    let texels = 0..map.width * map.height;
    let middle = |texel: u32| {
        let p = [f64::from(texel % map.width) + 0.5, f64::from(texel / map.width) + 0.5];
        let [x, y, z] = weights(corners, p);
        ([x, y, z].iter().all(|w| *w >= 0.0)).then(|| (texel, x as f32 * a + y as f32 * b + z as f32 * c))
    };
    texels.filter_map(middle).collect()
}

/// Corners of a triangle, in texels.
pub fn flat(map: &Lightmap, triangle: usize) -> [[f64; 2]; 3] {
    let size = [map.width, map.height].map(f64::from);
    map.corner_uv[triangle].map(|uv| [0, 1].map(|k| f64::from(uv[k]) * size[k]))
}

/// Barycentric weights of a point in a triangle of texels.
pub fn weights([a, b, c]: [[f64; 2]; 3], p: [f64; 2]) -> [f64; 3] {
    let area = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    [[p, b, c], [a, p, c], [a, b, p]].map(|[p, q, r]| area(p, q, r) / area(a, b, c))
}

/// Texels and weights that a bilinear filter reads at a point, in texels, clamped to the edge.
pub fn bilinear(map: &Lightmap, p: [f64; 2]) -> [(usize, f64); 4] {
    let [x, y] = p.map(|x| x - 0.5);
    let at =
        |base: f64, step: u32, extent: u32| (base.floor() + f64::from(step)).clamp(0.0, f64::from(extent - 1)) as usize;
    let part = |base: f64, step: u32| if step == 1 { base - base.floor() } else { 1.0 - (base - base.floor()) };
    std::array::from_fn(|k| {
        let (i, j) = (k as u32 % 2, k as u32 / 2);
        (at(y, j, map.height) * map.width as usize + at(x, i, map.width), part(x, i) * part(y, j))
    })
}
