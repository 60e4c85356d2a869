//! The scene's textures in the hardware, and the bind group of each material.

use radfile::{Materials, Texture, Wrap};

use crate::{Error, Gpu, Result, buffers::vec4, picture::MaterialUniform};

/// Most memory that decoding one texture may take, bytes.
const MAX_DECODED: u64 = 1 << 30;

struct Sampled {
    view: wgpu::TextureView,
    sampler: wgpu::Sampler,
}

/// One bind group a material: factors, reflectance texture, emission texture.
pub fn materials(
    gpu: &Gpu,
    materials: &Materials,
    one_sided: bool,
    layout: &wgpu::BindGroupLayout,
) -> Result<Vec<wgpu::BindGroup>> {
    let textures: Vec<Sampled> = materials.textures.iter().map(|t| decode(gpu, t)).collect::<Result<_>>()?;
    let white = upload(gpu, "white", &image::RgbaImage::from_pixel(1, 1, image::Rgba([255; 4])), [Wrap::Clamp; 2])?;
    let pick = |texture: Option<u32>| texture.map_or(&white, |t| &textures[t as usize]);
    let bind = |m: &radfile::Material| {
        let uniform = MaterialUniform {
            reflectance: vec4(m.reflectance, 0.0),
            emission: vec4(m.emission, f32::from(u8::from(one_sided))),
        };
        let uniform = gpu.uniform("material", &uniform);
        let (rho, glow) = (pick(m.reflectance_texture), pick(m.emission_texture));
        let resources = [
            uniform.as_entire_binding(),
            wgpu::BindingResource::TextureView(&rho.view),
            wgpu::BindingResource::Sampler(&rho.sampler),
            wgpu::BindingResource::TextureView(&glow.view),
            wgpu::BindingResource::Sampler(&glow.sampler),
        ];
        gpu.bind(layout, &resources)
    };
    Ok(materials.materials.iter().map(bind).collect())
}

fn decode(gpu: &Gpu, texture: &Texture) -> Result<Sampled> {
    let refused = |e: image::ImageError| scene::Error::Malformed {
        name: texture.name.clone(),
        what: format!("the texture cannot be decoded, expected PNG or JPEG: {e}"),
    };
    let reader = image::ImageReader::new(std::io::Cursor::new(&texture.bytes));
    let mut reader = reader.with_guessed_format().map_err(|e| refused(e.into()))?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(MAX_DECODED);
    reader.limits(limits);
    let image = reader.decode().map_err(refused)?.into_rgba8();
    upload(gpu, &texture.name, &image, texture.wrap)
}

/// Texels as sRGB, so that the hardware mixes light and not bytes.
fn upload(gpu: &Gpu, name: &str, image: &image::RgbaImage, wrap: [Wrap; 2]) -> Result<Sampled> {
    use wgpu::util::DeviceExt;
    let (width, height) = image.dimensions();
    let limit = gpu.device.limits().max_texture_dimension_2d;
    if width.max(height) > limit {
        return Err(Error::TooLarge {
            what: "a texture of the scene",
            need: format!("{width} x {height} texels ({name})"),
            adapter: gpu.adapter().to_string(),
            limit: limit.to_string(),
            rule: "maxTextureDimension2D",
            remedy: "scale the texture down",
        });
    }
    let descriptor = wgpu::TextureDescriptor {
        label: Some(name),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, order, image.as_raw());
    let [address_mode_u, address_mode_v] = wrap.map(|w| match w {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::Mirror => wgpu::AddressMode::MirrorRepeat,
        Wrap::Clamp => wgpu::AddressMode::ClampToEdge,
    });
    let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        address_mode_u,
        address_mode_v,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    });
    Ok(Sampled { view: texture.create_view(&Default::default()), sampler })
}
