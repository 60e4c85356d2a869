//! What the GPU knows of the patches and their elements: sample points, factors, the sky they see; and small kernels.

use bytemuck::{Pod, Zeroable};
use radfile::{Elements, Mesh, Patches, Rows};
use scene::ElementPoints;

use crate::{
    Gpu, Result,
    buffers::vec4,
    gather::RowTables,
    kernels::{self, Dispatch, Kernel, Parametric},
    shadows::Points,
};

/// See `shaders/element_light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct ElementLightParams {
    pub sky: [f32; 4],
}

/// Patches on the GPU.
pub struct PatchTables {
    /// Number of patches.
    pub count: usize,
    /// Number of elements.
    pub elements: usize,
    /// Sample points, those of one element together.
    pub points: Points,
    /// ρ and √A of each patch.
    pub factors: wgpu::Buffer,
    /// What each patch sees of the sky.
    pub sky: wgpu::Buffer,
    /// The mean of its elements for each patch.
    pub means: RowTables,
    /// Where the sample points of each element start and end.
    range: wgpu::Buffer,
    /// Where the elements of each patch start.
    start: wgpu::Buffer,
    /// ρ of each element and its share of its patch.
    element_factors: wgpu::Buffer,
    /// What the patch of each element sees of the sky.
    pub element_sky: wgpu::Buffer,
    element_light: Kernel,
    senders: Kernel,
    radiosity: Kernel,
}

const FEWER: &str = "bake fewer patches or take fewer samples on each";

impl PatchTables {
    /// Uploads everything; `samples` points are drawn on each patch if its elements have none.
    pub fn new(
        gpu: &Gpu,
        patches: &Patches,
        elements: &Elements,
        sky: &[f32],
        mesh: &Mesh,
        samples: u32,
    ) -> Result<PatchTables> {
        let count = patches.len();
        gpu.check_storage("the sample points of patches", 16 * count as u64 * u64::from(samples), FEWER)?;
        let points = ElementPoints::new(mesh, patches, elements, samples);
        let position: Vec<[f32; 4]> = points.points.iter().map(|p| vec4(p.position.to_array(), 1.0)).collect();
        let normal: Vec<[f32; 4]> = points.points.iter().map(|p| vec4(p.normal.to_array(), 0.0)).collect();
        let range: Vec<[u32; 2]> =
            (0..elements.len()).map(|e| points.of(e)).map(|r| [r.start as u32, r.end as u32]).collect();
        let factors: Vec<[f32; 4]> =
            patches.reflectance.iter().zip(&patches.area).map(|(&rho, area)| vec4(rho, area.sqrt())).collect();
        let means = means(elements);
        let element_factors: Vec<[f32; 4]> =
            elements.reflectance.iter().zip(&means.weight).map(|(&rho, &share)| vec4(rho, share)).collect();
        let element_sky: Vec<f32> = (0..count).flat_map(|p| elements.of(p).map(move |_| sky[p])).collect();
        Ok(PatchTables {
            count,
            elements: elements.len(),
            points: Points {
                count: position.len(),
                irradiance: gpu.vectors("light of sample points", position.len(), FEWER)?,
                position: gpu.storage("sample points", &position, FEWER)?,
                normal: gpu.storage("normals of sample points", &normal, FEWER)?,
            },
            factors: gpu.storage("patches", &factors, FEWER)?,
            sky: gpu.storage("sky of patches", sky, FEWER)?,
            means: RowTables::new(gpu, &means, elements.len())?,
            range: gpu.storage("ranges of elements", &range, FEWER)?,
            start: gpu.storage("elements of patches", &elements.start, FEWER)?,
            element_factors: gpu.storage("elements", &element_factors, FEWER)?,
            element_sky: gpu.storage("sky of elements", &element_sky, FEWER)?,
            element_light: gpu.kernel("element_light", kernels::ELEMENT_LIGHT),
            senders: gpu.kernel("senders", kernels::SENDERS),
            radiosity: gpu.kernel("radiosity", kernels::RADIOSITY),
        })
    }

    /// A vector for each patch.
    pub fn vectors(&self, gpu: &Gpu, what: &'static str) -> Result<wgpu::Buffer> {
        gpu.vectors(what, self.count, FEWER)
    }

    /// A vector for each element.
    pub fn element_vectors(&self, gpu: &Gpu, what: &'static str) -> Result<wgpu::Buffer> {
        gpu.vectors(what, self.elements, FEWER)
    }

    /// H⁰ of the elements from the light of the sample points.
    pub fn element_light(&self, gpu: &Gpu, h0: &wgpu::Buffer) -> Parametric {
        let uniform = gpu.uniform("element light", &ElementLightParams::default());
        let buffers = [&uniform, &self.points.irradiance, &self.range, &self.element_sky, h0];
        let dispatch = self.element_light.prepare_each(gpu, &buffers.map(|b| b.as_entire_binding()), self.elements);
        Parametric::new(uniform, dispatch)
    }

    /// x = √A ρ H⁰.
    pub fn send(&self, gpu: &Gpu, h0: &wgpu::Buffer, x: &wgpu::Buffer) -> Dispatch {
        let buffers = [&self.factors, h0, x].map(|b| b.as_entire_binding());
        self.senders.prepare_each(gpu, &buffers, self.count)
    }

    /// A vector for each sender of the last gather.
    pub fn sender_vectors(&self, gpu: &Gpu, what: &'static str) -> Result<wgpu::Buffer> {
        gpu.vectors(what, self.count + self.elements, FEWER)
    }

    /// B = ρ (H⁰ + H) of patches and elements for `arriving` = H⁰ of the elements, H of the patches.
    pub fn radiosity(&self, gpu: &Gpu, arriving: [&wgpu::Buffer; 2], b: &wgpu::Buffer) -> Dispatch {
        let buffers = [&self.element_factors, &self.start, arriving[0], arriving[1], b];
        self.radiosity.prepare_each(gpu, &buffers.map(|b| b.as_entire_binding()), self.count)
    }
}

/// For each patch the mean of its elements by area.
fn means(elements: &Elements) -> Rows {
    let mut rows = Rows { row_start: vec![0], ..Rows::default() };
    for patch in 0..elements.patches() {
        let own = elements.of(patch);
        let area: f32 = elements.area[own.clone()].iter().sum();
        rows.weight.extend(elements.area[own.clone()].iter().map(|a| a / area));
        rows.sender.extend(own.map(|e| e as u32));
        rows.row_start.push(rows.sender.len() as u32);
    }
    rows
}
