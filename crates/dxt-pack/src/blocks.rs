//! The texture of a split operator, block by block.

use radfile::{BlockFormat, Packing, Progress};
use rayon::prelude::*;

use crate::{bc1, bc4, split::Split};

/// Encodes every tile of an operator over patches with the given areas.
///
/// Each run of blocks along a tile is one piece of work, so threads do not matter.
pub fn encode(split: &Split, area: &[f32], packing: &Packing, progress: &dyn Progress) -> Vec<u8> {
    let run_bytes = packing.tile_blocks() * 8;
    let mut blocks = vec![0; packing.tile_count() * packing.tile_bytes()];
    progress.begin("encoding blocks", (blocks.len() / run_bytes) as u64);
    let encoder = bc4::Encoder::new(packing.map);
    let root_area: Vec<f32> = area.iter().map(|a| a.sqrt()).collect();
    let work = Work { split, packing, encoder, root_area };
    blocks.par_chunks_exact_mut(run_bytes).enumerate().for_each(|(run, blocks)| {
        let place = Place::of_run(run, packing);
        for (k, block) in blocks.as_chunks_mut::<8>().0.iter_mut().enumerate() {
            *block = work.encode_block(place.block(k));
        }
        progress.advance(1);
    });
    blocks
}

/// A block: its plane and first texel.
#[derive(Clone, Copy)]
struct Place {
    plane: usize,
    row: usize,
    column: usize,
}

impl Place {
    /// First block of run number `run`, in the order of [`Packing::block_offset`].
    fn of_run(run: usize, packing: &Packing) -> Place {
        let (tile, tiles) = (packing.tile as usize, packing.tiles as usize);
        let (tile_index, block_row) = (run / packing.tile_blocks(), run % packing.tile_blocks());
        let (tile_row, tile_column) = (tile_index / tiles % tiles, tile_index % tiles);
        Place { plane: tile_index / (tiles * tiles), row: tile_row * tile + 4 * block_row, column: tile_column * tile }
    }

    /// Row and column of texel `t` of the block.
    fn texel(self, t: usize) -> (usize, usize) {
        (self.row + t / 4, self.column + t % 4)
    }

    /// The block `k` further along the run.
    fn block(self, k: usize) -> Place {
        Place { column: self.column + 4 * k, ..self }
    }
}

/// What every block is made from.
struct Work<'a> {
    split: &'a Split<'a>,
    packing: &'a Packing,
    encoder: bc4::Encoder,
    /// √A of every sender.
    root_area: Vec<f32>,
}

impl Work<'_> {
    fn encode_block(&self, at: Place) -> [u8; 8] {
        let n = self.root_area.len();
        if at.row >= n || at.column >= n {
            return [0; 8];
        }
        match self.packing.format {
            BlockFormat::Bc4 => self.encoder.encode(&bc4::Texels::new(
                from_texels(|t| self.relative(at.plane, at.texel(t))),
                from_texels(|t| if self.kept(at.texel(t)) { self.root_area[at.texel(t).1] } else { 0.0 }),
            )),
            BlockFormat::Bc1 => bc1::encode(&from_texels(|t| self.colour(at.texel(t)))),
        }
    }

    /// An entry as a colour; grey fills all three channels.
    fn colour(&self, texel: (usize, usize)) -> bc1::Texel {
        if !self.kept(texel) {
            return bc1::Texel::Any;
        }
        let channel = |c: usize| c.min(self.packing.channels as usize - 1);
        match std::array::from_fn(|c| self.relative(channel(c), texel)) {
            [0.0, 0.0, 0.0] => bc1::Texel::Zero,
            relative => bc1::Texel::Code(relative.map(|v| self.packing.map.encode(v, 1.0))),
        }
    }

    /// Whether a texel is an entry of the matrix and no outlier.
    fn kept(&self, (row, column): (usize, usize)) -> bool {
        self.inside(row, column) && !self.split.is_outlier(row, column)
    }

    /// The entry of a texel in units of the scale, 0 beyond the matrix.
    fn relative(&self, channel: usize, (row, column): (usize, usize)) -> f32 {
        if self.inside(row, column) { self.split.relative(channel, row, column) } else { 0.0 }
    }

    fn inside(&self, row: usize, column: usize) -> bool {
        row.max(column) < self.root_area.len()
    }
}

/// Something of each of the sixteen texels of a block.
fn from_texels<T>(f: impl Fn(usize) -> T) -> [T; 16] {
    std::array::from_fn(f)
}

#[cfg(test)]
mod tests {
    use super::*;
    use radfile::{Operator, PackedOperator, Quiet, ValueMap};

    /// 9000 patches need 3 × 3 tiles; no texture of that size is made here.
    #[test]
    fn runs_of_blocks_follow_the_order_of_the_container() {
        let (tile, tiles) = Packing::tiling(9000);
        assert_eq!((tile, tiles), (3000, 3));
        let packing = Packing {
            n: 9000,
            channels: 3,
            bounces: None,
            format: BlockFormat::Bc4,
            map: ValueMap::Sqrt,
            scale: [1.0; 3],
            tile,
            tiles,
        };
        let runs = packing.tile_count() * packing.tile_blocks();
        for run in (0..runs).step_by(97).chain([runs - 1]) {
            for k in [0, 1, packing.tile_blocks() - 1] {
                let Place { plane, row, column } = Place::of_run(run, &packing).block(k);
                let expected = (run * packing.tile_blocks() + k) * 8;
                assert_eq!(packing.block_offset(plane, row, column), expected, "run {run}, block {k}");
                assert_eq!(packing.block_offset(plane, row + 3, column + 3), expected);
            }
        }
    }

    /// Nine small tiles hold the same values as one large tile.
    #[test]
    fn tiles_do_not_change_the_values() {
        let n = 21;
        let values: Vec<f32> = (0..n * n).map(|at| 1.0 + (at / n) as f32 * 0.1 + (at % n) as f32 * 0.03).collect();
        let operator = Operator { n, channels: 1, bounces: None, values: values.into() };
        let split = Split::new(&operator, 0.0).unwrap();
        let decoded = [(24, 1), (8, 3)].map(|(tile, tiles)| {
            let packing = Packing {
                n: n as u32,
                channels: 1,
                bounces: None,
                format: BlockFormat::Bc4,
                map: ValueMap::Sqrt,
                scale: split.scale,
                tile,
                tiles,
            };
            let packed = PackedOperator {
                half: None,
                blocks: encode(&split, &[1.0; 21], &packing, &Quiet).into(),
                packing,
                outlier_start: split.start.clone().into(),
                outlier_column: Vec::new().into(),
                outlier_value: Vec::new().into(),
            };
            packed.decode(0)
        });
        assert_eq!(decoded[0], decoded[1]);
        let off = decoded[0].iter().zip(&operator.values[..]).map(|(d, k)| (d - k).abs()).fold(0.0, f32::max);
        assert!(off < 0.05, "off by {off}");
    }
}
