//! How well the hardware decodes an operator's blocks.
//!
//! Block formats leave the rounding of mixtures to the hardware. Real devices are good to a fraction of
//! 1/255, software ones may mix with few bits and always round down; through the logarithm that becomes
//! several thousandths of the light, in every bounce the same way. So before a texture is trusted, a
//! sample of the operator's own blocks is multiplied with uniform light on the device and here. Nothing
//! is corrected by it: a sampler that fails is not used.

use radfile::{PackedOperator, Packing};

use crate::{Gpu, Result, buffers::vec4, kernels, operator::Operator};

/// Blocks along the edge of the sample.
const EDGE: usize = 64;
/// Largest relative error of the light that a sampler may cause: a fifth of what the two backends may differ by.
pub const GOOD: f64 = 1e-3;

/// Relative error of the sampler's product for uniform light, the largest of the channels, with its sign.
pub fn sampler_bias(gpu: &Gpu, packed: &PackedOperator) -> Result<f64> {
    let sample = sample(packed);
    let n = sample.packing.n as usize;
    let operator = Operator::new(gpu, &sample, true)?;
    let ones = vec![vec4([1.0; 3], 1.0); n];
    let (unit, x) = (gpu.storage("probe", &ones, "")?, gpu.storage("probe light", &ones, "")?);
    let h = gpu.vectors("probe result", n, "")?;
    let mut encoder = gpu.encoder();
    kernels::run(&mut encoder, "probe", &operator.prepare(gpu, &unit, &x, &h));
    let download = gpu.download(&mut encoder, &h, n);
    let [rows] = gpu.finish(encoder, [download])?;
    let bias = |channel: usize| {
        let exact: f64 = sample.decode(channel).iter().map(|&v| f64::from(v)).sum();
        let found: f64 = rows.iter().map(|r| f64::from(r[channel])).sum();
        if exact > 0.0 { found / exact - 1.0 } else { found }
    };
    Ok((0..3).map(bias).max_by(|a, b| a.abs().total_cmp(&b.abs())).expect("three channels"))
}

/// An operator of blocks taken from all over another one, without outliers.
fn sample(packed: &PackedOperator) -> PackedOperator<'static> {
    let p = &packed.packing;
    let blocks = (p.n as usize).div_ceil(4);
    let edge = blocks.min(EDGE);
    let (tile, tiles) = Packing::tiling(4 * edge as u32);
    let channels = if packed.half.is_some() { 1 } else { p.channels };
    let packing = Packing { n: 4 * edge as u32, channels, tile, tiles, ..p.clone() };
    let mut bytes = Vec::with_capacity(packing.planes() * edge * edge * 8);
    for plane in 0..packing.planes() {
        for k in 0..edge * edge {
            let at = if packed.half.is_some() {
                // Half has no rows to step over.
                8 * (k * (packed.blocks.len() / 8) / (edge * edge))
            } else {
                let [row, column] = [k / edge, k % edge].map(|i| 4 * (i * blocks / edge));
                p.block_offset(plane, row, column)
            };
            bytes.extend_from_slice(&packed.blocks[at..at + 8]);
        }
    }
    PackedOperator {
        half: None,
        outlier_start: vec![0; packing.n as usize + 1].into(),
        outlier_column: vec![].into(),
        outlier_value: vec![].into(),
        blocks: bytes.into(),
        packing,
    }
}
