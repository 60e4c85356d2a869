// SPDX-License-Identifier: MIT OR Apache-2.0
//
// gather.wgsl: irradiance at receivers from irradiance of patches.
//
// equation   H_r = sum_i w_ri (share H_i + pi L_sky sky_i)
// twin       radfile::Rows::gather
// dispatch   64 receivers a workgroup, workgroups in two dimensions
// units      H W/m2, linear RGB; weights, share, sky 1
// layout     compressed rows: the entries of receiver r are row_start[r] .. row_start[r + 1]
// tolerance  entries of a row x eps max(H), eps = 2^-23

struct GatherParams {
    receivers: u32,
    // 1 where the light of the patches counts, 0 where only the sky does.
    share: f32,
    unused_a: u32,
    unused_b: u32,
    // pi L_sky, W/m2.
    sky: vec4<f32>,
}

@group(0) @binding(0) var<uniform> params: GatherParams;
@group(0) @binding(1) var<storage, read> row_start: array<u32>;
@group(0) @binding(2) var<storage, read> sender: array<u32>;
@group(0) @binding(3) var<storage, read> weight: array<f32>;
@group(0) @binding(4) var<storage, read> patch_light: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> sky_share: array<f32>;
@group(0) @binding(6) var<storage, read_write> irradiance: array<vec4<f32>>;

@compute @workgroup_size(64)
fn gather(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let r = id.y * groups.x * 64u + id.x;
    if r >= params.receivers {
        return;
    }
    var sum = vec3(0.0);
    for (var e = row_start[r]; e < row_start[r + 1u]; e += 1u) {
        let i = sender[e];
        sum += weight[e] * (params.share * patch_light[i].xyz + params.sky.xyz * sky_share[i]);
    }
    irradiance[r] = vec4(sum, 0.0);
}
