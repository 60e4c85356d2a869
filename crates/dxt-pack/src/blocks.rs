//! The texture of a split operator, block by block.

use radfile::{Packing, Progress, half_blocks};
use rayon::prelude::*;

use crate::{bc1, bc4, split::Split};

/// Encodes every tile of a whole operator as BC1.
///
/// Each run of blocks along a tile is one piece of work, so threads do not matter.
pub fn encode_whole(split: &Split, packing: &Packing, progress: &dyn Progress) -> Vec<u8> {
    let run_bytes = packing.tile_blocks() * 8;
    let mut blocks = vec![0; packing.tile_count() * packing.tile_bytes()];
    progress.begin("encoding blocks", (blocks.len() / run_bytes) as u64);
    blocks.par_chunks_exact_mut(run_bytes).enumerate().for_each(|(run, blocks)| {
        let (row, first) = run_start(run, packing);
        for (k, block) in blocks.as_chunks_mut::<8>().0.iter_mut().enumerate() {
            *block = bc1_block(split, packing, row, first + 4 * k);
        }
        progress.advance(1);
    });
    blocks
}

/// Encodes the blocks on and below the diagonal of luma as BC4, row after row.
pub fn encode_half(split: &Split, root_area: &[f32], packing: &Packing, progress: &dyn Progress) -> Vec<u8> {
    let rows = root_area.len().div_ceil(4);
    progress.begin("encoding blocks", half_blocks(packing.n) as u64);
    let encoder = bc4::Encoder::new(packing.map);
    let of_row = |row: usize| {
        let blocks: Vec<[u8; 8]> = (0..=row).map(|column| bc4_block(split, &encoder, root_area, row, column)).collect();
        progress.advance(row as u64 + 1);
        blocks.concat()
    };
    let rows: Vec<Vec<u8>> = (0..rows).into_par_iter().map(of_row).collect();
    rows.concat()
}

/// Row and first column of run number `run`, in the order of [`Packing::block_offset`].
fn run_start(run: usize, packing: &Packing) -> (usize, usize) {
    let (tile, tiles) = (packing.tile as usize, packing.tiles as usize);
    let (tile_index, block_row) = (run / packing.tile_blocks(), run % packing.tile_blocks());
    (tile_index / tiles % tiles * tile + 4 * block_row, tile_index % tiles * tile)
}

fn bc1_block(split: &Split, packing: &Packing, row: usize, column: usize) -> [u8; 8] {
    let n = packing.n as usize;
    if row >= n || column >= n {
        return [0; 8];
    }
    let texel = |t: usize| {
        let (row, column) = (row + t / 4, column + t % 4);
        if row.max(column) >= n || split.is_outlier(row, column) {
            return bc1::Texel::Any;
        }
        // Grey fills all three channels.
        let channel = |c: usize| c.min(packing.channels as usize - 1);
        match std::array::from_fn(|c| split.relative(channel(c), row, column)) {
            [0.0, 0.0, 0.0] => bc1::Texel::Zero,
            relative => bc1::Texel::Code(relative.map(|v| packing.map.encode(v, 1.0))),
        }
    };
    bc1::encode(&std::array::from_fn(texel))
}

/// Block number (row, column) of the lower half.
fn bc4_block(split: &Split, encoder: &bc4::Encoder, root_area: &[f32], row: usize, column: usize) -> [u8; 8] {
    let n = root_area.len();
    let at = |t: usize| (4 * row + t / 4, 4 * column + t % 4);
    // Texels above the diagonal are never read.
    let inside = |(row, column): (usize, usize)| row < n && column <= row;
    let wanted = std::array::from_fn(|t| if inside(at(t)) { split.relative(0, at(t).0, at(t).1) } else { 0.0 });
    let kept = std::array::from_fn(|t| inside(at(t)) && !split.is_outlier(at(t).0, at(t).1));
    let roots = |block: usize| std::array::from_fn(|k| root_area.get(4 * block + k).copied().unwrap_or(0.0));
    encoder.encode(&bc4::Texels::new(wanted, kept, roots(row), roots(column)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use radfile::{BlockFormat, Operator, PackedOperator, Quiet, ValueMap};

    fn packing(n: u32, tile: u32, tiles: u32, scale: [f32; 3]) -> Packing {
        let (format, map) = (BlockFormat::Bc1, ValueMap::Sqrt);
        Packing { n, channels: 3, bounces: None, format, map, scale, tile, tiles }
    }

    /// 9000 patches need 3 × 3 tiles; no texture of that size is made here.
    #[test]
    fn runs_of_blocks_follow_the_order_of_the_container() {
        let (tile, tiles) = Packing::tiling(9000);
        assert_eq!((tile, tiles), (3000, 3));
        let packing = packing(9000, tile, tiles, [1.0; 3]);
        let runs = packing.tile_count() * packing.tile_blocks();
        for run in (0..runs).step_by(97).chain([runs - 1]) {
            for k in [0, 1, packing.tile_blocks() - 1] {
                let (row, first) = run_start(run, &packing);
                let expected = (run * packing.tile_blocks() + k) * 8;
                assert_eq!(packing.block_offset(0, row, first + 4 * k), expected, "run {run}, block {k}");
                assert_eq!(packing.block_offset(0, row + 3, first + 4 * k + 3), expected);
            }
        }
    }

    /// Nine small tiles hold the same values as one large tile.
    #[test]
    fn tiles_do_not_change_the_values() {
        let n = 21;
        let value = |at: usize| 1.0 + (at / n % n) as f32 * 0.1 + (at % n) as f32 * 0.03;
        let values: Vec<f32> = (0..3 * n * n).map(value).collect();
        let operator = Operator { n, channels: 3, bounces: None, values: values.into() };
        let split = Split::new(&operator, 0.0, false).unwrap();
        let decoded = [(24, 1), (8, 3)].map(|(tile, tiles)| {
            let packing = packing(n as u32, tile, tiles, split.scale);
            let packed = PackedOperator {
                half: None,
                blocks: encode_whole(&split, &packing, &Quiet).into(),
                packing,
                outlier_start: split.start.clone().into(),
                outlier_column: Vec::new().into(),
                outlier_value: Vec::new().into(),
            };
            packed.decode(0)
        });
        assert_eq!(decoded[0], decoded[1]);
        let off = decoded[0].iter().zip(&operator.values[..]).map(|(d, k)| (d - k).abs()).fold(0.0, f32::max);
        assert!(off < 0.2, "off by {off}");
    }
}
