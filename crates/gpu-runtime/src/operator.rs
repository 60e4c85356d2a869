//! The packed operator on the GPU and its product.

use bytemuck::{Pod, Zeroable};
use radfile::{BlockFormat, PackedOperator, ValueMap};
use serde::Serialize;
use wgpu::util::DeviceExt;

use crate::{
    Error, Gpu, Result,
    colour::Colour,
    kernels::{self, Dispatch, Kernel},
};

/// Who decodes the blocks of the operator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Decode {
    /// The hardware, if it has the feature and a probe of it on this operator's own blocks is good.
    #[default]
    Auto,
    /// The hardware's texture units.
    Sampled,
    /// The kernel, in single precision, from a storage buffer.
    Stored,
}

/// See `shaders/product.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct ProductParams {
    pub patch_count: u32,
    pub tile: u32,
    pub tiles: u32,
    pub planes: u32,
    pub channels: u32,
    pub logarithmic: u32,
    pub shift: f32,
    pub bc1: u32,
    pub scale: [f32; 4],
    pub half: u32,
    pub wide: u32,
    pub high: u32,
    pub unused: u32,
}

impl ProductParams {
    fn new(packed: &PackedOperator) -> ProductParams {
        let p = &packed.packing;
        let [width, height, _] = packed.texture_size();
        let [r, g, b] = p.scale;
        let (logarithmic, shift) = match p.map {
            ValueMap::Log { shift } => (1, shift),
            ValueMap::Sqrt => (0, 0.0),
        };
        ProductParams {
            patch_count: p.n,
            tile: p.tile,
            tiles: p.tiles,
            planes: packed.planes() as u32,
            channels: if packed.half.is_some() { 1 } else { p.channels },
            logarithmic,
            shift,
            bc1: u32::from(p.format == BlockFormat::Bc1),
            scale: if p.channels == 1 { [r, r, r, 0.0] } else { [r, g, b, 0.0] },
            half: u32::from(packed.half.is_some()),
            wide: width / 4,
            high: height / 4,
            unused: 0,
        }
    }
}

/// Where the blocks lie.
enum Blocks {
    Texture(wgpu::TextureView),
    Buffer(wgpu::Buffer),
}

/// The operator, ready for products.
pub struct Operator {
    kernel: Kernel,
    params: wgpu::Buffer,
    blocks: Blocks,
    outliers: [wgpu::Buffer; 3],
    colour: Option<Colour>,
    n: usize,
    /// Length of the vector of senders, whole tiles.
    width: usize,
}

const FEWER: &str = "bake fewer patches";

impl Operator {
    /// Uploads an operator; `sampled` says who decodes it.
    ///
    /// # Errors
    ///
    /// [`Error::Unsupported`] and [`Error::TooLarge`].
    pub fn new(gpu: &Gpu, packed: &PackedOperator, sampled: bool) -> Result<Operator> {
        let p = &packed.packing;
        let (kernel, blocks) = if sampled {
            (gpu.kernel("product", kernels::PRODUCT_SAMPLED), Blocks::Texture(texture(gpu, packed)?))
        } else {
            let blocks = gpu.storage("the packed operator", &packed.blocks[..], FEWER)?;
            (gpu.kernel("product", kernels::PRODUCT_STORED), Blocks::Buffer(blocks))
        };
        let outliers = packed.outliers();
        Ok(Operator {
            kernel,
            params: gpu.uniform("product", &ProductParams::new(packed)),
            blocks,
            outliers: [
                gpu.storage("outliers", &outliers.start[..], FEWER)?,
                gpu.storage("columns of outliers", &outliers.column[..], FEWER)?,
                gpu.storage("values of outliers", &outliers.value[..], FEWER)?,
            ],
            colour: Colour::new(gpu, packed)?,
            n: p.n as usize,
            width: p.tile as usize * p.tiles as usize,
        })
    }

    /// A vector of senders, all 0.
    pub fn senders(&self, gpu: &Gpu) -> Result<wgpu::Buffer> {
        gpu.vectors("senders", self.width, FEWER)
    }

    /// What gives H = A^{-1/2} K x, bound once; `factors` holds √A in its fourth component.
    pub fn prepare(&self, gpu: &Gpu, factors: &wgpu::Buffer, x: &wgpu::Buffer, h: &wgpu::Buffer) -> Vec<Dispatch> {
        let [start, column, value] = &self.outliers;
        let mut resources: Vec<wgpu::BindingResource> =
            [&self.params, factors, x, start, column, value, h].map(|b| b.as_entire_binding()).into();
        resources.push(match &self.blocks {
            Blocks::Texture(view) => wgpu::BindingResource::TextureView(view),
            Blocks::Buffer(buffer) => buffer.as_entire_binding(),
        });
        let mut product = vec![self.kernel.prepare(gpu, &resources, self.n.div_ceil(4))];
        product.extend(self.colour.iter().flat_map(|colour| colour.prepare(gpu, factors, x, h)));
        product
    }
}

/// Uploads the blocks as an array texture.
fn texture(gpu: &Gpu, packed: &PackedOperator) -> Result<wgpu::TextureView> {
    let (p, limits) = (&packed.packing, gpu.device.limits());
    if !gpu.has_block_textures() {
        return Err(Error::Unsupported {
            adapter: gpu.adapter().to_string(),
            feature: "block-compressed textures (texture-compression-bc)",
            remedy: "let the kernel decode the blocks, or use --backend cpu",
        });
    }
    let [width, height, layers] = packed.texture_size();
    if layers > limits.max_texture_array_layers || width.max(height) > limits.max_texture_dimension_2d {
        return Err(Error::TooLarge {
            what: "the packed operator",
            need: format!("{layers} layers of {width} x {height} texels"),
            adapter: gpu.adapter().to_string(),
            limit: format!("{} of {}", limits.max_texture_array_layers, limits.max_texture_dimension_2d),
            rule: "maxTextureArrayLayers, maxTextureDimension2D",
            remedy: FEWER,
        });
    }
    let descriptor = wgpu::TextureDescriptor {
        label: Some("packed operator"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: match p.format {
            BlockFormat::Bc1 => wgpu::TextureFormat::Bc1RgbaUnorm,
            BlockFormat::Bc4 => wgpu::TextureFormat::Bc4RUnorm,
        },
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, order, &packed.texture_blocks());
    Ok(texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    }))
}
