//! Colour of low rank on the device: what half of an operator leaves out.

use bytemuck::{Pod, Zeroable};
use radfile::PackedOperator;

use crate::{
    Gpu, Result,
    kernels::{self, Dispatch, Kernel},
};

/// See `shaders/colour.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Column {
    pub codes: u32,
    pub members: u32,
    pub count: u32,
    pub first: u32,
    pub rank: u32,
    pub core: u32,
}

/// See `shaders/colour.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Member {
    pub patch_number: u32,
    pub scale: f32,
    pub first: u32,
}

/// The colour of an operator, ready for products.
pub struct Colour {
    kernels: [Kernel; 3],
    columns: wgpu::Buffer,
    members: wgpu::Buffer,
    codes: wgpu::Buffer,
    cores: wgpu::Buffer,
    gathered: wgpu::Buffer,
    carried: wgpu::Buffer,
    counts: [usize; 2],
}

const FEWER: &str = "bake fewer patches";

impl Colour {
    /// Uploads the colour of an operator, if it has any apart from its textures.
    ///
    /// # Errors
    ///
    /// [`crate::Error::TooLarge`].
    pub fn new(gpu: &Gpu, packed: &PackedOperator) -> Result<Option<Colour>> {
        let blocks = packed.colour();
        let Some(colour) = packed.half.as_ref().filter(|_| !blocks.is_empty()) else { return Ok(None) };
        let (mut columns, mut members, mut cores) = (Vec::new(), Vec::new(), Vec::new());
        let (mut words, mut read) = (Vec::<u32>::new(), 0);
        for block in &blocks {
            let (first, start, core) = (columns.len() as u32, members.len() as u32, cores.len() as u32);
            let (count, rank) = (block.patches.len(), block.rank);
            for codes in colour.codes[read..read + rank * count].chunks_exact(count) {
                let codes_at = words.len() as u32;
                let (count, rank) = (count as u32, rank as u32);
                columns.push(Column { codes: codes_at, members: start, count, first, rank, core });
                let word = |c: &[u8]| u32::from_le_bytes(std::array::from_fn(|i| c.get(i).copied().unwrap_or(0)));
                words.extend(codes.chunks(4).map(word));
            }
            read += rank * count;
            let member =
                |&patch: &u32| Member { patch_number: patch, scale: colour.scale[patch as usize] / 127.0, first };
            members.extend(block.patches.iter().map(member));
            let [red, green, blue] = &block.core;
            cores.extend((0..rank * rank).map(|at| [red[at], green[at], blue[at], 0.0]));
        }
        Ok(Some(Colour {
            kernels: [
                gpu.kernel("colour_gather", kernels::COLOUR_GATHER),
                gpu.kernel("colour_core", kernels::COLOUR_CORE),
                gpu.kernel("colour_scatter", kernels::COLOUR_SCATTER),
            ],
            counts: [columns.len(), members.len()],
            gathered: gpu.vectors("light that colour gathered", columns.len(), FEWER)?,
            carried: gpu.vectors("light that colour carries", columns.len(), FEWER)?,
            columns: gpu.storage("columns of colour", &columns, FEWER)?,
            members: gpu.storage("members of colour", &members, FEWER)?,
            codes: gpu.storage("codes of colour", &words, FEWER)?,
            cores: gpu.storage("cores of colour", &cores, FEWER)?,
        }))
    }

    /// What gives H += A^{-1/2} U C U^T x, bound once; `factors` holds √A in its fourth component.
    pub fn prepare(&self, gpu: &Gpu, factors: &wgpu::Buffer, x: &wgpu::Buffer, h: &wgpu::Buffer) -> [Dispatch; 3] {
        let Colour { columns, members, codes, cores, gathered, carried, .. } = self;
        let [gather, core, scatter] = &self.kernels;
        [
            gather.prepare(gpu, &entries(&[columns, members, codes, x, gathered]), self.counts[0]),
            core.prepare_each(gpu, &entries(&[columns, cores, gathered, carried]), self.counts[0]),
            scatter.prepare_each(gpu, &entries(&[columns, members, codes, factors, carried, h]), self.counts[1]),
        ]
    }
}

fn entries<'a>(buffers: &[&'a wgpu::Buffer]) -> Vec<wgpu::BindingResource<'a>> {
    buffers.iter().map(|b| b.as_entire_binding()).collect()
}
