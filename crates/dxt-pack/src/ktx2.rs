//! The texture as a KTX2 file, for other tools.
//!
//! Source: Khronos KTX File Format Specification 2.0, §3 (header and indices); Khronos Data Format Specification 1.3,
//! §5 (the basic descriptor block).

use radfile::{BlockFormat, PackedOperator};

const IDENTIFIER: [u8; 12] = *b"\xABKTX 20\xBB\r\n\x1A\n";
/// Header, index and one entry of the level index.
const HEAD: u32 = 12 + 9 * 4 + 4 * 4 + 2 * 8 + 3 * 8;
/// A basic descriptor block of one sample, and the total size before it.
const DESCRIPTOR: u32 = 4 + 24 + 16;

/// A KTX2 file (BC1_RGB_UNORM or BC4_UNORM, one level, not supercompressed) of all blocks as one texture array
/// ([`PackedOperator::texture_size`]).
///
/// Blocks lie in the order of the container. A KTX2 file has no place for the rest of the operator (map, scale,
/// outliers, colour): those stay in the `.rad` file.
pub fn ktx2(packed: &PackedOperator) -> Vec<u8> {
    let [width, height, layers] = packed.texture_size();
    let blocks = packed.texture_blocks();
    // VkFormat, and the colour model of the descriptor.
    let (format, model) = match packed.packing.format {
        BlockFormat::Bc1 => (131, 128),
        BlockFormat::Bc4 => (139, 131),
    };
    // Levels start at multiples of a block.
    let first = u64::from(HEAD + DESCRIPTOR).next_multiple_of(8);
    let mut file = Vec::with_capacity(first as usize + blocks.len());
    file.extend(IDENTIFIER);
    // Bytes of a number, size, no depth, layers, faces, levels, no supercompression.
    let header = [format, 1, width, height, 0, layers, 1, 1, 0];
    // The descriptor; no keys and values; no global data.
    let index = [HEAD, DESCRIPTOR, 0, 0, 0, 0, 0, 0];
    file.extend(header.iter().chain(&index).flat_map(|v: &u32| v.to_le_bytes()));
    let level = [first, blocks.len() as u64, blocks.len() as u64];
    file.extend(level.iter().flat_map(|v| v.to_le_bytes()));
    // Khronos' basic block, version 2, 40 bytes; numbers are linear and of no colour space; 4 × 4 texels in 8 bytes; one
    // sample of 64 bits from 0 to the largest.
    let descriptor = [DESCRIPTOR, 0, 40 << 16 | 2, 1 << 16 | model, 3 << 8 | 3, 8, 0, 63 << 16, 0, 0, u32::MAX];
    file.extend(descriptor.iter().flat_map(|v: &u32| v.to_le_bytes()));
    file.resize(first as usize, 0);
    file.extend_from_slice(&blocks);
    file
}
