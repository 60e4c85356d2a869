//! Sparse weights on the GPU, and the gather from patches to receivers.

use bytemuck::{Pod, Zeroable};
use radfile::Rows;

use crate::{
    Error, Gpu, Result,
    buffers::vec4,
    kernels::{self, Kernel},
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
        if start.windows(2).any(|w| w[0] > w[1]) || ends != rows.patch.len() || ends != rows.weight.len() {
            return shape(format!(
                "rows end at {ends}, with {} senders and {} weights; all three must agree",
                rows.patch.len(),
                rows.weight.len()
            ));
        }
        if let Some(p) = rows.patch.iter().find(|&&p| p as usize >= patches) {
            return shape(format!("an entry names patch {p}, there are {patches}"));
        }
        Ok(RowTables {
            count: rows.len(),
            start: gpu.storage("rows of receivers", start, FEWER)?,
            sender: gpu.storage("senders of receivers", &rows.patch, FEWER)?,
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
    #[expect(clippy::too_many_arguments, reason = "each is one binding of the kernel")]
    pub fn run(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        rows: &RowTables,
        mixture: Mixture,
        light: &wgpu::Buffer,
        sky: &wgpu::Buffer,
        out: &wgpu::Buffer,
    ) {
        let params = GatherParams {
            receivers: rows.count as u32,
            share: mixture.share,
            sky: vec4(mixture.sky, 0.0),
            ..Default::default()
        };
        let uniform = gpu.uniform("gather", &params);
        let buffers = [&uniform, &rows.start, &rows.sender, &rows.weight, light, sky, out];
        self.0.each(gpu, encoder, &buffers.map(|b| b.as_entire_binding()), rows.count);
    }
}
