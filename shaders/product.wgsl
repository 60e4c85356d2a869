// SPDX-License-Identifier: MIT OR Apache-2.0
//
// product.wgsl: all bounces at once, the packed operator times what the patches send. Joined with
// codes_sampled.wgsl or codes_stored.wgsl, which say where the codes of the texels come from.
//
// equation   H = A^{-1/2} K x;  K = map(code) + remainder of the outliers. Where half of the matrix is stored, K is
//            luma, and texels above the diagonal are those below; colour_*.wgsl add the colour
//            map: scale exp(shift (u - 1)), 0 at u = 0 (logarithm); scale u^2 (square root)
// twin       radfile::PackedOperator::decode, its product in crates/relight
// dispatch   one workgroup for four rows of texels (a row of blocks), workgroups in two dimensions; each
//            invocation takes every 64th block, then the workgroup adds up
// units      x W/m; K 1; H W/m2, linear RGB
// layout     rows are receivers, columns senders; texel (x, y) of tile (tile_row, tile_column) of a plane is
//            row tile_row * tile + y, column tile_column * tile + x. Half: block (i, j), j <= i, is number
//            i (i + 1) / 2 + j, in the order of layers, rows and columns of blocks
// limits     16 KiB / 4 of workgroup storage; 262140 patches in one dimension of workgroups, then the second
// tolerance  stored codes: n eps K |x| against f64, eps = 2^-23; sampled codes: what the sampler decodes,
//            probed at start-up

struct ProductParams {
    patch_count: u32,
    tile: u32,
    tiles: u32,
    // 1 or 3: whether there is a texture for each channel.
    planes: u32,
    // Channels of the operator, 1 or 3.
    channels: u32,
    // 1 for the logarithm, 0 for the square root.
    logarithmic: u32,
    shift: f32,
    // 1 for BC1, 0 for BC4.
    bc1: u32,
    scale: vec4<f32>,
    // 1 where half of the matrix is stored.
    half: u32,
    // Columns and rows of blocks of a layer.
    wide: u32,
    high: u32,
    unused: u32,
}

@group(0) @binding(0) var<uniform> params: ProductParams;
@group(0) @binding(1) var<storage, read> patches: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> x: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> outlier_start: array<u32>;
@group(0) @binding(4) var<storage, read> outlier_column: array<u32>;
@group(0) @binding(5) var<storage, read> outlier_value: array<f32>;
@group(0) @binding(6) var<storage, read_write> irradiance: array<vec4<f32>>;

const LANES = 64u;
var<workgroup> partial: array<vec3<f32>, 256>;

// Number of the tile among all planes.
fn tile_index(plane: u32, row: u32, column: u32) -> u32 {
    return (plane * params.tiles + row / params.tile) * params.tiles + column / params.tile;
}

// Code of a texel of half a matrix, or of its mirror image.
fn half_code(row: u32, column: u32) -> vec3<f32> {
    let i = max(row, column);
    let j = min(row, column);
    let number = i / 4u * (i / 4u + 1u) / 2u + j / 4u;
    let in_layer = number % (params.wide * params.high);
    let texel = vec2(in_layer / params.wide * 4u + i % 4u, in_layer % params.wide * 4u + j % 4u);
    return vec3(code(number / (params.wide * params.high), texel.x, texel.y).x);
}

// Code of a texel of the whole matrix in each channel.
fn whole_code(row: u32, column: u32) -> vec3<f32> {
    var u = code(tile_index(0u, row, column), row % params.tile, column % params.tile);
    if params.planes == 3u {
        u.y = code(tile_index(1u, row, column), row % params.tile, column % params.tile).x;
        u.z = code(tile_index(2u, row, column), row % params.tile, column % params.tile).x;
    } else if params.channels == 1u {
        u = vec3(u.x);
    }
    return u;
}

// Value of the operator in each channel, without outliers.
fn texel_value(row: u32, column: u32) -> vec3<f32> {
    var u: vec3<f32>;
    if params.half == 1u {
        u = half_code(row, column);
    } else {
        u = whole_code(row, column);
    }
    if params.logarithmic == 1u {
        return select(vec3(0.0), params.scale.xyz * exp(params.shift * (u - 1.0)), u > vec3(0.0));
    }
    return params.scale.xyz * u * u;
}

fn outlier(entry: u32) -> vec3<f32> {
    if params.channels == 1u {
        return vec3(outlier_value[entry]);
    }
    return vec3(outlier_value[3u * entry], outlier_value[3u * entry + 1u], outlier_value[3u * entry + 2u]);
}

@compute @workgroup_size(64)
fn product(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let n = params.patch_count;
    let first = 4u * (group.y * groups.x + group.x);
    var sums: array<vec3<f32>, 4>;
    for (var block = lane; 4u * block < n && first < n; block += LANES) {
        for (var i = 0u; i < 4u; i += 1u) {
            let column = 4u * block + i;
            let sent = x[column].xyz;
            for (var r = 0u; r < 4u; r += 1u) {
                sums[r] += texel_value(first + r, column) * sent;
            }
        }
    }
    for (var r = 0u; r < 4u && first + r < n; r += 1u) {
        for (var e = outlier_start[first + r] + lane; e < outlier_start[first + r + 1u]; e += LANES) {
            sums[r] += outlier(e) * x[outlier_column[e]].xyz;
        }
    }
    for (var r = 0u; r < 4u; r += 1u) {
        partial[r * LANES + lane] = sums[r];
    }
    for (var step = LANES / 2u; step > 0u; step /= 2u) {
        workgroupBarrier();
        if lane < step {
            for (var r = 0u; r < 4u; r += 1u) {
                partial[r * LANES + lane] += partial[r * LANES + lane + step];
            }
        }
    }
    workgroupBarrier();
    let row = first + lane;
    if lane < 4u && row < n {
        irradiance[row] = vec4(partial[lane * LANES] / patches[row].w, 0.0);
    }
}
