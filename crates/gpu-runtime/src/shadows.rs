//! Shadow maps, and the light of lamps on points.
//!
//! One set of six layers serves all lamps in turn: a lamp's views are drawn, its light is added to every
//! list of points, and the next lamp draws over them. So memory does not grow with the lamps.

use radfile::Mesh;

use crate::{
    Error, Gpu, Result,
    buffers::vec4,
    kernels::{self, Kernel},
    lamp::Lamp,
};

/// Points that receive direct light.
pub struct Points {
    /// Position, 1 in the fourth component; 0 where there is no point.
    pub position: wgpu::Buffer,
    /// Unit normal.
    pub normal: wgpu::Buffer,
    /// Irradiance that lamps are added to.
    pub irradiance: wgpu::Buffer,
    /// Number of points.
    pub count: usize,
}

impl Points {
    /// Points in the dark.
    pub fn new(gpu: &Gpu, position: &[[f32; 3]], normal: &[[f32; 3]]) -> Result<Points> {
        const PARTS: &str = "take the points in parts";
        let wide = |values: &[[f32; 3]], w| values.iter().map(|&v| vec4(v, w)).collect::<Vec<_>>();
        Ok(Points {
            position: gpu.storage("points", &wide(position, 1.0), PARTS)?,
            normal: gpu.storage("normals of points", &wide(normal, 0.0), PARTS)?,
            irradiance: gpu.vectors("direct light of points", position.len(), PARTS)?,
            count: position.len(),
        })
    }
}

/// The mesh and the maps its shadows are drawn into.
pub struct Shadows {
    pipeline: wgpu::RenderPipeline,
    direct: Kernel,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
    layers: Vec<wgpu::TextureView>,
    map: wgpu::TextureView,
}

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

impl Shadows {
    /// Uploads the mesh and makes maps of `resolution` texels along an edge.
    pub fn new(gpu: &Gpu, mesh: &Mesh, resolution: u32) -> Result<Shadows> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if !(1..=limit).contains(&resolution) {
            return Err(Error::TooLarge {
                what: "a shadow map",
                need: format!("{resolution} texels along an edge"),
                adapter: gpu.adapter().to_string(),
                limit: format!("1 to {limit}"),
                rule: "maxTextureDimension2D",
                remedy: "choose another shadow resolution",
            });
        }
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow maps"),
            size: wgpu::Extent3d { width: resolution, height: resolution, depth_or_array_layers: 6 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let layer = |base_array_layer| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer,
                array_layer_count: Some(1),
                ..Default::default()
            })
        };
        Ok(Shadows {
            pipeline: pipeline(gpu),
            direct: gpu.kernel("direct", kernels::DIRECT),
            vertices: gpu.geometry("mesh vertices", mesh.positions.as_flattened(), wgpu::BufferUsages::VERTEX)?,
            indices: gpu.geometry("mesh indices", mesh.triangles.as_flattened(), wgpu::BufferUsages::INDEX)?,
            index_count: 3 * mesh.triangles.len() as u32,
            layers: (0..6).map(layer).collect(),
            map: texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            }),
        })
    }

    /// Adds the light of all lamps to all points; at most once in a submission, for `uniforms` hold one lamp each.
    /// Those that are missing are made.
    pub fn light(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        lamps: &[Lamp],
        targets: &[&Points],
        uniforms: &mut Vec<wgpu::Buffer>,
    ) {
        uniforms.extend(lamps.iter().skip(uniforms.len()).map(|lamp| gpu.uniform("lamp", lamp)));
        for (lamp, uniform) in lamps.iter().zip(uniforms) {
            gpu.queue.write_buffer(uniform, 0, bytemuck::bytes_of(lamp));
            self.draw(gpu, encoder, lamp, uniform);
            for points in targets {
                let resources = [
                    uniform.as_entire_binding(),
                    wgpu::BindingResource::TextureView(&self.map),
                    points.position.as_entire_binding(),
                    points.normal.as_entire_binding(),
                    points.irradiance.as_entire_binding(),
                ];
                self.direct.each(gpu, encoder, &resources, points.count);
            }
        }
    }

    /// Draws the views of one lamp.
    fn draw(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, lamp: &Lamp, uniform: &wgpu::Buffer) {
        let bindings = gpu.bind(&self.pipeline.get_bind_group_layout(0), &[uniform.as_entire_binding()]);
        for view in 0..lamp.view_count {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("shadow map"),
                color_attachments: &[],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.layers[view as usize],
                    // Depth falls with distance, 0 is infinitely far.
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
                    stencil_ops: None,
                }),
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            let edge = lamp.resolution as f32;
            pass.set_viewport(0.0, 0.0, edge, edge, 0.0, 1.0);
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &bindings, &[]);
            pass.set_vertex_buffer(0, self.vertices.slice(..));
            pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..self.index_count, 0, view..view + 1);
        }
    }
}

fn pipeline(gpu: &Gpu) -> wgpu::RenderPipeline {
    let module = gpu.shader("shadow map", kernels::SHADOW_MAP);
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("shadow map"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("shadow_map"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 12,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3],
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    })
}
