//! Where in the matrix which kind of block is, for pictures and tables.

use std::ops::Range;

use half::f16;

use crate::{HMatrix, Result, bits::Writer, block::Block, stream::Parts};

/// The blocks of a packed operator.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Those of luma, then those of each plane of colour; each plane covers the matrix once.
    pub planes: Vec<Vec<MapBlock>>,
    /// Bytes that are in no block: patches at their places, weights, and where blocks are split.
    pub structure: usize,
}

/// A rectangle of the matrix. Rows and columns are places, see [`crate::Layout::order`].
#[derive(Clone, Debug, PartialEq)]
pub struct MapBlock {
    /// Receivers.
    pub rows: Range<usize>,
    /// Senders.
    pub columns: Range<usize>,
    /// Whether its mirror image is meant, too.
    pub mirrored: bool,
    /// What it is stored as.
    pub kind: BlockKind,
    /// Bytes that it takes.
    pub bytes: usize,
}

/// What a block is stored as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockKind {
    /// No entry differs from 0.
    Zero,
    /// The same for all but for areas.
    Mean,
    /// That and so many products of two vectors.
    LowRank(usize),
    /// Entry by entry, with codes of so many bits.
    Tile(u32),
}

impl MapBlock {
    /// Entries of the matrix that it stands for, those of its mirror image included.
    pub fn entries(&self) -> usize {
        self.rows.len() * self.columns.len() * if self.mirrored { 2 } else { 1 }
    }
}

impl HMatrix {
    /// Where which kind of block is. Bytes of blocks and of structure add up to the packed bytes.
    ///
    /// # Errors
    ///
    /// None for bytes that were read once.
    pub fn map(&self) -> Result<Map> {
        let parts = Parts::read(self.to_bytes(), false)?;
        let pairs = parts.pairs();
        let of_plane = |blocks: &[_]| {
            let mapped = blocks.iter().filter_map(|(id, block)| {
                let [rows, columns] = pairs.ranges(*id);
                Some(MapBlock {
                    rows,
                    columns,
                    mirrored: pairs.is_mirrored(*id),
                    kind: kind(block)?,
                    bytes: size(block),
                })
            });
            mapped.collect::<Vec<_>>()
        };
        let planes: Vec<_> = parts.planes.iter().map(|plane| of_plane(&plane.blocks)).collect();
        let of_blocks: usize = planes.iter().flatten().map(|block| block.bytes).sum();
        Ok(Map { planes, structure: self.to_bytes().len() - of_blocks })
    }
}

/// Nothing for a block that is split.
fn kind(block: &Block) -> Option<BlockKind> {
    Some(match block {
        Block::LowRank { mean, triples } if triples.is_empty() && *mean == f16::ZERO => BlockKind::Zero,
        Block::LowRank { triples, .. } if triples.is_empty() => BlockKind::Mean,
        Block::LowRank { triples, .. } => BlockKind::LowRank(triples.len()),
        Block::Tile(tile) => BlockKind::Tile(tile.bits),
        Block::Split => return None,
    })
}

fn size(block: &Block) -> usize {
    let mut out = Writer::default();
    block.write(&mut out);
    out.bytes.len()
}
