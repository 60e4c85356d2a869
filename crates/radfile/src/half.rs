//! The second form of the packed operator: half of a symmetric matrix of luma, and colour apart.
//!
//! K is symmetric, so one texture of the blocks on and below the diagonal holds luma K_Y = Σ w_c K_c, and an outlier
//! stands for its mirror image too. What luma leaves of the channels is K_c − K_Y = Σ_p e_pc P_p with one or two
//! symmetric planes P_p, each of low rank: P_p ≈ U C_p Uᵀ with one U for all planes. Patches that exchange no light
//! at all, however many times it is reflected, lie in different components; each has an U and cores of its own, so no
//! colour passes between sealed rooms.

use std::borrow::Cow;

use ::half::f16;
use serde::{Deserialize, Serialize};

use crate::{
    BlockFormat, Builder, Container, Error, FLAG_PATCH_ORDER, FLAG_REQUIRED, PackedOperator, Packing, Result, ValueMap,
    patches::check_offsets, record::check_patch_count,
};

/// The component of patches that have no colour.
pub const NO_COMPONENT: u16 = u16::MAX;
/// Columns of outliers are 16 bits wide.
pub const MOST_PATCHES: u32 = 1 << 16;
/// Full scale of a code of U.
const FULL: f32 = 127.0;
/// Products of larger numbers would be none.
const LARGEST_UNIT: f32 = 1e9;
const NAME: &str = "packed operator";
const FLAGS: u32 = FLAG_REQUIRED | FLAG_PATCH_ORDER;

/// The colour of an operator of which half is stored; a grey one has no planes, and nothing else either.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Colour<'a> {
    /// Share of each plane in red, green and blue; up to two planes.
    pub axes: Vec<[f32; 3]>,
    /// Component of each patch, or [`NO_COMPONENT`].
    pub component: Cow<'a, [u16]>,
    /// Columns of U in each component, no more than it has patches.
    pub rank: Vec<u32>,
    /// What a code of 127 is worth in each row of U. Written as f16, in units of the largest.
    pub scale: Cow<'a, [f32]>,
    /// U: two's complement, component after component, column after column, rows in the order of patches.
    pub codes: Cow<'a, [u8]>,
    /// Lower halves of the cores, planes × entries; component after component, row after row. Written as f16, in
    /// units of the largest.
    pub core: Cow<'a, [f32]>,
}

/// The colour of one component, unpacked.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourBlock {
    /// Its patches, increasing.
    pub patches: Vec<u32>,
    /// Columns of U.
    pub rank: usize,
    /// U, patches × rank, row after row.
    pub basis: Vec<f32>,
    /// Σ_p e_pc C_p for red, green and blue; rank × rank.
    pub core: [Vec<f32>; 3],
}

impl ColourBlock {
    /// Adds U C Uᵀ of a channel to a row of the matrix, summed in f64.
    pub(crate) fn add(&self, channel: usize, row: usize, out: &mut [f32]) {
        let Ok(own) = self.patches.binary_search(&(row as u32)) else { return };
        let (rank, core) = (self.rank, &self.core[channel]);
        let of_row = |i: usize| self.basis[i * rank..][..rank].iter().map(|&u| f64::from(u));
        let product = |k: usize| of_row(own).zip(&core[k * rank..]).map(|(u, &c)| u * f64::from(c)).sum();
        let carried: Vec<f64> = (0..rank).map(product).collect();
        for (i, &patch) in self.patches.iter().enumerate() {
            let colour: f64 = of_row(i).zip(&carried).map(|(u, c)| u * c).sum();
            let to = &mut out[patch as usize];
            *to = (f64::from(*to) + colour) as f32;
        }
    }
}

impl Colour<'_> {
    /// Patches of each component.
    fn members(&self) -> Vec<Vec<u32>> {
        let mut members = vec![Vec::new(); self.rank.len()];
        for (patch, &component) in self.component.iter().enumerate() {
            if let Some(members) = members.get_mut(usize::from(component)) {
                members.push(patch as u32);
            }
        }
        members
    }

    /// The colour of every component.
    pub fn blocks(&self) -> Vec<ColourBlock> {
        let (mut code, mut entry) = (0, 0);
        let of_component = |(patches, &rank): (Vec<u32>, &u32)| {
            let rank = rank as usize;
            let codes = &self.codes[code..code + rank * patches.len()];
            let value = |row: usize, column: usize| {
                f32::from(codes[column * patches.len() + row].cast_signed()) / FULL * self.scale[patches[row] as usize]
            };
            let basis = (0..patches.len()).flat_map(|row| (0..rank).map(move |column| (row, column)));
            let core = [0, 1, 2].map(|c| self.core_of(c, entry, rank));
            let block = ColourBlock { rank, basis: basis.map(|(i, k)| value(i, k)).collect(), core, patches };
            (code, entry) = (code + codes.len(), entry + rank * (rank + 1) / 2);
            block
        };
        self.members().into_iter().zip(&self.rank).map(of_component).collect()
    }

    /// The core of a component in a channel; its entries start at `entry` in every plane.
    fn core_of(&self, channel: usize, entry: usize, rank: usize) -> Vec<f32> {
        let of_plane = self.core.len() / self.axes.len().max(1);
        let at = |i: usize, k: usize| entry + i.max(k) * (i.max(k) + 1) / 2 + i.min(k);
        let value = |i: usize, k: usize| {
            let planes = self.axes.iter().enumerate();
            planes.map(|(plane, axis)| axis[channel] * self.core[plane * of_plane + at(i, k)]).sum()
        };
        (0..rank * rank).map(|at| value(at / rank, at % rank)).collect()
    }

    /// Bytes that the colour takes in a file.
    pub fn size_in_bytes(&self) -> usize {
        12 * self.axes.len()
            + 4 * self.rank.len()
            + 2 * (self.component.len() + self.scale.len() + self.core.len())
            + self.codes.len()
    }

    fn check(&self, n: usize) -> Result<()> {
        let refuse = |what: String| Err(Error::invariant(NAME, what));
        if self.axes.len() > 2 || !self.axes.iter().flatten().all(|e| (-1.0..=1.0).contains(e)) {
            return refuse(format!("axes of colour {:?}, expected up to two of numbers -1..1", self.axes));
        }
        let grey = self.axes.is_empty();
        if grey && *self != Colour::default() {
            return refuse("a grey operator has components of colour".into());
        }
        let expected = if grey { 0 } else { n };
        if (self.component.len(), self.scale.len()) != (expected, expected) {
            let found = (self.component.len(), self.scale.len());
            return refuse(format!("colour of {found:?} patches, expected {expected}"));
        }
        let components = self.rank.len();
        if let Some(patch) = self.component.iter().position(|&c| c != NO_COMPONENT && usize::from(c) >= components) {
            return refuse(format!("patch {patch} is in component {} of {components}", self.component[patch]));
        }
        let (mut codes, mut entries) = (0u64, 0u64);
        for (component, (members, &rank)) in self.members().iter().zip(&self.rank).enumerate() {
            if !(1..=members.len()).contains(&(rank as usize)) {
                let (least, most) = (1, members.len());
                return refuse(format!(
                    "component {component} has {rank} columns, expected {least} to {most}, its patches"
                ));
            }
            codes += members.len() as u64 * u64::from(rank);
            entries += u64::from(rank) * (u64::from(rank) + 1) / 2;
        }
        let found = (self.codes.len() as u64, self.core.len() as u64);
        if found != (codes, self.axes.len() as u64 * entries) {
            return refuse(format!("{found:?} codes and entries of cores, expected ({codes}, {entries} a plane)"));
        }
        match self.scale.iter().chain(&self.core[..]).position(|v| !v.is_finite()) {
            Some(at) => refuse(format!("number {at} of the colour is not finite")),
            None => Ok(()),
        }
    }
}

/// The metadata of this form.
#[derive(Serialize, Deserialize)]
struct Meta {
    n: u32,
    channels: u32,
    bounces: Option<u32>,
    map: ValueMap,
    scale: f32,
    outlier_unit: f32,
    axes: Vec<[f32; 3]>,
    rank: Vec<u32>,
    scale_unit: f32,
    core_unit: f32,
}

/// Blocks on and below the diagonal of a matrix of `n` patches.
pub fn half_blocks(n: u32) -> usize {
    let edge = n.div_ceil(4) as usize;
    edge * (edge + 1) / 2
}

/// First byte of the block that holds texel (row, column), which must not lie in a block above the diagonal.
pub(crate) fn half_offset(row: usize, column: usize) -> usize {
    let (row, column) = (row / 4, column / 4);
    8 * (row * (row + 1) / 2 + column)
}

/// What f16 numbers are multiples of: the largest of them.
pub fn unit_of(values: &[f32]) -> f32 {
    values.iter().fold(0.0, |m, v| v.abs().max(m))
}

/// A number as it will be read again, written as f16 in units of `unit`.
pub fn rounded(value: f32, unit: f32) -> f32 {
    from_bits(to_bits(value, unit), unit)
}

fn to_bits(value: f32, unit: f32) -> u16 {
    if unit > 0.0 { f16::from_f32(value / unit).to_bits() } else { 0 }
}

fn from_bits(bits: u16, unit: f32) -> f32 {
    f16::from_bits(bits).to_f32() * unit
}

fn all_to_bits(values: &[f32]) -> Vec<u16> {
    let unit = unit_of(values);
    values.iter().map(|&v| to_bits(v, unit)).collect()
}

fn all_from_bits(bits: &[u16], unit: f32) -> Cow<'static, [f32]> {
    bits.iter().map(|&b| from_bits(b, unit)).collect()
}

/// Reads this form.
pub(crate) fn read(c: &Container) -> Result<PackedOperator<'_>> {
    let meta: Meta = c.meta("pack.half")?;
    let n = meta.n as usize;
    let units = [meta.outlier_unit, meta.scale_unit, meta.core_unit];
    if meta.n > MOST_PATCHES {
        return Err(Error::invariant(NAME, format!("{n} patches, half of it holds up to {MOST_PATCHES}")));
    }
    if !units.iter().all(|u| (0.0..=LARGEST_UNIT).contains(u)) {
        return Err(Error::invariant(NAME, format!("units {units:?}, expected finite ones up to {LARGEST_UNIT:e}")));
    }
    let (tile, tiles) = Packing::tiling(meta.n);
    let packing = Packing {
        n: meta.n,
        channels: meta.channels,
        bounces: meta.bounces,
        format: BlockFormat::Bc4,
        map: meta.map,
        scale: [meta.scale; 3],
        tile,
        tiles,
    };
    packing.check()?;
    check_patch_count(c, NAME, n)?;
    let start = c.array_of::<u32>("pack.half_start", &[Some(n + 1)])?;
    let column = c.array_of::<u16>("pack.half_column", &[None])?;
    check_offsets(NAME, "half_start", start, n, column.len())?;
    let value = c.array_of::<u16>("pack.half_value", &[Some(column.len())])?;
    let mut colour = Colour { axes: meta.axes, rank: meta.rank, ..Colour::default() };
    if !colour.axes.is_empty() {
        let core = c.array_of::<u16>("pack.half_core", &[Some(colour.axes.len()), None])?;
        colour.core = all_from_bits(core, meta.core_unit);
        colour.component = c.array_of::<u16>("pack.half_component", &[Some(n)])?.into();
        colour.scale = all_from_bits(c.array_of::<u16>("pack.half_scale", &[Some(n)])?, meta.scale_unit);
        colour.codes = c.array_of::<u8>("pack.half_codes", &[None])?.into();
    }
    if meta.channels == 1 && !colour.axes.is_empty() {
        return Err(Error::invariant(NAME, "one channel and planes of colour"));
    }
    colour.check(n)?;
    let packed = PackedOperator {
        packing,
        blocks: c.array_of::<u8>("pack.half_blocks", &[Some(half_blocks(meta.n)), Some(8)])?.into(),
        outlier_start: start.into(),
        outlier_column: column.iter().map(|&j| u32::from(j)).collect(),
        outlier_value: all_from_bits(value, meta.outlier_unit),
        half: Some(colour),
    };
    packed.check_outliers()?;
    let above = |row: &usize| packed.outlier_column[packed.outliers_of(*row)].iter().any(|&j| j as usize > *row);
    match (0..n).find(above) {
        Some(row) => Err(Error::invariant(NAME, format!("row {row} has an outlier above the diagonal"))),
        None => Ok(packed),
    }
}

/// Adds the sections of this form.
pub(crate) fn write<'b>(packed: &'b PackedOperator, colour: &'b Colour, b: &mut Builder<'b>) {
    let p = &packed.packing;
    let meta = Meta {
        n: p.n,
        channels: p.channels,
        bounces: p.bounces,
        map: p.map,
        scale: p.scale[0],
        outlier_unit: unit_of(&packed.outlier_value),
        axes: colour.axes.clone(),
        rank: colour.rank.clone(),
        scale_unit: unit_of(&colour.scale),
        core_unit: unit_of(&colour.core),
    };
    b.meta("pack.half", FLAG_REQUIRED, &meta);
    b.array("pack.half_blocks", FLAGS, &[packed.blocks.len() / 8, 8], &packed.blocks[..]);
    b.array("pack.half_start", FLAGS, &[packed.outlier_start.len()], &packed.outlier_start[..]);
    let outliers = packed.outlier_column.len();
    let columns: Vec<u16> = packed.outlier_column.iter().map(|&j| j as u16).collect();
    b.array("pack.half_column", FLAGS, &[outliers], columns);
    b.array("pack.half_value", FLAGS, &[outliers], all_to_bits(&packed.outlier_value));
    if colour.axes.is_empty() {
        return;
    }
    let n = p.n as usize;
    b.array("pack.half_component", FLAGS, &[n], &colour.component[..]);
    b.array("pack.half_scale", FLAGS, &[n], all_to_bits(&colour.scale));
    b.array("pack.half_codes", FLAGS, &[colour.codes.len()], &colour.codes[..]);
    let entries = colour.core.len() / colour.axes.len();
    b.array("pack.half_core", FLAGS, &[colour.axes.len(), entries], all_to_bits(&colour.core));
}
