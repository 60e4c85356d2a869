//! Packs an operator.

use probes::probe_lights;
use radfile::{BlockFormat, Colour, Operator, PackedOperator, Packing, Patches, Progress, rounded, unit_of};
use rayon::prelude::*;

use crate::{
    Error, Outliers, Params, Report, Result,
    blocks::{encode_half, encode_whole},
    choose::{COLUMNS, SHARES, Trial, cheapest},
    colour::{self, Basis},
    luma, measure,
    split::Split,
};

/// Share of outliers of the whole matrix: the knee that the paper's format has.
const KNEE: f64 = 0.01;

/// Packs `operator` and measures what that costs.
///
/// The entries above the (1 − `outliers`) quantile of their channel are kept apart; the largest of
/// the others is the scale of the channel. Blocks are fitted to the others alone, and an outlier
/// stores what is missing from whatever its texel decodes to. BC1 holds all of the matrix; BC4 holds the half of luma
/// below the diagonal, with colour apart, so the operator must be symmetric, as K is.
///
/// # Errors
///
/// [`Error::Option`], [`Error::TooManyOutliers`], [`Error::TooManyPatches`], and [`Error::Container`] if the operator
/// breaks a rule ([`Operator::check`]).
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
    operator.check(patches.len())?;
    let packed = match params.format {
        BlockFormat::Bc1 => whole(operator, params, progress)?,
        BlockFormat::Bc4 => half(operator, patches, params, progress)?,
    };
    let lights = probe_lights(patches, params.probes, params.seed);
    let errors = (params.probes > 0).then(|| measure(operator, &packed, patches, &lights, progress));
    let report = Report::new(&packed, errors);
    Ok((packed, report))
}

/// Bytes that [`pack`] allocates, most of them for its result and for luma.
pub fn memory_needed(n: usize, channels: usize, params: &Params) -> u64 {
    let entries = (n as u64).pow(2);
    let share = match params.outliers {
        Outliers::Share(share) => share,
        Outliers::Auto => KNEE,
    };
    let index = 4 * (n as u64 + 1);
    match params.format {
        BlockFormat::Bc1 => {
            let (tile, tiles) = Packing::tiling(n as u32);
            let texels = (u64::from(tile) * u64::from(tiles)).pow(2);
            // Channels may disagree about every outlier.
            let outliers = ((share * channels as f64).min(1.0) * entries as f64).ceil() as u64;
            texels / 2 + outliers * (4 + 4 * channels as u64) + index
        }
        BlockFormat::Bc4 => {
            let colour = if channels == 1 { 0 } else { 4 * entries + colour::memory_needed(n) };
            // The matrix is decoded whole to try a share of outliers, and what each share gives is kept.
            let shares = if params.outliers == Outliers::Auto { 3 } else { 1 };
            let texture = entries / 4 + (share * entries as f64).ceil() as u64 * 4;
            shares * texture + index + colour + 4 * entries
        }
    }
}

/// All of the matrix as the paper has it.
fn whole(operator: &Operator, params: &Params, progress: &dyn Progress) -> Result<PackedOperator<'static>> {
    let share = match params.outliers {
        Outliers::Auto => KNEE,
        Outliers::Share(share) => share,
    };
    progress.begin("finding outliers", 1);
    let split = Split::new(operator, share, false)?;
    progress.advance(1);
    let packing = packing(operator, params, split.scale);
    let mut packed = PackedOperator {
        blocks: encode_whole(&split, &packing, progress).into(),
        packing,
        outlier_start: split.start.into(),
        outlier_column: split.column.into(),
        outlier_value: Vec::new().into(),
        half: None,
    };
    packed.outlier_value = remainders(operator, &packed).into();
    Ok(packed)
}

/// Half of luma, and colour.
fn half(
    operator: &Operator,
    patches: &Patches,
    params: &Params,
    progress: &dyn Progress,
) -> Result<PackedOperator<'static>> {
    if operator.n > radfile::MOST_PATCHES as usize {
        return Err(Error::TooManyPatches { patches: operator.n });
    }
    let luma = luma::of_operator(operator);
    let basis = Basis::new(operator, patches, luma::axes(operator), progress);
    let shares = match params.outliers {
        Outliers::Auto => SHARES.to_vec(),
        Outliers::Share(share) => vec![share],
    };
    progress.begin("trying light", 1);
    let trial = Trial::new(operator, &luma, patches);
    progress.advance(1);
    let (mut textures, mut of_luma) = (Vec::new(), Vec::new());
    for share in shares {
        let packed = half_of_luma(&luma, patches, params, share, progress)?;
        of_luma.push((packed.size_in_bytes(), trial.of_luma(&packed)));
        textures.push(packed);
    }
    let colours = colours(&basis);
    let of_colour: Vec<(usize, f64)> =
        colours.iter().map(|colour| (colour.size_in_bytes(), trial.of_colour(colour))).collect();
    let (texture, colour) = cheapest(&of_luma, &of_colour, params.error);
    let mut packed = textures.swap_remove(texture);
    packed.packing.channels = operator.channels as u32;
    packed.half = Some(colours[colour].clone());
    Ok(packed)
}

/// What there is to choose from; of a grey operator nothing but grey.
fn colours(basis: &Basis) -> Vec<Colour<'static>> {
    let held = basis.held();
    match held.len() {
        0 => vec![Colour::default()],
        // Colour of less than the fewest columns is kept whole.
        all => {
            let most = COLUMNS[COLUMNS.len() - 1];
            let counts = COLUMNS.iter().copied().filter(|&count| count < all).chain((all <= most).then_some(all));
            counts.map(|count| basis.colour(held[count - 1])).collect()
        }
    }
}

/// Texture and outliers of luma.
fn half_of_luma(
    luma: &Operator,
    patches: &Patches,
    params: &Params,
    share: f64,
    progress: &dyn Progress,
) -> Result<PackedOperator<'static>> {
    let root_area: Vec<f32> = patches.area.iter().map(|a| a.sqrt()).collect();
    let split = Split::new(luma, share, true)?;
    let packing = packing(luma, params, split.scale);
    let mut packed = PackedOperator {
        blocks: encode_half(&split, &root_area, &packing, progress).into(),
        packing,
        outlier_start: split.start.into(),
        outlier_column: split.column.into(),
        outlier_value: Vec::new().into(),
        half: Some(Colour::default()),
    };
    let mut values = remainders(luma, &packed);
    let unit = unit_of(&values);
    values.iter_mut().for_each(|v| *v = rounded(*v, unit));
    packed.outlier_value = values.into();
    Ok(packed)
}

fn packing(operator: &Operator, params: &Params, scale: [f32; 3]) -> Packing {
    let (tile, tiles) = Packing::tiling(operator.n as u32);
    Packing {
        n: operator.n as u32,
        channels: operator.channels as u32,
        bounces: operator.bounces,
        format: params.format,
        map: params.value_map(),
        scale: if operator.channels == 1 { [scale[0]; 3] } else { scale },
        tile,
        tiles,
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
