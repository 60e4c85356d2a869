// SPDX-License-Identifier: MIT OR Apache-2.0
//
// codes_stored.wgsl: codes of the operator from the blocks themselves, decoded here in single precision.
// Serves adapters that cannot decode blocks or decode them too coarsely. Joined behind product.wgsl; holds
// no entry point.
//
// equation   BC4: two 8-bit ends, 6 or 4 mixtures, 3-bit indices; BC1: two 5:6:5 ends, 2 or 1 mixtures,
//            2-bit indices (Khronos Data Format Specification 1.3, 18.1 and 18.4)
// twin       bc4_palette, bc1_palette in crates/radfile/src/packed.rs
// units      1
// layout     8 bytes a block as two words, in the order of the container
// tolerance  2 eps, eps = 2^-23

@group(0) @binding(7) var<storage, read> blocks: array<vec2<u32>>;

fn bc4_code(block: vec2<u32>, texel: u32) -> f32 {
    let ends = vec2(block.x & 255u, block.x >> 8u & 255u);
    let a = f32(ends.x) / 255.0;
    let b = f32(ends.y) / 255.0;
    let bit = 16u + 3u * texel;
    var index: u32;
    if bit >= 32u {
        index = block.y >> (bit - 32u);
    } else {
        index = block.x >> bit;
        if bit > 29u {
            index |= block.y << (32u - bit);
        }
    }
    index &= 7u;
    if index < 2u {
        return select(a, b, index == 1u);
    }
    let i = f32(index - 1u);
    if ends.x > ends.y {
        return (a * (7.0 - i) + b * i) / 7.0;
    }
    if index < 6u {
        return (a * (5.0 - i) + b * i) / 5.0;
    }
    return f32(index - 6u);
}

fn bc1_end(end: u32) -> vec3<f32> {
    return vec3(f32(end >> 11u), f32(end >> 5u & 63u), f32(end & 31u)) / vec3(31.0, 63.0, 31.0);
}

fn bc1_code(block: vec2<u32>, texel: u32) -> vec3<f32> {
    let ends = vec2(block.x & 65535u, block.x >> 16u);
    let a = bc1_end(ends.x);
    let b = bc1_end(ends.y);
    let index = block.y >> (2u * texel) & 3u;
    if index < 2u {
        return select(a, b, index == 1u);
    }
    if ends.x > ends.y {
        return select(2.0 * a + b, a + 2.0 * b, index == 3u) / 3.0;
    }
    return select(0.5 * (a + b), vec3(0.0), index == 3u);
}

fn code(tile: u32, row: u32, column: u32) -> vec3<f32> {
    let block = blocks[(tile * params.high + row / 4u) * params.wide + column / 4u];
    let texel = row % 4u * 4u + column % 4u;
    if params.bc1 == 1u {
        return bc1_code(block, texel);
    }
    return vec3(bc4_code(block, texel));
}
