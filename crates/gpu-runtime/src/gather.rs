//! Sparse weights on the GPU, and the gather from patches to receivers.

use bytemuck::{Pod, Zeroable};
use radfile::Rows;

use crate::{
    Error, Gpu, Result,
    buffers::vec4,
    kernels::{self, Kernel, Parametric},
};

/// See `shaders/gather.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct GatherParams {
    pub receivers: u32,
    pub share: f32,
    pub unused_a: u32,
    pub unused_b: u32,
    pub sky: [f32; 4],
}

/// Rows on the GPU.
pub struct RowTables {
    /// Number of receivers.
    pub count: usize,
    start: wgpu::Buffer,
    sender: wgpu::Buffer,
    weight: wgpu::Buffer,
}

const FEWER: &str = "take fewer receivers (a coarser fine mesh, or points in parts)";

impl RowTables {
    /// Checks rows against the number of patches and uploads them.
    pub fn new(gpu: &Gpu, rows: &Rows, patches: usize) -> Result<RowTables> {
        let start = &rows.row_start;
        let shape = |what: String| Err(Error::Shape { what: format!("weights of receivers: {what}") });
        let ends = start.last().copied().unwrap_or(0) as usize;
        if start.windows(2).any(|w| w[0] > w[1]) || ends != rows.sender.len() || ends != rows.weight.len() {
            return shape(format!(
                "rows end at {ends}, with {} senders and {} weights; all three must agree",
                rows.sender.len(),
                rows.weight.len()
            ));
        }
        if let Some(p) = rows.sender.iter().find(|&&p| p as usize >= patches) {
            return shape(format!("an entry names patch {p}, there are {patches}"));
        }
        Ok(RowTables {
            count: rows.len(),
            start: gpu.storage("rows of receivers", start, FEWER)?,
            sender: gpu.storage("senders of receivers", &rows.sender, FEWER)?,
            weight: gpu.storage("weights of receivers", &rows.weight, FEWER)?,
        })
    }

    /// A vector for each receiver.
    pub fn vectors(&self, gpu: &Gpu, what: &'static str) -> Result<wgpu::Buffer> {
        gpu.vectors(what, self.count, FEWER)
    }
}

/// What is gathered: `share` times the light of patches, and π L of the sky.
#[derive(Clone, Copy)]
pub struct Mixture {
    pub share: f32,
    pub sky: [f32; 3],
}

/// The kernel.
pub struct Gather(Kernel);

impl Gather {
    pub fn new(gpu: &Gpu) -> Gather {
        Gather(gpu.kernel("gather", kernels::GATHER))
    }

    /// Irradiance at receivers from `light` of the patches and the `sky` they see.
    pub fn prepare(
        &self,
        gpu: &Gpu,
        rows: &RowTables,
        light: &wgpu::Buffer,
        sky: &wgpu::Buffer,
        out: &wgpu::Buffer,
    ) -> Parametric {
        let uniform = gpu.uniform("gather", &GatherParams::default());
        let buffers = [&uniform, &rows.start, &rows.sender, &rows.weight, light, sky, out];
        let dispatch = self.0.prepare_each(gpu, &buffers.map(|b| b.as_entire_binding()), rows.count);
        Parametric::new(uniform, dispatch)
    }
}

impl Mixture {
    /// The light of patches alone.
    pub const LIGHT: Mixture = Mixture { share: 1.0, sky: [0.0; 3] };

    /// Parameters of the kernel for `rows`.
    pub fn params(self, rows: &RowTables) -> GatherParams {
        let (receivers, sky) = (rows.count as u32, vec4(self.sky, 0.0));
        GatherParams { receivers, share: self.share, sky, ..Default::default() }
    }
}
