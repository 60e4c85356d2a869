//! What the GPU knows of the patches: sample points, factors, the sky they see; and small kernels.

use bytemuck::{Pod, Zeroable};
use radfile::Patches;
use scene::{PatchSampler, Sobol, hash};

use crate::{
    Gpu, Result,
    buffers::vec4,
    kernels::{self, Dispatch, Kernel, Parametric},
    shadows::Points,
};

/// See `shaders/patch_light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct PatchLightParams {
    pub patch_count: u32,
    pub samples: u32,
    pub unused_a: u32,
    pub unused_b: u32,
    pub sky: [f32; 4],
}

/// Patches on the GPU.
pub struct PatchTables {
    /// Number of patches.
    pub count: usize,
    samples: u32,
    /// Sample points, those of one patch together.
    pub points: Points,
    /// ρ and √A of each patch.
    pub factors: wgpu::Buffer,
    /// What each patch sees of the sky.
    pub sky: wgpu::Buffer,
    patch_light: Kernel,
    senders: Kernel,
    radiosity: Kernel,
}

const FEWER: &str = "bake fewer patches or take fewer samples on each";

impl PatchTables {
    /// Draws the sample points and uploads everything.
    pub fn new(gpu: &Gpu, patches: &Patches, sky: &[f32], samples: u32, seed: u32) -> Result<PatchTables> {
        let count = patches.len();
        gpu.check_storage("the sample points of patches", 16 * count as u64 * u64::from(samples), FEWER)?;
        let sampler = PatchSampler::new(patches);
        let (mut position, mut normal) = (Vec::new(), Vec::new());
        for patch in 0..count {
            let sobol = Sobol::new(hash(seed, patch as u32));
            for s in 0..samples {
                let [x, y, ..] = sobol.sample(s);
                let point = sampler.point(patch, x, y);
                position.push(vec4(point.position.to_array(), 1.0));
                normal.push(vec4(point.normal.to_array(), 0.0));
            }
        }
        let factors: Vec<[f32; 4]> =
            patches.reflectance.iter().zip(&patches.area).map(|(&rho, area)| vec4(rho, area.sqrt())).collect();
        Ok(PatchTables {
            count,
            samples,
            points: Points {
                count: position.len(),
                irradiance: gpu.vectors("light of sample points", position.len(), FEWER)?,
                position: gpu.storage("sample points", &position, FEWER)?,
                normal: gpu.storage("normals of sample points", &normal, FEWER)?,
            },
            factors: gpu.storage("patches", &factors, FEWER)?,
            sky: gpu.storage("sky of patches", sky, FEWER)?,
            patch_light: gpu.kernel("patch_light", kernels::PATCH_LIGHT),
            senders: gpu.kernel("senders", kernels::SENDERS),
            radiosity: gpu.kernel("radiosity", kernels::RADIOSITY),
        })
    }

    /// A vector for each patch.
    pub fn vectors(&self, gpu: &Gpu, what: &'static str) -> Result<wgpu::Buffer> {
        gpu.vectors(what, self.count, FEWER)
    }

    /// H⁰ from the light of the sample points.
    pub fn mean(&self, gpu: &Gpu, h0: &wgpu::Buffer) -> Parametric {
        let uniform = gpu.uniform("patch light", &self.mean_params([0.0; 3]));
        let buffers = [&uniform, &self.points.irradiance, &self.sky, h0].map(|b| b.as_entire_binding());
        let dispatch = self.patch_light.prepare_each(gpu, &buffers, self.count);
        Parametric::new(uniform, dispatch)
    }

    /// Parameters of [`PatchTables::mean`]; `sky` is π L.
    pub fn mean_params(&self, sky: [f32; 3]) -> PatchLightParams {
        let (patch_count, samples) = (self.count as u32, self.samples);
        PatchLightParams { patch_count, samples, sky: vec4(sky, 0.0), ..Default::default() }
    }

    /// x = √A ρ H⁰.
    pub fn send(&self, gpu: &Gpu, h0: &wgpu::Buffer, x: &wgpu::Buffer) -> Dispatch {
        let buffers = [&self.factors, h0, x].map(|b| b.as_entire_binding());
        self.senders.prepare_each(gpu, &buffers, self.count)
    }

    /// B = ρ (H⁰ + H) for `arriving` = [H⁰, H].
    pub fn radiosity(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        arriving: [&wgpu::Buffer; 2],
        b: &wgpu::Buffer,
    ) {
        let buffers = [&self.factors, arriving[0], arriving[1], b].map(|b| b.as_entire_binding());
        self.radiosity.each(gpu, encoder, &buffers, self.count);
    }
}
