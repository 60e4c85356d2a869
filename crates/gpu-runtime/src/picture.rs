//! Offscreen pictures: what each pixel sees, then its radiance.
//!
//! The fine mesh is drawn once into targets that hold position, normal, triangle and material; the pixels
//! become points like any others, to which lamps add their light; a last kernel puts everything together.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use radfile::{NO_RECEIVER, Patches, Side, Transfer, face_id};
use scene::{Camera, Scene};

use crate::{
    Error, Gpu, Result,
    buffers::{Download, vec4},
    kernels::{self, Kernel, Parametric},
    shadows::Points,
    textures,
    view::View,
};

/// Which light a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// Direct light as surfaces reflect it to the eye, emission and sky.
    pub direct: bool,
    /// Light of one and more bounces as surfaces reflect it to the eye.
    pub indirect: bool,
}

impl Default for Parts {
    fn default() -> Parts {
        Parts { direct: true, indirect: true }
    }
}

/// See `Camera` in `shaders/surface.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct CameraUniform {
    pub view: View,
    pub eye: [f32; 4],
}

/// See `Material` in `shaders/surface.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct MaterialUniform {
    pub reflectance: [f32; 4],
    pub emission: [f32; 4],
}

/// See `shaders/shade.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct ShadeParams {
    pub width: u32,
    pub height: u32,
    pub pitch: u32,
    pub detail: u32,
    pub glow: f32,
    pub unused_a: u32,
    pub unused_b: u32,
    pub unused_c: u32,
    pub background: [f32; 4],
}

/// A corner of a fine triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Corner {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    emission_uv: [f32; 2],
}

/// The fine mesh on the GPU, sorted by material.
pub struct FineTables {
    pipeline: wgpu::RenderPipeline,
    shade: Kernel,
    corners: wgpu::Buffer,
    /// Six a triangle, see `shaders/shade.wgsl`.
    receivers: wgpu::Buffer,
    /// Bind group and vertices of each material in use.
    draws: Vec<(wgpu::BindGroup, std::ops::Range<u32>)>,
    /// Nearest distance that is seen, metres.
    near: f32,
}

const TARGET: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const SMALLER: &str = "render a smaller picture or one with fewer samples a pixel";
/// Rows of a copy from a texture are multiples of 256 bytes.
const ROW_PIXELS: u32 = 256 / 16;

/// What a picture of one size is made on.
pub struct Canvas {
    /// Pixels of the picture along its edges.
    size: [u32; 2],
    /// Samples along the edge of a pixel.
    detail: u32,
    /// Samples of a row, those that fill it up to whole copies too.
    pitch: u32,
    camera: wgpu::Buffer,
    view: wgpu::BindGroup,
    /// Position, normal, reflectance and emission of what the samples see, and the depth.
    targets: [wgpu::Texture; 4],
    depth: wgpu::TextureView,
    /// The samples as points that receive light.
    pub points: Points,
    reflectance: wgpu::Buffer,
    emission: wgpu::Buffer,
    shade: Parametric,
    /// The picture.
    pub radiance: wgpu::Buffer,
    /// Its way back.
    pub back: Download,
}

impl FineTables {
    /// Uploads the fine mesh of `transfer`. The lights of its receivers are followed by those of the patches,
    /// which answer where a triangle's side has no receiver.
    pub fn new(gpu: &Gpu, scene: &Scene, patches: &Patches, transfer: &Transfer) -> Result<FineTables> {
        let fine = &transfer.fine;
        let pipeline = pipeline(gpu);
        let groups =
            textures::materials(gpu, &scene.materials, scene.mesh.one_sided, &pipeline.get_bind_group_layout(1))?;
        let material = |t: u32| scene.mesh.triangle_material[fine.source[t as usize] as usize];
        let mut order: Vec<u32> = (0..fine.triangle.len() as u32).collect();
        order.sort_by_key(|&t| material(t));
        let mut draws: Vec<(wgpu::BindGroup, std::ops::Range<u32>)> = Vec::new();
        for run in order.chunk_by(|&a, &b| material(a) == material(b)) {
            let from = draws.last().map_or(0, |(_, vertices)| vertices.end);
            let group = groups[material(run[0]) as usize].clone();
            draws.push((group, from..from + 3 * run.len() as u32));
        }
        let corners: Vec<Corner> = order.iter().flat_map(|&t| corners_of(scene, transfer, t as usize)).collect();
        let receivers: Vec<u32> = order.iter().flat_map(|&t| receivers_of(patches, transfer, t as usize)).collect();
        let (low, high) = bounds(&fine.vertex);
        Ok(FineTables {
            pipeline,
            shade: gpu.kernel("shade", kernels::SHADE),
            corners: gpu.geometry("fine mesh", &corners, wgpu::BufferUsages::VERTEX)?,
            receivers: gpu.storage("receivers of the fine mesh", &receivers, "bake with larger voxels")?,
            draws,
            near: 1e-5 * (high - low).length().max(1e-6),
        })
    }

    /// A canvas for pictures of `size` pixels; `detail` is the number of samples along a pixel's edge, `light` that of
    /// the receivers and patches.
    pub fn canvas(&self, gpu: &Gpu, size: [u32; 2], detail: u32, light: &wgpu::Buffer) -> Result<Canvas> {
        if self.draws.is_empty() {
            let what = "the bake has no fine mesh to be shown; it is written by `allbounce transfer`".into();
            return Err(Error::Shape { what });
        }
        let [columns, rows] = samples(gpu, size, detail)?;
        let extent = wgpu::Extent3d { width: columns, height: rows, depth_or_array_layers: 1 };
        let pitch = columns.next_multiple_of(ROW_PIXELS);
        let count = pitch as usize * rows as usize;
        let buffer = |what| gpu.vectors(what, count, SMALLER);
        let points = Points {
            position: buffer("positions of pixels")?,
            normal: buffer("normals of pixels")?,
            irradiance: buffer("light of pixels")?,
            count,
        };
        let (reflectance, emission) = (buffer("reflectance of pixels")?, buffer("emission of pixels")?);
        let pixels = size[0] as usize * size[1] as usize;
        let radiance = gpu.vectors("the picture", pixels, SMALLER)?;
        let params = gpu.uniform("shade", &ShadeParams::default());
        let buffers = [
            &params,
            &points.position,
            &points.normal,
            &reflectance,
            &emission,
            &self.receivers,
            light,
            &points.irradiance,
            &radiance,
        ];
        let shade = self.shade.prepare_each(gpu, &buffers.map(|b| b.as_entire_binding()), pixels);
        let camera = gpu.uniform("camera", &CameraUniform::default());
        Ok(Canvas {
            size,
            detail,
            pitch,
            view: gpu.bind(&self.pipeline.get_bind_group_layout(0), &[camera.as_entire_binding()]),
            camera,
            targets: std::array::from_fn(|_| target(gpu, extent, TARGET)),
            depth: target(gpu, extent, DEPTH).create_view(&Default::default()),
            points,
            reflectance,
            emission,
            shade: Parametric::new(params, shade),
            radiance,
            back: gpu.way_back(pixels),
        })
    }

    /// Draws what a camera sees; the points of the canvas are dark then.
    pub fn look(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, camera: &CameraUniform, canvas: &Canvas) {
        gpu.queue.write_buffer(&canvas.camera, 0, bytemuck::bytes_of(camera));
        self.draw(encoder, canvas);
        let points = &canvas.points;
        let buffers = [&points.position, &points.normal, &canvas.reflectance, &canvas.emission];
        for (texture, buffer) in canvas.targets.iter().zip(buffers) {
            let layout =
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * canvas.pitch), rows_per_image: None };
            let to = wgpu::TexelCopyBufferInfo { buffer, layout };
            encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
        }
        encoder.clear_buffer(&points.irradiance, 0, None);
    }

    fn draw(&self, encoder: &mut wgpu::CommandEncoder, canvas: &Canvas) {
        let views = canvas.targets.each_ref().map(|t| t.create_view(&Default::default()));
        let clear =
            wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
        let attach =
            |view| Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops: clear });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("surface"),
            color_attachments: &views.each_ref().map(attach),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &canvas.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &canvas.view, &[]);
        pass.set_vertex_buffer(0, self.corners.slice(..));
        for (material, vertices) in &self.draws {
            pass.set_bind_group(1, material, &[]);
            pass.draw(vertices.clone(), 0..1);
        }
    }

    /// A camera over a picture of `size` pixels; `origin` is the local origin in the camera's axes.
    pub fn camera(&self, camera: &Camera, origin: DVec3, size: [u32; 2]) -> Result<CameraUniform> {
        let bad = |what| Error::Input { what: format!("the camera {what}") };
        let eye = DVec3::from(camera.origin);
        let forward = (DVec3::from(camera.target) - eye).try_normalize().ok_or_else(|| bad("looks at its own eye"))?;
        let right = forward.cross(DVec3::from(camera.up)).try_normalize().ok_or_else(|| bad("looks along its up"))?;
        let tangent = (0.5 * camera.fov_x_deg.to_radians()).tan();
        if !(tangent > 0.0 && tangent.is_finite()) {
            return Err(bad("has a field of view outside 0 to 180 degrees"));
        }
        let tangents = [tangent, tangent * f64::from(size[1]) / f64::from(size[0])];
        let eye = eye - origin;
        let view = View::perspective(eye, [right, right.cross(forward), forward], tangents, self.near);
        Ok(CameraUniform { view, eye: vec4(eye.as_vec3().to_array(), 1.0) })
    }
}

impl Canvas {
    /// Whether it serves for pictures of `size` pixels.
    pub fn is_for(&self, size: [u32; 2]) -> bool {
        self.size == size
    }

    /// Radiance of every pixel, row by row from the top.
    pub fn shade(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, glow: bool, background: [f32; 3]) {
        let params = ShadeParams {
            width: self.size[0],
            height: self.size[1],
            pitch: self.pitch,
            detail: self.detail,
            glow: f32::from(u8::from(glow)),
            background: vec4(background, 0.0),
            ..Default::default()
        };
        self.shade.run(gpu, encoder, &params);
    }
}

/// Samples along the edges of a picture.
fn samples(gpu: &Gpu, [width, height]: [u32; 2], detail: u32) -> Result<[u32; 2]> {
    let limit = gpu.device.limits().max_texture_dimension_2d;
    let (columns, rows) = (u64::from(width) * u64::from(detail), u64::from(height) * u64::from(detail));
    if columns.max(rows) > u64::from(limit) || columns.min(rows) == 0 {
        return Err(Error::TooLarge {
            what: "the picture",
            need: format!("{columns} x {rows} samples"),
            adapter: gpu.adapter().to_string(),
            limit: format!("1 to {limit} along an edge"),
            rule: "maxTextureDimension2D",
            remedy: SMALLER,
        });
    }
    Ok([columns as u32, rows as u32])
}

/// Lower and upper corner of a cloud of points.
pub fn bounds(points: &[[f32; 3]]) -> (Vec3, Vec3) {
    points.iter().map(|&p| Vec3::from(p)).fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)))
}

/// The corners of a fine triangle with the texture coordinates of the triangle it was cut from.
fn corners_of(scene: &Scene, transfer: &Transfer, fine: usize) -> [Corner; 3] {
    let (mesh, source) = (&scene.mesh, transfer.fine.source[fine] as usize);
    let [a, b, c] = mesh.corners(source).map(|p| Vec3::from(p).as_dvec3());
    let normal = (b - a).cross(c - a);
    let square = normal.length_squared();
    let coordinates = |all: &[[f32; 2]], u: f64, v: f64| -> [f32; 2] {
        if all.is_empty() {
            return [0.0; 2];
        }
        let [a, b, c] = mesh.triangles[source].map(|i| all[i as usize].map(f64::from));
        std::array::from_fn(|k| (a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k])) as f32)
    };
    let own = if mesh.emission_uv.is_empty() { &mesh.uv } else { &mesh.emission_uv };
    transfer.fine.triangle[fine].map(|vertex| {
        let position = transfer.fine.vertex[vertex as usize];
        let p = Vec3::from(position).as_dvec3();
        let (u, v) = match square > 0.0 {
            true => ((p - a).cross(c - a).dot(normal) / square, (b - a).cross(p - a).dot(normal) / square),
            false => (0.0, 0.0),
        };
        Corner {
            position,
            normal: normal.normalize_or_zero().as_vec3().to_array(),
            uv: coordinates(&mesh.uv, u, v),
            emission_uv: coordinates(own, u, v),
        }
    })
}

/// Receivers of the front's corners and of the back's. Where a side has none at all, the patch in the middle of
/// the triangle takes their place; its light follows those of the receivers.
fn receivers_of(patches: &Patches, transfer: &Transfer, fine: usize) -> [u32; 6] {
    let mesh = &transfer.fine;
    let middle = mesh.triangle[fine].iter().map(|&v| Vec3::from(mesh.vertex[v as usize])).sum::<Vec3>() / 3.0;
    let side = |side: Side| {
        let own = mesh.receiver[fine][side as usize];
        if own != [NO_RECEIVER; 3] {
            return own;
        }
        let patch = patches.locator.patch_at(face_id(mesh.source[fine], side), middle.to_array());
        [patch.map_or(NO_RECEIVER, |p| transfer.receivers() as u32 + p); 3]
    };
    let ([a, b, c], [d, e, f]) = (side(Side::Front), side(Side::Back));
    [a, b, c, d, e, f]
}

fn target(gpu: &Gpu, size: wgpu::Extent3d, format: wgpu::TextureFormat) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("pixels"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn pipeline(gpu: &Gpu) -> wgpu::RenderPipeline {
    let module = gpu.shader("surface", kernels::SURFACE);
    let target = wgpu::ColorTargetState { format: TARGET, blend: None, write_mask: wgpu::ColorWrites::ALL };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("surface"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("surface"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Corner>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Float32x2],
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("seen"),
            compilation_options: Default::default(),
            targets: &std::array::from_fn::<_, 4, _>(|_| Some(target.clone())),
        }),
        multiview_mask: None,
        cache: None,
    })
}
