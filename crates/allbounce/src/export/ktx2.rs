//! A texture with a depth, in half precision, as a KTX2 file.
//!
//! Source: Khronos KTX File Format Specification 2.0, §3 (header and indices); Khronos Data Format Specification 1.3,
//! §5 (the basic descriptor block).

use exr::prelude::f16;

const IDENTIFIER: [u8; 12] = *b"\xABKTX 20\xBB\r\n\x1A\n";
/// VK_FORMAT_R16G16B16A16_SFLOAT.
const FORMAT: u32 = 97;
/// Header, index and one entry of the level index.
const HEAD: u32 = 12 + 9 * 4 + 4 * 4 + 2 * 8 + 3 * 8;
/// A basic descriptor block of four samples.
const BLOCK: u32 = 24 + 4 * 16;
/// Red, green, blue and alpha in the order of a texel.
const CHANNELS: [u32; 4] = [0, 1, 2, 15];
/// A sample is signed and a float.
const SIGNED_FLOAT: u32 = 0xC0;

/// A KTX2 file of RGBA texels, one level, not supercompressed; the first extent runs fastest.
///
/// # Panics
///
/// If there is not one texel a place: a bug in the caller.
pub fn ktx2([width, height, depth]: [u32; 3], texels: &[[f16; 4]]) -> Vec<u8> {
    assert_eq!(texels.len() as u64, u64::from(width) * u64::from(height) * u64::from(depth), "one texel a place");
    // The descriptor is led by its size; levels start at multiples of a texel.
    let descriptor = 4 + BLOCK;
    let (first, length) = (u64::from(HEAD + descriptor).next_multiple_of(8), 8 * texels.len() as u64);
    let mut file = Vec::with_capacity((first + length) as usize);
    file.extend(IDENTIFIER);
    // Bytes of a number, size, no layers, faces, levels, no supercompression.
    let header = [FORMAT, 2, width, height, depth, 0, 1, 1, 0];
    // The descriptor; no keys and values; no global data.
    let index = [HEAD, descriptor, 0, 0, 0, 0, 0, 0];
    file.extend(header.iter().chain(&index).flat_map(|v: &u32| v.to_le_bytes()));
    file.extend([first, length, length].iter().flat_map(|v| v.to_le_bytes()));
    // Khronos' basic block, version 2; RGB of BT.709, linear; one texel a block, in 8 bytes.
    let block = [descriptor, 0, (BLOCK << 16) | 2, (1 << 16) | (1 << 8) | 1, 0, 8, 0];
    let sample = |(k, channel): (u32, u32)| {
        let bits = (16 * k) | (15 << 16) | ((SIGNED_FLOAT | channel) << 24);
        [bits, 0, (-1.0f32).to_bits(), 1.0f32.to_bits()]
    };
    let samples = (0..).zip(CHANNELS).flat_map(sample);
    file.extend(block.into_iter().chain(samples).flat_map(u32::to_le_bytes));
    file.resize(first as usize, 0);
    file.extend(texels.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
    file
}
