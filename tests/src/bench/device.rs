//! The product on a GPU, or on a software driver.

use gpu_runtime::{Bake, Gpu, GpuRuntime, Packed, Params};
use radfile::{Elements, Rows, Transfer, Weights};

use super::case::{Case, Error};

/// Products that are timed.
const REPEATS: u32 = 50;

/// Median milliseconds of a product, by the device's own clock where it has one.
///
/// # Errors
///
/// If the operator does not fit the device, or the device fails.
pub fn milliseconds(gpu: &Gpu, case: &Case, packed: Packed) -> Result<f64, Error> {
    // Nobody looks at this bake: no receivers, the smallest shadow maps, one point a patch.
    let transfer = Transfer {
        weights: Weights::Interpolated(Rows { row_start: vec![0], ..Rows::default() }),
        ..Transfer::default()
    };
    let (scene, patches, sky) = (&case.mesh, &case.patches, &case.factors.sky[..]);
    let bake = Bake { scene, patches, elements: &Elements::whole(patches), sky, transfer: &transfer };
    let params = Params { patch_samples: 1, shadow_resolution: 4, emitter_samples: 1, ..Params::default() };
    let runtime = GpuRuntime::new(gpu, &bake, packed, &params)?;
    Ok(runtime.time_product(&vec![[1.0; 3]; case.len()], REPEATS)?.milliseconds)
}
