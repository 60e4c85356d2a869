//! The GPU backend of `relight` and `render`; without the `gpu` feature it says so.

use radfile::PointRows;
use relight::{Image, Operator, Parts, PointLight};
use scene::{Camera, LightRig, SurfacePoint};

use crate::runtime::Bake;

/// Irradiance at points by way of the GPU, and the adapter that computed it. Without `rows` they are the bake's receivers.
///
/// With `bounces` the packed operator would not be asked, so the GPU has no part in it.
#[cfg(feature = "gpu")]
pub fn relight(
    bounces: Option<u32>,
    bake: &Bake,
    operator: &Operator,
    rig: &LightRig,
    points: &[SurfacePoint],
    rows: Option<&PointRows>,
) -> anyhow::Result<(PointLight, String)> {
    if bounces.is_some() {
        anyhow::bail!("--bounces is computed from form factors on the CPU; use --backend cpu");
    }
    let runtime = runtime(bake, operator)?;
    let position: Vec<[f32; 3]> = points.iter().map(|p| p.position.to_array()).collect();
    let normal: Vec<[f32; 3]> = points.iter().map(|p| p.normal.to_array()).collect();
    let light = match rows {
        Some(rows) => runtime.relight_points(rig, &position, &normal, rows)?,
        None => runtime.relight_receivers(rig, &bake.transfer)?,
    };
    Ok((PointLight { direct: light.direct, indirect: light.indirect }, runtime.report().adapter.clone()))
}

/// A picture by way of the GPU, and the adapter that computed it.
#[cfg(feature = "gpu")]
pub fn render(
    bake: &Bake,
    operator: &Operator,
    rig: &LightRig,
    camera: &Camera,
    [width, height]: [usize; 2],
    parts: Parts,
) -> anyhow::Result<(Image, String)> {
    let runtime = runtime(bake, operator)?;
    let parts = gpu_runtime::Parts { direct: parts != Parts::IndirectOnly, indirect: parts != Parts::DirectOnly };
    let pixels = runtime.render(rig, camera, width as u32, height as u32, parts)?;
    Ok((Image { width, height, pixels }, runtime.report().adapter.clone()))
}

#[cfg(feature = "gpu")]
fn runtime(bake: &Bake, operator: &Operator) -> anyhow::Result<gpu_runtime::GpuRuntime> {
    use radfile::Kernel::OneBounce;
    let packed = match operator {
        Operator::Textures(product) => gpu_runtime::Packed::Textures(product.packed()),
        Operator::Hierarchical(_, certificate) if certificate.kernel == OneBounce => {
            anyhow::bail!("the bake holds one bounce, which is solved on the CPU; use --backend cpu")
        }
        Operator::Hierarchical(matrix, _) => gpu_runtime::Packed::Hierarchical(matrix),
    };
    let (gpu, params) = (gpu_runtime::Gpu::new()?, gpu_runtime::Params::default());
    let Bake { scene, patches, elements, transfer, .. } = bake;
    let parts = gpu_runtime::Bake { scene, patches, elements, sky: bake.sky()?, transfer };
    Ok(gpu_runtime::GpuRuntime::new(&gpu, &parts, packed, &params)?)
}

#[cfg(not(feature = "gpu"))]
const ABSENT: &str = "this program was built without the gpu feature; use --backend cpu";

#[cfg(not(feature = "gpu"))]
pub fn relight(
    _bounces: Option<u32>,
    _bake: &Bake,
    _operator: &Operator,
    _rig: &LightRig,
    _points: &[SurfacePoint],
    _rows: Option<&PointRows>,
) -> anyhow::Result<(PointLight, String)> {
    anyhow::bail!(ABSENT)
}

#[cfg(not(feature = "gpu"))]
pub fn render(
    _bake: &Bake,
    _operator: &Operator,
    _rig: &LightRig,
    _camera: &Camera,
    _size: [usize; 2],
    _parts: Parts,
) -> anyhow::Result<(Image, String)> {
    anyhow::bail!(ABSENT)
}
