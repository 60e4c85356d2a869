//! The product on a GPU, or on a software driver.

use gpu_runtime::{Gpu, GpuRuntime, Packed, Params};
use radfile::{Rows, Transfer};

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
    let transfer = Transfer { rows: Rows { row_start: vec![0], ..Rows::default() }, ..Transfer::default() };
    let params = Params { patch_samples: 1, shadow_resolution: 4, emitter_samples: 1, ..Params::default() };
    let runtime = GpuRuntime::new(gpu, &case.mesh, &case.patches, packed, &case.factors.sky, &transfer, &params)?;
    Ok(runtime.time_product(&vec![[1.0; 3]; case.len()], REPEATS)?.milliseconds)
}
