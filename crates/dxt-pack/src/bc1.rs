//! BC1 blocks.
//!
//! The encoder is that of the crate `block_compression` (a port of Intel's ISPC texture compressor).
//! It takes 8-bit colours, as the paper's format does, and makes four colours on a line; a block with
//! entries that are exactly 0 takes the mode of three colours and black instead, so that no light
//! gets into a sealed room.

use block_compression::{CompressionVariant, encode::compress_rgba8};

/// What a texel should decode to.
#[derive(Clone, Copy, PartialEq)]
pub enum Texel {
    /// Anything.
    Any,
    /// Exactly 0 in every channel.
    Zero,
    /// About these codes 0..1.
    Code([f32; 3]),
}

/// Encodes sixteen texels, row by row.
pub fn encode(texels: &[Texel; 16]) -> [u8; 8] {
    let codes = || texels.iter().filter_map(|t| if let Texel::Code(code) = t { Some(code) } else { None });
    let count = codes().count();
    if count == 0 {
        return [0; 8]; // both endpoints black: exactly 0
    }
    // A texel that the line of colours does not serve must not stretch it, so it takes the mean.
    let mean: [f32; 3] = std::array::from_fn(|c| codes().map(|code| code[c]).sum::<f32>() / count as f32);
    let colours = texels.map(|t| if let Texel::Code(code) = t { code } else { mean });
    let mut rgba = [255u8; 64];
    for (bytes, colour) in rgba.as_chunks_mut::<4>().0.iter_mut().zip(&colours) {
        bytes[..3].copy_from_slice(&colour.map(|code| (code * 255.0).round() as u8));
    }
    let mut block = [0; 8];
    compress_rgba8(CompressionVariant::BC1, &rgba, &mut block, 4, 4, 16);
    let ends = [u16::from_le_bytes([block[0], block[1]]), u16::from_le_bytes([block[2], block[3]])];
    if texels.contains(&Texel::Zero) { three_colours(ends, texels, &colours) } else { four_colours(block, ends) }
}

/// The same colours with the first endpoint above the second, so that no index means black.
fn four_colours(mut block: [u8; 8], ends: [u16; 2]) -> [u8; 8] {
    if ends[0] == ends[1] {
        block[4..].fill(0); // one colour: every texel takes the first endpoint
    } else if ends[0] < ends[1] {
        block[..4].rotate_left(2);
        // Indices 0 and 1 trade places, and so do 2 and 3.
        block[4..].iter_mut().for_each(|indices| *indices ^= 0x55);
    }
    block
}

/// The endpoints in the order that makes index 2 their middle and index 3 black.
fn three_colours(ends: [u16; 2], texels: &[Texel; 16], colours: &[[f32; 3]; 16]) -> [u8; 8] {
    let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    let (a, b) = (colour_of(low), colour_of(high));
    let palette = [a, b, std::array::from_fn(|c| (a[c] + b[c]) / 2.0)];
    let indices = texels.iter().zip(colours).enumerate().fold(0u32, |bits, (texel, (kind, colour))| {
        let distance = |i: usize| (0..3).map(|c| (palette[i][c] - colour[c]).powi(2)).sum::<f32>();
        let nearest = (1..3).fold(0, |best, i| if distance(i) < distance(best) { i } else { best });
        bits | (if *kind == Texel::Zero { 3 } else { nearest as u32 }) << (2 * texel)
    });
    (u64::from(indices) << 32 | u64::from(high) << 16 | u64::from(low)).to_le_bytes()
}

/// Codes of a 5:6:5 colour.
fn colour_of(end: u16) -> [f32; 3] {
    [f32::from(end >> 11) / 31.0, f32::from(end >> 5 & 63) / 63.0, f32::from(end & 31) / 31.0]
}
