// SPDX-License-Identifier: MIT OR Apache-2.0
//
// codes_sampled.wgsl: codes of the operator from a block-compressed texture that the hardware decodes.
// Joined behind product.wgsl; holds no entry point.
//
// twin       radfile::PackedOperator::codes
// units      1
// layout     radfile::PackedOperator::texture_size
// limits     as many layers as the adapter's arrays have
// tolerance  the adapter's: up to 2/255 a code on software adapters, which is why it is probed

@group(0) @binding(7) var tiles: texture_2d_array<f32>;

fn code(tile: u32, row: u32, column: u32) -> vec3<f32> {
    return textureLoad(tiles, vec2(column, row), tile, 0).xyz;
}
