//! The kernels: where their source is, how they are bound and dispatched.
//!
//! Bindings of a compute kernel are numbered 0, 1, … in group 0, in the order of the shader.

use bytemuck::Pod;

use crate::Gpu;

/// Sources, joined with what they share.
pub const SHADOW_MAP: &str = concat!(
    include_str!("../../../shaders/view.wgsl"),
    include_str!("../../../shaders/lamp.wgsl"),
    include_str!("../../../shaders/shadow_map.wgsl")
);
pub const DIRECT: &str = concat!(
    include_str!("../../../shaders/view.wgsl"),
    include_str!("../../../shaders/lamp.wgsl"),
    include_str!("../../../shaders/direct.wgsl")
);
pub const ELEMENT_LIGHT: &str = include_str!("../../../shaders/element_light.wgsl");
pub const SENDERS: &str = include_str!("../../../shaders/senders.wgsl");
pub const RADIOSITY: &str = include_str!("../../../shaders/radiosity.wgsl");
pub const PRODUCT_SAMPLED: &str =
    concat!(include_str!("../../../shaders/product.wgsl"), include_str!("../../../shaders/codes_sampled.wgsl"));
pub const PRODUCT_STORED: &str =
    concat!(include_str!("../../../shaders/product.wgsl"), include_str!("../../../shaders/codes_stored.wgsl"));
pub const COLOUR_GATHER: &str =
    concat!(include_str!("../../../shaders/colour.wgsl"), include_str!("../../../shaders/colour_gather.wgsl"));
pub const COLOUR_CORE: &str =
    concat!(include_str!("../../../shaders/colour.wgsl"), include_str!("../../../shaders/colour_core.wgsl"));
pub const COLOUR_SCATTER: &str =
    concat!(include_str!("../../../shaders/colour.wgsl"), include_str!("../../../shaders/colour_scatter.wgsl"));
pub const HMATRIX_GATHER: &str = include_str!("../../../shaders/hmatrix_gather.wgsl");
pub const HMATRIX_EXCHANGE: &str = include_str!("../../../shaders/hmatrix_exchange.wgsl");
pub const HMATRIX_SCATTER: &str = include_str!("../../../shaders/hmatrix_scatter.wgsl");
pub const GATHER: &str = include_str!("../../../shaders/gather.wgsl");
pub const SURFACE: &str =
    concat!(include_str!("../../../shaders/view.wgsl"), include_str!("../../../shaders/surface.wgsl"));
pub const SHADE: &str = include_str!("../../../shaders/shade.wgsl");

/// Invocations of every workgroup where kernels run for each of some items.
const GROUP: usize = 64;

/// A compute kernel.
pub struct Kernel {
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
}

/// A kernel with what it works on, to be run again and again.
pub struct Dispatch {
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
    bindings: wgpu::BindGroup,
    groups: (u32, u32),
}

/// A dispatch with parameters of its own, which may change from one submission to the next.
pub struct Parametric {
    uniform: wgpu::Buffer,
    dispatch: Dispatch,
}

impl Gpu {
    /// Compiles a compute kernel; `name` is its entry point.
    pub(crate) fn kernel(&self, name: &'static str, source: &str) -> Kernel {
        let module = self.shader(name, source);
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: None,
            module: &module,
            entry_point: Some(name),
            compilation_options: Default::default(),
            cache: None,
        });
        Kernel { name, pipeline }
    }

    /// Compiles a shader module.
    pub(crate) fn shader(&self, name: &str, source: &str) -> wgpu::ShaderModule {
        let source = wgpu::ShaderSource::Wgsl(source.into());
        self.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(name), source })
    }

    /// A bind group whose entries are numbered in order.
    pub(crate) fn bind(&self, layout: &wgpu::BindGroupLayout, resources: &[wgpu::BindingResource]) -> wgpu::BindGroup {
        let entries: Vec<wgpu::BindGroupEntry> = resources
            .iter()
            .enumerate()
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding: binding as u32, resource: resource.clone() })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }
}

impl Kernel {
    /// Binds `resources` for runs of one invocation for each of `count` items.
    pub fn prepare_each(&self, gpu: &Gpu, resources: &[wgpu::BindingResource], count: usize) -> Dispatch {
        self.prepare(gpu, resources, count.div_ceil(GROUP))
    }

    /// Binds `resources` for runs of `groups` workgroups.
    pub fn prepare(&self, gpu: &Gpu, resources: &[wgpu::BindingResource], groups: usize) -> Dispatch {
        Dispatch {
            name: self.name,
            pipeline: self.pipeline.clone(),
            bindings: gpu.bind(&self.pipeline.get_bind_group_layout(0), resources),
            groups: grid(groups as u64, u64::from(gpu.device.limits().max_compute_workgroups_per_dimension)),
        }
    }

    /// Runs one invocation for each of `count` items.
    pub fn each(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        resources: &[wgpu::BindingResource],
        count: usize,
    ) {
        self.prepare_each(gpu, resources, count).run(encoder);
    }
}

impl Dispatch {
    /// Runs the kernel.
    pub fn run(&self, encoder: &mut wgpu::CommandEncoder) {
        run(encoder, self.name, std::slice::from_ref(self));
    }
}

/// Runs kernels one after the other in one pass.
pub fn run(encoder: &mut wgpu::CommandEncoder, name: &str, dispatches: &[Dispatch]) {
    let mut pass =
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes: None });
    for dispatch in dispatches {
        pass.set_pipeline(&dispatch.pipeline);
        pass.set_bind_group(0, &dispatch.bindings, &[]);
        pass.dispatch_workgroups(dispatch.groups.0, dispatch.groups.1, 1);
    }
}

impl Parametric {
    /// Of a `uniform` that `dispatch` binds.
    pub fn new(uniform: wgpu::Buffer, dispatch: Dispatch) -> Parametric {
        Parametric { uniform, dispatch }
    }

    /// Runs the kernel; at most once in a submission, for there is one set of parameters.
    pub fn run<P: Pod>(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, params: &P) {
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(params));
        self.dispatch.run(encoder);
    }
}

/// The smallest x × y ≥ `groups` with x ≤ `limit` and the fewest rows.
fn grid(groups: u64, limit: u64) -> (u32, u32) {
    let rows = groups.div_ceil(limit).max(1);
    (groups.div_ceil(rows) as u32, rows as u32)
}

#[cfg(test)]
mod tests {
    use std::mem::{offset_of, size_of};

    use naga::valid::{Capabilities, ValidationFlags, Validator};

    use super::*;
    use crate::{
        colour::{Column, Member},
        gather::GatherParams,
        hierarchical::{Panel, ScatterParams, Term},
        lamp::Lamp,
        operator::ProductParams,
        patch_tables::ElementLightParams,
        picture::{CameraUniform, MaterialUniform, ShadeParams},
        view::View,
    };

    const ALL: [(&str, &str); 16] = [
        ("shadow_map", SHADOW_MAP),
        ("direct", DIRECT),
        ("element_light", ELEMENT_LIGHT),
        ("senders", SENDERS),
        ("radiosity", RADIOSITY),
        ("product sampled", PRODUCT_SAMPLED),
        ("product stored", PRODUCT_STORED),
        ("colour_gather", COLOUR_GATHER),
        ("colour_core", COLOUR_CORE),
        ("colour_scatter", COLOUR_SCATTER),
        ("hmatrix_gather", HMATRIX_GATHER),
        ("hmatrix_exchange", HMATRIX_EXCHANGE),
        ("hmatrix_scatter", HMATRIX_SCATTER),
        ("gather", GATHER),
        ("surface", SURFACE),
        ("shade", SHADE),
    ];

    fn parse(source: &str) -> naga::Module {
        naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)))
    }

    /// Size of a struct of a shader, and the names and offsets of its members.
    fn layout(source: &str, name: &str) -> (usize, Vec<(String, usize)>) {
        let module = parse(source);
        let found = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name)).expect("a struct of that name");
        let naga::TypeInner::Struct { members, span } = &found.1.inner else { panic!("{name} is no struct") };
        let member = |m: &naga::StructMember| (m.name.clone().unwrap_or_default(), m.offset as usize);
        (*span as usize, members.iter().map(member).collect())
    }

    macro_rules! same_layout {
        ($source:expr, $name:literal, $host:ty, [$($member:ident),* $(,)?]) => {
            let (size, members) = layout($source, $name);
            assert_eq!(size, size_of::<$host>(), $name);
            assert_eq!(members, [$((stringify!($member).to_owned(), offset_of!($host, $member))),*], $name);
        };
    }

    #[test]
    fn every_shader_is_valid() {
        for (name, source) in ALL {
            let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
            validator.validate(&parse(source)).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(source)));
        }
    }

    #[test]
    fn every_shader_file_is_used_and_says_what_it_does() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders");
        let mut files = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let source = std::fs::read_to_string(&path).unwrap();
            assert!(ALL.iter().any(|(_, all)| all.contains(&source)), "{path:?} is used by no kernel");
            for head in ["// twin ", "// units "] {
                assert!(source.contains(head), "{path:?} lacks the line {head:?} in its head");
            }
            files += 1;
        }
        assert_eq!(files, 20);
    }

    #[test]
    fn views_and_lamps_match_their_host_structs() {
        same_layout!(DIRECT, "View", View, [right, up, forward, reach, perspective, unused_a, unused_b]);
        same_layout!(
            DIRECT,
            "Lamp",
            Lamp,
            [views, position, kind, axis, view_count, colour, resolution, half_angle, penumbra, area, unused]
        );
    }

    #[test]
    fn parameters_of_kernels_match_their_host_structs() {
        same_layout!(ELEMENT_LIGHT, "ElementLightParams", ElementLightParams, [sky]);
        for source in [PRODUCT_SAMPLED, PRODUCT_STORED] {
            same_layout!(
                source,
                "ProductParams",
                ProductParams,
                [patch_count, tile, tiles, planes, channels, logarithmic, shift, bc1, scale, half, wide, high, unused]
            );
        }
        same_layout!(COLOUR_GATHER, "Column", Column, [codes, members, count, first, rank, core]);
        same_layout!(COLOUR_GATHER, "Member", Member, [patch_number, scale, first]);
        same_layout!(HMATRIX_GATHER, "Panel", Panel, [codes, place, len, sums]);
        same_layout!(HMATRIX_EXCHANGE, "Term", Term, [factor, source]);
        same_layout!(HMATRIX_SCATTER, "ScatterParams", ScatterParams, [parts, runs, unused_a, unused_b, sky]);
        same_layout!(GATHER, "GatherParams", GatherParams, [receivers, share, unused_a, unused_b, sky]);
        same_layout!(SURFACE, "Camera", CameraUniform, [view, eye]);
        same_layout!(SURFACE, "Material", MaterialUniform, [reflectance, emission]);
        same_layout!(
            SHADE,
            "ShadeParams",
            ShadeParams,
            [width, height, pitch, detail, glow, unused_a, unused_b, unused_c, background]
        );
    }

    #[test]
    fn the_shaders_clamp_reflectance_where_the_surfaces_do() {
        assert!(SURFACE.contains(&format!("const MAX_REFLECTANCE = {};", scene::MAX_REFLECTANCE)));
    }

    #[test]
    fn grids_cover_all_groups_within_the_limit() {
        for (groups, limit) in [(0, 65535), (1, 65535), (65535, 65535), (65536, 65535), (1_000_000, 65535), (7, 3)] {
            let (x, y) = grid(groups, limit);
            let (x, y) = (u64::from(x), u64::from(y));
            assert!(x <= limit && x * y >= groups && x * y < groups + y, "{groups} groups: {x} x {y}");
        }
    }
}
