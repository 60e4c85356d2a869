//! Packs an operator.

use probes::probe_lights;
use radfile::{BlockFormat, Operator, PackedOperator, Packing, Patches, Progress};
use rayon::prelude::*;

use crate::{Error, Params, Report, Result, blocks, measure, split::Split};

/// Packs `operator` and measures what that costs.
///
/// The entries above the (1 − `outliers`) quantile of their channel are kept apart; the largest of
/// the others is the scale of the channel. Blocks are fitted to the others alone, and an outlier
/// stores what is missing from whatever its texel decodes to.
///
/// # Errors
///
/// [`Error::Option`], [`Error::Empty`], [`Error::PatchCount`], [`Error::Value`],
/// [`Error::TooManyOutliers`].
///
/// # Panics
///
/// If `operator.values` is not channels × n × n or channels is neither 1 nor 3: a bug in the caller.
pub fn pack(
    operator: &Operator,
    patches: &Patches,
    params: &Params,
    progress: &dyn Progress,
) -> Result<(PackedOperator<'static>, Report)> {
    params.check()?;
    check(operator, patches)?;
    progress.begin("finding outliers", 1);
    let split = Split::new(operator, params.outliers)?;
    progress.advance(1);
    let mut scale = split.scale;
    if operator.channels == 1 {
        scale = [scale[0]; 3];
    }
    let (tile, tiles) = Packing::tiling(operator.n as u32);
    let packing = Packing {
        n: operator.n as u32,
        channels: operator.channels as u32,
        bounces: operator.bounces,
        format: params.format,
        map: params.value_map(),
        scale,
        tile,
        tiles,
    };
    let blocks = blocks::encode(&split, &patches.area, &packing, progress);
    let mut packed = PackedOperator {
        packing,
        blocks: blocks.into(),
        outlier_start: split.start.into(),
        outlier_column: split.column.into(),
        outlier_value: Vec::new().into(),
        half: None,
    };
    packed.outlier_value = remainders(operator, &packed).into();
    let lights = probe_lights(patches, params.probes, params.seed);
    let errors = (params.probes > 0).then(|| measure(operator, &packed, patches, &lights, progress));
    let report = Report::new(&packed, errors);
    Ok((packed, report))
}

/// Bytes that [`pack`] allocates for its result.
pub fn memory_needed(n: usize, channels: usize, params: &Params) -> u64 {
    let (tile, tiles) = Packing::tiling(n as u32);
    let texels = (u64::from(tile) * u64::from(tiles)).pow(2);
    let planes = if params.format == BlockFormat::Bc1 { 1 } else { channels as u64 };
    // Channels may disagree about every outlier.
    let share = (params.outliers * channels as f64).min(1.0);
    let outliers = (share * (n * n) as f64).ceil() as u64;
    planes * texels / 2 + outliers * (4 + 4 * channels as u64) + 4 * (n as u64 + 1)
}

fn check(operator: &Operator, patches: &Patches) -> Result<()> {
    let n = operator.n;
    assert!(matches!(operator.channels, 1 | 3), "an operator has 1 or 3 channels, not {}", operator.channels);
    assert_eq!(operator.values.len(), operator.channels * n * n, "values of the operator");
    if n == 0 {
        return Err(Error::Empty);
    }
    if patches.len() != n {
        return Err(Error::PatchCount { operator: n, patches: patches.len() });
    }
    match operator.values.par_iter().position_first(|v| !(v.is_finite() && *v >= 0.0)) {
        Some(at) => Err(Error::Value {
            channel: at / (n * n),
            receiver: at / n % n,
            sender: at % n,
            value: operator.values[at],
        }),
        None => Ok(()),
    }
}

/// What is missing at every outlier from what its texel decodes to.
fn remainders(operator: &Operator, packed: &PackedOperator) -> Vec<f32> {
    let n = operator.n;
    let row = |row: usize| {
        let entries = packed.outlier_start[row] as usize..packed.outlier_start[row + 1] as usize;
        packed.outlier_column[entries].iter().flat_map(move |&column| {
            let column = column as usize;
            (0..operator.channels).map(move |c| operator.channel(c)[row * n + column] - packed.texel(c, row, column))
        })
    };
    let rows: Vec<Vec<f32>> = (0..n).into_par_iter().map(|i| row(i).collect()).collect();
    rows.concat()
}
