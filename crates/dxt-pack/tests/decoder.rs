//! The decoder that the whole project relies on (`radfile::PackedOperator`), against two others.

use radfile::{BlockFormat, PackedOperator, Packing, ValueMap};

/// Random blocks of a matrix of `4 · across` patches.
fn noise(format: BlockFormat, across: usize) -> PackedOperator<'static> {
    let (tile, tiles) = Packing::tiling(4 * across as u32);
    let packing = Packing {
        n: 4 * across as u32,
        channels: 3,
        bounces: None,
        format,
        map: ValueMap::Sqrt,
        scale: [1.0; 3],
        tile,
        tiles,
    };
    let mut state = 7u64;
    let mut blocks: Vec<u8> = (0..packing.tile_count() * packing.tile_bytes())
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 56) as u8
        })
        .collect();
    // Both orders of the endpoints come up by chance; equal ones are made.
    for block in blocks.as_chunks_mut::<8>().0.iter_mut().step_by(9) {
        let width = if format == BlockFormat::Bc4 { 1 } else { 2 };
        block.copy_within(0..width, width);
    }
    PackedOperator {
        half: None,
        outlier_start: vec![0; packing.n as usize + 1].into(),
        outlier_column: Vec::new().into(),
        outlier_value: Vec::new().into(),
        blocks: blocks.into(),
        packing,
    }
}

/// Codes of one channel, by way of the square root map that `noise` declares.
fn codes(packed: &PackedOperator, channel: usize) -> Vec<f32> {
    packed.decode(channel).into_iter().map(f32::sqrt).collect()
}

/// Compares every texel of every block with what `other` makes of the block: codes of 16 texels.
fn compare(packed: &PackedOperator, channel: usize, tolerance: f32, other: impl Fn(&[u8]) -> [f32; 16]) {
    let n = packed.packing.n as usize;
    let plane = if packed.packing.planes() == 1 { 0 } else { channel };
    let ours = codes(packed, channel);
    for block in 0..n * n / 16 {
        let (row, column) = (block / (n / 4) * 4, block % (n / 4) * 4);
        let bytes = &packed.blocks[packed.packing.block_offset(plane, row, column)..][..8];
        for (texel, theirs) in other(bytes).into_iter().enumerate() {
            let (row, column) = (row + texel / 4, column + texel % 4);
            let ours = ours[row * n + column];
            assert!((ours - theirs).abs() <= tolerance, "{bytes:02x?} texel {texel}: {ours}, others say {theirs}");
            let alone = packed.texel(channel, row, column).sqrt();
            assert_eq!(alone, ours, "one texel and the whole matrix");
        }
    }
}

/// Half a step of 8 bits for the rounding of the other decoder, plus the sloppiness of its integer fractions.
const EIGHT_BITS: f32 = 0.51 / 255.0;

#[test]
fn bc4_decodes_like_bcdec_in_floats_and_in_bytes() {
    let packed = noise(BlockFormat::Bc4, 40);
    for channel in 0..3 {
        // Square and square root cost a few units in the last place.
        compare(&packed, channel, 1e-6, |block| {
            let mut out = [0.0; 16];
            bcdec_rs::bc4_float(block, &mut out, 4, false);
            out
        });
        compare(&packed, channel, EIGHT_BITS, |block| {
            let mut out = [0; 16];
            bcdec_rs::bc4(block, &mut out, 4, false);
            out.map(|code| f32::from(code) / 255.0)
        });
    }
}

#[test]
fn bc1_decodes_like_bcdec_in_all_channels_and_both_modes() {
    let packed = noise(BlockFormat::Bc1, 40);
    for channel in 0..3 {
        compare(&packed, channel, EIGHT_BITS, |block| {
            let mut out = [0; 64];
            bcdec_rs::bc1(block, &mut out, 16);
            std::array::from_fn(|texel| f32::from(out[4 * texel + channel]) / 255.0)
        });
    }
}

#[test]
fn a_second_decoder_agrees() {
    use block_compression::{CompressionVariant, decode::decompress_blocks_as_rgba8};
    // This one cuts fractions off where bcdec rounds: up to a whole step, and in BC1 once more
    // where 5 and 6 bits become 8.
    for (format, variant, tolerance) in [
        (BlockFormat::Bc4, CompressionVariant::BC4, 1.01 / 255.0),
        (BlockFormat::Bc1, CompressionVariant::BC1, 1.8 / 255.0),
    ] {
        compare(&noise(format, 40), 0, tolerance, |block| {
            let mut out = [0; 64];
            decompress_blocks_as_rgba8(variant, 4, 4, block, &mut out);
            std::array::from_fn(|texel| f32::from(out[4 * texel]) / 255.0)
        });
    }
}

#[test]
fn tiles_hold_every_block_once() {
    // Small tiles stand for the large ones of more than 4096 patches; decoding does not care.
    let (tile, tiles) = (8, 3);
    let packing = Packing { n: 21, tile, tiles, ..noise(BlockFormat::Bc4, 4).packing };
    let mut seen = vec![0; packing.tile_count() * packing.tile_bytes() / 8];
    for plane in 0..packing.planes() {
        for row in 0..24 {
            for column in 0..24 {
                seen[packing.block_offset(plane, row, column) / 8] += 1;
            }
        }
    }
    assert!(seen.iter().all(|&texels| texels == 16), "{seen:?}");
}

#[test]
fn tilings_cover_the_matrix_with_tiles_that_every_gpu_takes() {
    for (n, expected) in
        [(1, (4, 1)), (4, (4, 1)), (10, (12, 1)), (4096, (4096, 1)), (4097, (2052, 2)), (9000, (3000, 3))]
    {
        assert_eq!(Packing::tiling(n), expected, "{n} patches");
    }
    for n in (1..100_000).step_by(7) {
        let (tile, tiles) = Packing::tiling(n);
        assert!(tile % 4 == 0 && tile <= 4096 && tile * tiles >= n, "{n} patches: {tiles} tiles of {tile}");
    }
}

#[test]
fn maps_and_their_inverses_meet() {
    for map in [ValueMap::Sqrt, ValueMap::Log { shift: 6.0 }, ValueMap::Log { shift: 25.0 }] {
        for scale in [1e-6, 0.3, 1.0, 50.0] {
            for step in 1..=1000 {
                let u = step as f32 / 1000.0;
                let back = map.encode(map.decode(u, scale), scale);
                // f32 carries 24 bits of the value; the logarithm of it is good to ulp / shift.
                assert!((back - u).abs() < 3e-6, "{map:?}, scale {scale}: {u} came back as {back}");
            }
            assert_eq!(map.decode(0.0, scale), 0.0);
            assert_eq!(map.decode(1.0, scale), scale);
            assert_eq!(map.encode(0.0, scale), 0.0);
            assert_eq!(map.encode(2.0 * scale, scale), 1.0);
        }
        assert_eq!(map.encode(1.0, 0.0), 0.0);
        assert_eq!(map.decode(1.0, 0.0), 0.0);
    }
    let log = ValueMap::Log { shift: 6.0 };
    assert_eq!(log.encode(1e-9, 1.0), 0.0, "too small for the span of the logarithm");
}
