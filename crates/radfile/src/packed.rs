//! The operator as block-compressed textures plus a sparse list of outliers.
//!
//! A value of K goes through a map to a code in 0..1, codes are encoded as BC1 (three channels in
//! one colour) or BC4 (one texture a channel) in tiles that fit any GPU's texture limit. Entries that
//! are too large for the map are listed apart as *remainders*: what is still missing after the texel
//! has been decoded. So a reader always decodes and adds, and an encoder may leave in the texel of an
//! outlier whatever serves its neighbours best. This file defines how bytes become values again, in
//! f32; a GPU's sampler decodes the same blocks.
//!
//! There are two forms. The first holds the whole matrix of every channel, as the paper does. The second holds the
//! half of luma and colour apart (`half.rs`).

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::{
    Builder, Colour, ColourBlock, Container, Error, FLAG_PATCH_ORDER, FLAG_REQUIRED, Record, Result, half,
    patches::check_offsets, record::check_patch_count,
};

/// Block format of the textures; both use 8 bytes for 4 × 4 texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum BlockFormat {
    /// RGB in one texture, 5:6:5 endpoints; four colours, or three and black where entries are exactly 0.
    Bc1,
    /// One unsigned channel, 8-bit endpoints; one texture a channel of the operator.
    Bc4,
}

/// How a code u in 0..1 becomes a value of K.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ValueMap {
    /// scale · exp(shift (u − 1)), and exactly 0 at u = 0 (the paper's map).
    Log {
        /// Span of the logarithm: the smallest value is about scale · exp(−shift).
        shift: f32,
    },
    /// scale · u².
    Sqrt,
}

impl ValueMap {
    /// The value of code `u`.
    pub fn decode(self, u: f32, scale: f32) -> f32 {
        match self {
            ValueMap::Log { .. } if u <= 0.0 => 0.0,
            ValueMap::Log { shift } => scale * (shift * (u - 1.0)).exp(),
            ValueMap::Sqrt => scale * u * u,
        }
    }

    /// The code of a value; values above `scale` saturate.
    pub fn encode(self, value: f32, scale: f32) -> f32 {
        if value <= 0.0 || scale <= 0.0 {
            return 0.0;
        }
        let u = match self {
            ValueMap::Log { shift } => 1.0 + (value / scale).ln() / shift,
            ValueMap::Sqrt => (value / scale).sqrt(),
        };
        u.clamp(0.0, 1.0)
    }
}

/// How the operator was packed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Packing {
    /// Number of patches.
    pub n: u32,
    /// Channels of the operator, 1 or 3.
    pub channels: u32,
    /// Highest bounce in the sum; `None` is all.
    pub bounces: Option<u32>,
    /// Block format.
    pub format: BlockFormat,
    /// Map from codes to values.
    pub map: ValueMap,
    /// Value of code 1, one a channel (a single channel repeats it).
    pub scale: [f32; 3],
    /// Edge of a tile in texels, a multiple of 4. Means nothing where half is stored.
    pub tile: u32,
    /// Tiles along each edge of the matrix. Means nothing where half is stored.
    pub tiles: u32,
}

/// Largest tile edge: every WebGPU implementation has textures of this size.
const MAX_TILE: u32 = 4096;

impl Packing {
    /// Edge and count of equal tiles that cover `n` texels.
    pub fn tiling(n: u32) -> (u32, u32) {
        let tiles = n.div_ceil(MAX_TILE).max(1);
        (n.div_ceil(tiles).next_multiple_of(4), tiles)
    }

    /// Textures: one for BC1, one a channel for BC4.
    pub fn planes(&self) -> usize {
        match self.format {
            BlockFormat::Bc1 => 1,
            BlockFormat::Bc4 => self.channels as usize,
        }
    }

    /// Tiles of all planes.
    pub fn tile_count(&self) -> usize {
        self.planes() * self.tiles as usize * self.tiles as usize
    }

    /// Blocks along the edge of a tile.
    pub fn tile_blocks(&self) -> usize {
        (self.tile / 4) as usize
    }

    /// Bytes of one tile.
    pub fn tile_bytes(&self) -> usize {
        self.tile_blocks() * self.tile_blocks() * 8
    }

    /// First byte of the block that holds texel (row, column) of a plane.
    ///
    /// Order: plane, tile row, tile column, block row, block column.
    pub fn block_offset(&self, plane: usize, row: usize, column: usize) -> usize {
        let (tile, tiles) = (self.tile as usize, self.tiles as usize);
        let tile_index = (plane * tiles + row / tile) * tiles + column / tile;
        let block = (row % tile / 4) * self.tile_blocks() + column % tile / 4;
        tile_index * self.tile_bytes() + block * 8
    }

    pub(crate) fn check(&self) -> Result<()> {
        let tiling = Packing::tiling(self.n);
        let shift_ok = match self.map {
            ValueMap::Log { shift } => shift > 0.0 && shift.is_finite(),
            ValueMap::Sqrt => true,
        };
        let legal = (self.tile, self.tiles) == tiling
            && self.n > 0
            && matches!(self.channels, 1 | 3)
            && shift_ok
            && self.scale.iter().all(|s| s.is_finite() && *s >= 0.0);
        if legal { Ok(()) } else { Err(Error::invariant("packed operator", format!("illegal packing {self:?}"))) }
    }
}

/// The packed operator.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedOperator<'a> {
    /// Its parameters.
    pub packing: Packing,
    /// BC1 or BC4 blocks. Texel (x, y) of the matrix is column x, row y; texels beyond `n` in either direction mean
    /// nothing. The whole matrix: see [`Packing::block_offset`]. Half of it: block (i, j), j ≤ i, is number
    /// i (i + 1) / 2 + j, and texels above the diagonal mean nothing.
    pub blocks: Cow<'a, [u8]>,
    /// `n` + 1 offsets into the outliers of each row.
    pub outlier_start: Cow<'a, [u32]>,
    /// Column (sender) of each outlier, increasing within a row; up to the row itself where half is stored.
    pub outlier_column: Cow<'a, [u32]>,
    /// What is added to its decoded texel in every channel, outliers × channels, or only outliers where half is
    /// stored (and f16 in units of the largest, when written); may be negative.
    pub outlier_value: Cow<'a, [f32]>,
    /// If there, half of luma is stored, and this is the colour. If not, the whole matrix of every channel is.
    pub half: Option<Colour<'a>>,
}

/// Outliers of all rows and columns, `channels` values each.
pub struct Outliers<'a> {
    /// `n` + 1 offsets into the columns.
    pub start: Cow<'a, [u32]>,
    /// Columns of each row, increasing.
    pub column: Cow<'a, [u32]>,
    /// What is added, outliers × channels.
    pub value: Cow<'a, [f32]>,
    /// 1 or 3.
    pub channels: usize,
}

impl PackedOperator<'_> {
    /// Whether a container holds a packed operator of either form.
    pub fn is_in(c: &Container) -> bool {
        c.has("pack.meta") || c.has("pack.half")
    }

    /// Bytes of textures, outliers and colour.
    pub fn size_in_bytes(&self) -> usize {
        let indices = 4 * self.outlier_start.len();
        match &self.half {
            None => self.blocks.len() + indices + 4 * (self.outlier_column.len() + self.outlier_value.len()),
            Some(colour) => self.blocks.len() + indices + 4 * self.outlier_column.len() + colour.size_in_bytes(),
        }
    }

    /// Textures: one where half is stored.
    pub fn planes(&self) -> usize {
        if self.half.is_some() { 1 } else { self.packing.planes() }
    }

    /// Width and height in texels and layers of an array texture that holds the blocks in their order: a layer a tile
    /// and plane of the whole matrix; the half in rows of up to 1024 blocks.
    pub fn texture_size(&self) -> [u32; 3] {
        let p = &self.packing;
        if self.half.is_none() {
            return [p.tile, p.tile, p.tile_count() as u32];
        }
        let blocks = half::half_blocks(p.n) as u32;
        let width = blocks.min(MAX_TILE / 4);
        let rows = blocks.div_ceil(width);
        let layers = rows.div_ceil(MAX_TILE / 4);
        [4 * width, 4 * rows.div_ceil(layers), layers]
    }

    /// The blocks with zeros up to the end of that texture.
    pub fn texture_blocks(&self) -> Cow<'_, [u8]> {
        let [width, height, layers] = self.texture_size().map(|e| e as usize);
        let missing = width / 4 * (height / 4) * layers * 8 - self.blocks.len();
        if missing == 0 {
            return Cow::Borrowed(&self.blocks);
        }
        self.blocks.iter().copied().chain(std::iter::repeat_n(0, missing)).collect()
    }

    /// Where the outliers of a row are.
    pub(crate) fn outliers_of(&self, row: usize) -> std::ops::Range<usize> {
        self.outlier_start[row] as usize..self.outlier_start[row + 1] as usize
    }

    /// The outliers of both halves.
    pub fn outliers(&self) -> Outliers<'_> {
        if self.half.is_none() {
            return Outliers {
                start: Cow::Borrowed(&self.outlier_start),
                column: Cow::Borrowed(&self.outlier_column),
                value: Cow::Borrowed(&self.outlier_value),
                channels: self.packing.channels as usize,
            };
        }
        let mut rows = vec![Vec::new(); self.packing.n as usize];
        // Rows below follow each other, so the columns of a row increase.
        for row in 0..rows.len() {
            for entry in self.outliers_of(row) {
                let (column, value) = (self.outlier_column[entry], self.outlier_value[entry]);
                rows[row].push((column, value));
                if column as usize != row {
                    rows[column as usize].push((row as u32, value));
                }
            }
        }
        let ends = rows.iter().scan(0, |end, row| {
            *end += row.len() as u32;
            Some(*end)
        });
        Outliers {
            start: std::iter::once(0).chain(ends).collect(),
            column: rows.iter().flatten().map(|&(column, _)| column).collect(),
            value: rows.iter().flatten().map(|&(_, value)| value).collect(),
            channels: 1,
        }
    }

    /// The colour of every component; none where the whole matrix is stored.
    pub fn colour(&self) -> Vec<ColourBlock> {
        self.half.as_ref().map_or(Vec::new(), Colour::blocks)
    }

    /// Prepares to decode rows.
    pub fn decoder(&self) -> Decoder<'_> {
        Decoder { packed: self, outliers: self.outliers(), colour: self.colour() }
    }

    /// One texel of one channel as a value of K, without outliers and, where half is stored, without colour.
    ///
    /// # Panics
    ///
    /// If the texel lies outside the textures: a bug in the caller.
    pub fn texel(&self, channel: usize, row: usize, column: usize) -> f32 {
        let channel = channel.min(self.packing.channels as usize - 1);
        let mirrored = self.half.is_some() && column > row;
        let (row, column) = if mirrored { (column, row) } else { (row, column) };
        let (palette, indices) = self.block(channel, row, column);
        let u = palette[indices[row % 4 * 4 + column % 4] as usize];
        self.packing.map.decode(u, self.packing.scale[channel])
    }

    /// The sixteen texels of a stored block as codes of a channel, row after row.
    pub fn codes(&self, channel: usize, row: usize, column: usize) -> [f32; 16] {
        let (palette, indices) = self.block(channel, row, column);
        indices.map(|index| palette[index as usize])
    }

    /// The sixteen texels of a stored block as values of a channel, row after row.
    pub fn texels(&self, channel: usize, row: usize, column: usize) -> [f32; 16] {
        let (palette, indices) = self.block(channel, row, column);
        let palette = palette.map(|u| self.packing.map.decode(u, self.packing.scale[channel]));
        indices.map(|index| palette[index as usize])
    }

    /// Codes and indices of the block that holds a texel; not one above the diagonal where half is stored.
    fn block(&self, channel: usize, row: usize, column: usize) -> ([f32; 8], [u8; 16]) {
        let at = if self.half.is_some() {
            half::half_offset(row, column)
        } else {
            self.packing.block_offset(if self.planes() == 1 { 0 } else { channel }, row, column)
        };
        let block: [u8; 8] = self.blocks[at..at + 8].try_into().expect("a block is 8 bytes");
        match self.packing.format {
            BlockFormat::Bc4 => bc4_palette(block),
            BlockFormat::Bc1 => bc1_palette(block, channel),
        }
    }

    /// The whole matrix of one channel, `n` × `n`, row-major.
    pub fn decode(&self, channel: usize) -> Vec<f32> {
        let n = self.packing.n as usize;
        let decoder = self.decoder();
        let mut matrix = vec![0.0; n.next_multiple_of(4) * n];
        for (block_row, rows) in matrix.chunks_exact_mut(4 * n).enumerate() {
            decoder.rows(channel, block_row, rows);
        }
        matrix.truncate(n * n);
        matrix
    }

    /// Checks the columns and values of the outliers.
    pub(crate) fn check_outliers(&self) -> Result<()> {
        let refuse = |what: String| Err(Error::invariant("packed operator", what));
        if let Some(e) = self.outlier_column.iter().position(|&j| j >= self.packing.n) {
            return refuse(format!("outlier {e} lies in column {}", self.outlier_column[e]));
        }
        let mut rows = (0..self.packing.n as usize).map(|row| &self.outlier_column[self.outliers_of(row)]);
        if let Some(row) = rows.position(|columns| columns.windows(2).any(|w| w[0] >= w[1])) {
            return refuse(format!("the columns of the outliers of row {row} do not increase"));
        }
        match self.outlier_value.iter().position(|v| !v.is_finite()) {
            Some(e) => refuse(format!("outlier value {e} is not finite")),
            None => Ok(()),
        }
    }
}

/// Decodes rows of a packed operator: texels, outliers and colour.
pub struct Decoder<'a> {
    packed: &'a PackedOperator<'a>,
    outliers: Outliers<'a>,
    colour: Vec<ColourBlock>,
}

impl Decoder<'_> {
    /// Decodes rows `4 * block_row ..` of one channel to values of K.
    ///
    /// `out` is 4 × n, row-major; rows beyond n are written and mean nothing.
    pub fn rows(&self, channel: usize, block_row: usize, out: &mut [f32]) {
        let n = self.packed.packing.n as usize;
        let channel = channel.min(self.packed.packing.channels as usize - 1);
        for block_column in 0..n.div_ceil(4) {
            let texels = self.block(channel, block_row, block_column);
            for (texel, value) in texels.into_iter().enumerate() {
                let column = 4 * block_column + texel % 4;
                if column < n {
                    out[texel / 4 * n + column] = value;
                }
            }
        }
        for (row, out) in (4 * block_row..n).zip(out.chunks_exact_mut(n)) {
            self.add_outliers(channel, row, out);
            self.colour.iter().for_each(|block| block.add(channel, row, out));
        }
    }

    /// Sixteen texels of the whole matrix.
    fn block(&self, channel: usize, block_row: usize, block_column: usize) -> [f32; 16] {
        let packed = self.packed;
        let texels = |row: usize, column: usize| packed.texels(channel, 4 * row, 4 * column);
        match (&packed.half, block_row.cmp(&block_column)) {
            (None, _) | (_, std::cmp::Ordering::Greater) => texels(block_row, block_column),
            (Some(_), std::cmp::Ordering::Less) => {
                let mirrored = texels(block_column, block_row);
                std::array::from_fn(|t| mirrored[t % 4 * 4 + t / 4])
            }
            (Some(_), std::cmp::Ordering::Equal) => {
                let lower = texels(block_row, block_row);
                std::array::from_fn(|t| lower[(t / 4).max(t % 4) * 4 + (t / 4).min(t % 4)])
            }
        }
    }

    fn add_outliers(&self, channel: usize, row: usize, out: &mut [f32]) {
        let Outliers { start, column, value, channels } = &self.outliers;
        let channel = channel.min(channels - 1);
        for entry in start[row] as usize..start[row + 1] as usize {
            out[column[entry] as usize] += value[entry * channels + channel];
        }
    }
}

/// Eight codes and the sixteen 3-bit indices of a BC4 block.
/// Source: Khronos Data Format Specification 1.3, §18.4 (RGTC).
fn bc4_palette(block: [u8; 8]) -> ([f32; 8], [u8; 16]) {
    let (a, b) = (f32::from(block[0]) / 255.0, f32::from(block[1]) / 255.0);
    let mix = |i: usize, steps: f32| (a * (steps - i as f32) + b * i as f32) / steps;
    let palette = if block[0] > block[1] {
        [a, b, mix(1, 7.0), mix(2, 7.0), mix(3, 7.0), mix(4, 7.0), mix(5, 7.0), mix(6, 7.0)]
    } else {
        [a, b, mix(1, 5.0), mix(2, 5.0), mix(3, 5.0), mix(4, 5.0), 0.0, 1.0]
    };
    let bits = u64::from_le_bytes(block) >> 16;
    (palette, std::array::from_fn(|texel| (bits >> (3 * texel) & 7) as u8))
}

/// Codes of one colour channel and the sixteen 2-bit indices of a BC1 block.
/// Source: Khronos Data Format Specification 1.3, §18.1 (S3TC).
fn bc1_palette(block: [u8; 8], channel: usize) -> ([f32; 8], [u8; 16]) {
    let ends = [u16::from_le_bytes([block[0], block[1]]), u16::from_le_bytes([block[2], block[3]])];
    let [a, b] = ends.map(|end| match channel {
        0 => f32::from(end >> 11) / 31.0,
        1 => f32::from(end >> 5 & 63) / 63.0,
        _ => f32::from(end & 31) / 31.0,
    });
    let (c, d) = if ends[0] > ends[1] { ((2.0 * a + b) / 3.0, (a + 2.0 * b) / 3.0) } else { ((a + b) / 2.0, 0.0) };
    let bits = u32::from_le_bytes([block[4], block[5], block[6], block[7]]);
    ([a, b, c, d, 0.0, 0.0, 0.0, 0.0], std::array::from_fn(|texel| (bits >> (2 * texel) & 3) as u8))
}

impl<'a> Record<'a> for PackedOperator<'a> {
    const PREFIX: &'static str = "pack.";

    fn read(c: &'a Container) -> Result<PackedOperator<'a>> {
        if c.has("pack.half") {
            return half::read(c);
        }
        let packing: Packing = c.meta("pack.meta")?;
        packing.check()?;
        check_patch_count(c, "packed operator", packing.n as usize)?;
        let tiles = packing.tile_count();
        let start = c.array_of::<u32>("pack.outlier_start", &[Some(packing.n as usize + 1)])?;
        let column = c.array_of::<u32>("pack.outlier_column", &[None])?;
        let channels = packing.channels as usize;
        let packed = PackedOperator {
            blocks: c.array_of::<u8>("pack.blocks", &[Some(tiles), Some(packing.tile_bytes())])?.into(),
            outlier_start: start.into(),
            outlier_column: column.into(),
            outlier_value: c.array_of::<f32>("pack.outlier_value", &[Some(column.len()), Some(channels)])?.into(),
            packing,
            half: None,
        };
        check_offsets("packed operator", "outlier_start", start, start.len() - 1, column.len())?;
        packed.check_outliers()?;
        Ok(packed)
    }

    fn write<'b>(&'b self, b: &mut Builder<'b>) {
        const FLAGS: u32 = FLAG_REQUIRED | FLAG_PATCH_ORDER;
        if let Some(colour) = &self.half {
            return half::write(self, colour, b);
        }
        let p = &self.packing;
        let tiles = p.tile_count();
        b.meta("pack.meta", FLAG_REQUIRED, p);
        b.array("pack.blocks", FLAGS, &[tiles, p.tile_bytes()], &self.blocks[..]);
        b.array("pack.outlier_start", FLAGS, &[self.outlier_start.len()], &self.outlier_start[..]);
        b.array("pack.outlier_column", FLAGS, &[self.outlier_column.len()], &self.outlier_column[..]);
        let shape = [self.outlier_column.len(), p.channels as usize];
        b.array("pack.outlier_value", FLAGS, &shape, &self.outlier_value[..]);
    }
}
