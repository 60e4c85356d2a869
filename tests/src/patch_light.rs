//! Light of the patches themselves, with the dense operator and with the packed one.
//!
//! The program answers at points, which adds interpolation. What is exact for patches is asked of the functions that
//! the program calls.

use radfile::{Container, Elements, Operator, Patches, Quiet, Record, read_sky};
use relight::{DirectLight, PatchSamples, element_irradiance};
use scene::{ElementPoints, LightRig, Rays, Scene, Surfaces};
use serde_json::Value;

/// Irradiance of every patch, W/m².
pub struct PatchLight {
    pub area: Vec<f64>,
    pub direct: Vec<[f64; 3]>,
    /// All bounces, dense operator.
    pub indirect: Vec<[f64; 3]>,
    /// All bounces, packed operator.
    pub packed: Vec<[f64; 3]>,
}

impl PatchLight {
    /// Of a bake that kept its dense matrices.
    pub fn new(bake: &Container, lights: &Value) -> PatchLight {
        let (scene, patches) = (Scene::read(bake).expect("a scene"), Patches::read(bake).expect("patches"));
        let (rays, rig) = (Rays::new(&scene.mesh), LightRig::from_json(&lights.to_string()).expect("lights"));
        let surfaces = Surfaces::new(&scene.mesh, &scene.materials).expect("surfaces");
        let light = DirectLight::new(&scene, &surfaces, &rays, &rig);
        let sky = read_sky(bake).expect("the sky");
        let (samples, elements) = (PatchSamples::default(), Elements::whole(&patches));
        let points = ElementPoints::new(&scene.mesh, &patches, &elements, samples.points);
        let direct = element_irradiance(&light, &elements, &points, sky, samples.area, &Quiet);
        let packed = relight::indirect(&patches, &relight::Operator::read(bake).expect("a packed operator"), &direct);
        let wide = |values: Vec<[f32; 3]>| values.into_iter().map(|v| v.map(f64::from)).collect::<Vec<_>>();
        let direct = wide(direct);
        let indirect = all_bounces(&patches, &Operator::read(bake).expect("the operator"), &direct);
        PatchLight { area: patches.area.iter().map(|&a| a.into()).collect(), direct, indirect, packed: wide(packed) }
    }

    /// Mean over the area of one colour.
    pub fn mean(&self, values: &[[f64; 3]], colour: usize) -> f64 {
        let sum: f64 = values.iter().zip(&self.area).map(|(v, a)| a * v[colour]).sum();
        sum / self.area.iter().sum::<f64>()
    }
}

/// A^{-1/2} K A^{1/2} ρ H⁰.
fn all_bounces(patches: &Patches, operator: &Operator, direct: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let root: Vec<f64> = patches.area.iter().map(|&a| f64::from(a).sqrt()).collect();
    let received = |i: usize, colour: usize| {
        let row = &operator.channel(colour)[i * operator.n..][..operator.n];
        let sent = |j: usize| root[j] * f64::from(patches.reflectance[j][colour]) * direct[j][colour];
        row.iter().enumerate().map(|(j, &k)| f64::from(k) * sent(j)).sum::<f64>() / root[i]
    };
    (0..operator.n).map(|i| std::array::from_fn(|colour| received(i, colour))).collect()
}
