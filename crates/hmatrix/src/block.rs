//! A block in bytes: for any rectangle, whatever matrix it is cut from.
//!
//! A byte says what it is: two bits the kind, six the rank or the bits of a tile. A low-rank block goes on with its
//! mean (f16), if it has one, two bits a triple that say how many bits its codes have, scales (f16), and codes; a
//! tile as `tile.rs` says.
//!
//! The mean is one more term, mean · w wᵀ, of the same w in all blocks: √A, so that a block brings the right flux
//! under even light. Small blocks that would be nothing keep their light for two bytes.

use half::f16;

use crate::{
    Result,
    bits::{Reader, Writer},
    tile::{self, Tile},
    triple::{BITS, Coded},
};

/// Which entries a block has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// All of a rectangle.
    Full {
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
    },
    /// A symmetric square, of which the lower triangle is stored, row by row.
    Symmetric {
        /// Rows and columns.
        size: usize,
    },
}

impl Shape {
    /// Entries that a tile stores.
    pub fn entries(self) -> usize {
        match self {
            Shape::Full { rows, columns } => rows * columns,
            Shape::Symmetric { size } => size * (size + 1) / 2,
        }
    }

    /// Number of an entry in a tile.
    pub fn entry(self, row: usize, column: usize) -> usize {
        match self {
            Shape::Full { columns, .. } => row * columns + column,
            Shape::Symmetric { .. } => {
                let (low, high) = (row.min(column), row.max(column));
                high * (high + 1) / 2 + low
            }
        }
    }

    /// Codes of a triple.
    pub fn codes(self) -> usize {
        match self {
            Shape::Full { rows, columns } => rows + columns,
            Shape::Symmetric { size } => size,
        }
    }
}

/// What a block is.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// A mean and a sum of triples; nothing if there are none.
    LowRank {
        /// In units of the operator, 0 if there is none.
        mean: f16,
        triples: Vec<Coded>,
    },
    /// Entry by entry.
    Tile(Tile),
    /// Four smaller ones, or three of a symmetric one, which follow.
    Split,
}

/// Most triples of a block.
pub const MOST_TRIPLES: usize = 63;

/// Bytes of a mean.
pub const MEAN_BYTES: f64 = 2.0;
/// Bytes of a triple besides its codes: scale and the choice of bits.
pub const TRIPLE_BYTES: f64 = 2.25;

impl Block {
    /// Appends the block.
    pub fn write(&self, out: &mut Writer) {
        match self {
            Block::LowRank { mean, triples } => {
                let bare = *mean == f16::ZERO;
                out.put(if bare { 0 } else { 3 }, 2);
                out.put(triples.len() as u32, 6);
                if !bare {
                    out.put(mean.to_bits().into(), 16);
                }
                triples.iter().for_each(|t| out.put(t.bits as u32, 2));
                out.align();
                triples.iter().for_each(|t| out.put(t.scale.to_bits().into(), 16));
                triples.iter().for_each(|t| t.write_codes(out));
                out.align();
            }
            Block::Tile(tile) => {
                out.put(1, 2);
                let index = tile::BITS.iter().position(|b| *b == tile.bits);
                out.put(index.unwrap_or(0) as u32, 6);
                tile.write(out);
            }
            Block::Split => out.put(2, 8),
        }
    }

    /// Reads a block of `shape`.
    pub fn read(input: &mut Reader, shape: Shape) -> Result<Block> {
        input.what = "a block";
        let (kind, number) = (input.get(2)?, input.get(6)? as usize);
        match (kind, number) {
            (0, rank) => Ok(Block::LowRank { mean: f16::ZERO, triples: read_triples(input, shape, rank)? }),
            (3, rank) => Ok(Block::LowRank { mean: finite(input)?, triples: read_triples(input, shape, rank)? }),
            (1, index) if index < tile::BITS.len() && shape.entries() <= tile::MOST => {
                Ok(Block::Tile(Tile::read(input, shape.entries(), tile::BITS[index])?))
            }
            (2, 0) => Ok(Block::Split),
            _ => input.damaged(format!("kind {kind} {number}"), "a kind of block"),
        }
    }
}

fn read_triples(input: &mut Reader, shape: Shape, rank: usize) -> Result<Vec<Coded>> {
    let mut bits = Vec::with_capacity(rank);
    for _ in 0..rank {
        let index = input.get(2)? as usize;
        if index >= BITS.len() {
            return input.damaged(index.to_string(), "a number of bits");
        }
        bits.push(index);
    }
    input.align();
    let mut scales = Vec::with_capacity(rank);
    for _ in 0..rank {
        scales.push(finite(input)?);
    }
    let triples = bits.into_iter().zip(scales);
    let triples = triples.map(|(b, s)| Coded::read_codes(input, b, s, shape.codes())).collect::<Result<_>>()?;
    input.align();
    Ok(triples)
}

fn finite(input: &mut Reader) -> Result<f16> {
    let value = f16::from_bits(input.get(16)? as u16);
    if value.is_finite() { Ok(value) } else { input.damaged(value.to_string(), "a finite number") }
}
