//! Small scenes, built by hand.
#![allow(dead_code)] // Every test file uses a part of it.

use glam::{Quat, Vec3};
use radfile::{Material, Materials, Mesh, Patches, Quiet};
use scene::{Extras, Scene};
use voxel_simplify::{Params, Report, Resolution, voxel_simplify};

/// A mesh under construction.
#[derive(Clone, Default)]
pub struct Build {
    pub mesh: Mesh,
    pub materials: Vec<Material>,
}

pub fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

impl Build {
    pub fn new() -> Build {
        let mut build = Build::default();
        build.material([0.5; 3], [0.0; 3]);
        build
    }

    /// Adds a material and returns its number; 0 is grey.
    pub fn material(&mut self, reflectance: [f32; 3], emission: [f32; 3]) -> u32 {
        let name = format!("material {}", self.materials.len());
        let (reflectance_texture, emission_texture) = (None, None);
        self.materials.push(Material { name, reflectance, reflectance_texture, emission, emission_texture });
        self.materials.len() as u32 - 1
    }

    /// A triangle with vertices of its own.
    pub fn triangle(&mut self, corners: [Vec3; 3], material: u32) -> u32 {
        let first = self.mesh.positions.len() as u32;
        self.mesh.positions.extend(corners.map(|p| p.to_array()));
        self.mesh.triangles.push([first, first + 1, first + 2]);
        self.mesh.triangle_material.push(material);
        self.mesh.triangles.len() as u32 - 1
    }

    /// Two triangles; the front is where the corners turn counter-clockwise.
    pub fn quad(&mut self, [a, b, c, d]: [Vec3; 4], material: u32) -> [u32; 2] {
        [self.triangle([a, b, c], material), self.triangle([a, c, d], material)]
    }

    /// The six sides of a box; fronts outside.
    pub fn solid(&mut self, low: Vec3, high: Vec3, material: u32) {
        let p = |i: u32| Vec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), high, low);
        for side in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            self.quad(side.map(p), material);
        }
    }

    /// The six sides of a room; fronts inside.
    pub fn room(&mut self, low: Vec3, high: Vec3, material: u32) {
        let first = self.mesh.triangles.len();
        self.solid(low, high, material);
        for triangle in &mut self.mesh.triangles[first..] {
            triangle.swap(1, 2);
        }
    }

    /// A ball with shared vertices, fronts outside.
    pub fn ball(&mut self, centre: Vec3, radius: f32, rings: u32, material: u32) {
        let first = self.mesh.positions.len() as u32;
        let columns = 2 * rings;
        for i in 0..=rings {
            for j in 0..columns {
                let (theta, phi) =
                    (std::f32::consts::PI * i as f32 / rings as f32, std::f32::consts::TAU * j as f32 / columns as f32);
                let p = centre + radius * v(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
                self.mesh.positions.push(p.to_array());
            }
        }
        for i in 0..rings {
            for j in 0..columns {
                let at = |i: u32, j: u32| first + i * columns + j % columns;
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                for (triangle, drawn) in [([a, b, c], i + 1 < rings), ([a, c, d], i > 0)] {
                    if drawn {
                        self.mesh.triangles.push(triangle);
                        self.mesh.triangle_material.push(material);
                    }
                }
            }
        }
    }

    /// Turns everything so that nothing is parallel to an axis.
    pub fn tilted(mut self) -> Build {
        for p in &mut self.mesh.positions {
            *p = (tilt() * Vec3::from(*p)).to_array();
        }
        self
    }

    pub fn scene(self) -> Scene {
        let materials = Materials { materials: self.materials, textures: vec![] };
        Scene { mesh: self.mesh, materials, extras: Extras::default() }
    }
}

/// The turn of [`Build::tilted`].
pub fn tilt() -> Quat {
    Quat::from_euler(glam::EulerRot::XYZ, 0.4, 0.7, 0.2)
}

/// A room with a box, a ball and a thin screen; an emissive panel hangs below the ceiling.
pub fn furnished() -> Build {
    let mut build = Build::new();
    let red = build.material([0.7, 0.1, 0.1], [0.0; 3]);
    let lamp = build.material([0.2; 3], [5.0, 4.0, 3.0]);
    build.room(v(0.0, 0.0, 0.0), v(4.0, 3.0, 2.5), 0);
    build.solid(v(1.0, 1.0, 0.0), v(1.6, 1.7, 0.8), red);
    build.ball(v(3.0, 1.0, 0.6), 0.4, 12, red);
    build.quad([v(2.0, 2.0, 0.1), v(3.0, 2.2, 0.1), v(3.0, 2.2, 1.5), v(2.0, 2.0, 1.5)], 0);
    build.quad([v(1.5, 1.2, 2.4), v(1.5, 1.8, 2.4), v(2.5, 1.8, 2.4), v(2.5, 1.2, 2.4)], lamp);
    build
}

pub fn at_voxel(voxel: f32) -> Params {
    Params { resolution: Resolution::Voxel(voxel), ..Params::default() }
}

pub fn simplify(scene: &Scene, voxel: f32) -> (Patches, Report) {
    let (patches, report) = voxel_simplify(scene, &at_voxel(voxel), &Quiet).expect("the scene is sound");
    patches.check().expect("patches obey the format");
    (patches, report)
}

/// Triangles that a patch has pieces of, in increasing order.
pub fn triangles_of(patches: &Patches, patch: usize) -> Vec<u32> {
    let mut triangles: Vec<u32> = patches.pieces_of(patch).iter().map(|p| p.face / 2).collect();
    triangles.sort_unstable();
    triangles.dedup();
    triangles
}

/// Patches with pieces of any of these triangles.
pub fn patches_with(patches: &Patches, triangles: &[u32]) -> Vec<usize> {
    (0..patches.len()).filter(|&p| triangles_of(patches, p).iter().any(|t| triangles.contains(t))).collect()
}
