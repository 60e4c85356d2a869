//! Bakes made by hand: a box whose form factors are gathered here and whose operator is summed here.
#![allow(dead_code, reason = "every test file uses a part of it")]

#[path = "../../../transfer/tests/common/mod.rs"]
mod maker;

pub use maker::Maker;

use glam::Vec3;
use radfile::{
    BlockFormat, Elements, FineMesh, FormFactors, Material, Materials, Mesh, NO_RECEIVER, PackedOperator, Packing,
    Patches, Rows, Transfer, ValueMap,
};
use relight::{Operator, Relighter};
use scene::{LightRig, Rays, Scene, Sobol, SurfacePoint, Surfaces, cosine_direction};

/// One material for everything.
pub fn scene(mesh: Mesh, reflectance: f32, emission: [f32; 3]) -> Scene {
    let material = Material {
        name: "grey".into(),
        reflectance: [reflectance; 3],
        reflectance_texture: None,
        emission,
        emission_texture: None,
    };
    Scene { mesh, materials: Materials { materials: vec![material], textures: vec![] }, ..Scene::default() }
}

/// A lights file.
pub fn rig(lights: &str) -> LightRig {
    LightRig::from_json(&format!(r#"{{"lights":[{lights}]}}"#)).expect("lights of the tests are sound")
}

/// The emission of the scene and nothing else.
pub fn emission() -> LightRig {
    LightRig { use_scene_emission: true, ..LightRig::default() }
}

/// Irradiance at one point.
pub fn at(scene: &Scene, rig: &LightRig, position: Vec3, normal: Vec3) -> [f64; 3] {
    let rays = Rays::new(&scene.mesh);
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials).expect("no textures");
    let light = relight::DirectLight::new(scene, &surfaces, &rays, rig);
    let point = SurfacePoint { position, normal, triangle: scene::NO_TRIANGLE };
    light.irradiance(&point, &relight::Samples::default(), 1)
}

/// Direct irradiance of whole patches.
pub fn patch_irradiance(
    light: &relight::DirectLight,
    mesh: &Mesh,
    patches: &Patches,
    sky: &[f32],
    points: u32,
) -> Vec<[f32; 3]> {
    let elements = Elements::whole(patches);
    let points = scene::ElementPoints::new(mesh, patches, &elements, points);
    relight::element_irradiance(light, &elements, &points, sky, 8, &radfile::Quiet)
}

/// A closed unit cube of `6 k²` equal patches.
pub struct Cube {
    pub scene: Scene,
    pub patches: Patches,
    pub elements: Elements,
    pub factors: FormFactors<'static>,
    pub operator: Operator<'static>,
}

impl Cube {
    /// Its parts tied together; `rays` are over its triangles.
    pub fn relighter<'a>(&'a self, rays: &'a Rays) -> Relighter<'a> {
        Relighter::new(&self.scene, rays, &self.patches, &self.elements, &self.operator, &self.factors.sky)
            .expect("parts of one cube")
    }
}

/// Every patch reflects and emits alike; `k` patches along an edge.
pub fn cube(k: usize, reflectance: f32, emission: f32) -> Cube {
    let mut maker = Maker::new(1.0 / k as f32);
    maker.room(Vec3::ZERO, Vec3::ONE, [k; 3]);
    let (mesh, mut patches) = maker.finish();
    patches.reflectance = vec![[reflectance; 3]; patches.len()];
    let factors = gathered(&mesh, &patches);
    let n = patches.len();
    let operator = all_bounces(&factors, reflectance);
    let factors =
        FormFactors { values: factors.iter().map(|v| *v as f32).collect::<Vec<_>>().into(), sky: vec![0.0; n].into() };
    let operator = as_outliers(&operator, n).into();
    let elements = Elements::whole(&patches);
    Cube { scene: scene(mesh, reflectance, [emission; 3]), patches, elements, factors, operator }
}

/// Form factors of equal patches by cosine rays, made symmetric with rows that sum to 1.
/// The maker gives patch `i` the triangles `2 i` and `2 i + 1`.
fn gathered(mesh: &Mesh, patches: &Patches) -> Vec<f64> {
    let n = patches.len();
    let rays = Rays::new(mesh);
    let sampler = scene::PatchSampler::new(patches);
    let mut f = vec![0.0; n * n];
    for i in 0..n {
        let sobol = Sobol::new(i as u32);
        for s in 0..1024 {
            let [x, y, z, w] = sobol.sample(s);
            let p = sampler.point(i, x, y);
            let origin = rays.off_surface(p.position, p.normal);
            let hit = rays.closest(origin, cosine_direction(p.normal, z, w), f32::INFINITY, p.triangle);
            let j = hit.expect("the cube is closed").triangle as usize / 2;
            if i != j {
                f[i * n + j] += 0.5;
                f[j * n + i] += 0.5;
            }
        }
    }
    for _ in 0..100 {
        let sums: Vec<f64> = f.chunks(n).map(|row| row.iter().sum()).collect();
        for i in 0..n {
            for j in 0..n {
                f[i * n + j] /= (sums[i] * sums[j]).sqrt();
            }
        }
    }
    f
}

/// K = F + ρ F K, repeated until nothing is missing; with equal areas K needs no scaling.
fn all_bounces(f: &[f64], reflectance: f32) -> Vec<f64> {
    let n = f.len().isqrt();
    let rho = f64::from(reflectance);
    let rounds = (1e-9f64.ln() / rho.ln()).ceil() as usize;
    let mut k = f.to_vec();
    for _ in 0..rounds {
        let mut next = f.to_vec();
        for i in 0..n {
            for j in 0..n {
                let factor = rho * f[i * n + j];
                if factor > 0.0 {
                    for (a, b) in next[i * n..][..n].iter_mut().zip(&k[j * n..][..n]) {
                        *a += factor * b;
                    }
                }
            }
        }
        k = next;
    }
    k
}

/// A matrix as a packed operator without loss: every entry is an outlier of a black texture.
fn as_outliers(k: &[f64], n: usize) -> PackedOperator<'static> {
    let (tile, tiles) = Packing::tiling(n as u32);
    let packing = Packing {
        n: n as u32,
        channels: 1,
        bounces: None,
        format: BlockFormat::Bc4,
        map: ValueMap::Sqrt,
        scale: [0.0; 3],
        tile,
        tiles,
    };
    PackedOperator {
        half: None,
        blocks: vec![0; packing.tile_count() * packing.tile_bytes()].into(),
        outlier_start: (0..=n).map(|i| (i * n) as u32).collect::<Vec<_>>().into(),
        outlier_column: (0..n * n).map(|i| (i % n) as u32).collect::<Vec<_>>().into(),
        outlier_value: k.iter().map(|v| *v as f32).collect::<Vec<_>>().into(),
        packing,
    }
}

/// The mesh as its own fine mesh; each corner of a front side receives the light of its patch.
pub fn corners_receive(mesh: &Mesh) -> (Transfer, Rows) {
    let (mut made, mut rows) = (Transfer::default(), Rows { row_start: vec![0], ..Rows::default() });
    let mut receivers = Vec::new();
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t).map(Vec3::from);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        receivers.push([[0, 1, 2].map(|c| 3 * t as u32 + c), [NO_RECEIVER; 3]]);
        for corner in corners {
            made.position.push(corner.lerp(middle, 0.1).to_array());
            made.normal.push(normal.to_array());
            rows.sender.push(t as u32 / 2);
            rows.weight.push(1.0);
            rows.row_start.push(rows.sender.len() as u32);
        }
    }
    made.fine = FineMesh {
        vertex: mesh.positions.clone(),
        triangle: mesh.triangles.clone(),
        source: (0..mesh.triangles.len() as u32).collect(),
        receiver: receivers,
    };
    (made, rows)
}
