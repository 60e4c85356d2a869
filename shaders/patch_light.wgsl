// SPDX-License-Identifier: MIT OR Apache-2.0
//
// patch_light.wgsl: direct irradiance of patches, the mean over the points on each of them.
//
// equation   H0_i = (1 / S) sum_s H0(i, s) + pi L_sky sky_i
// twin       mean of crates/gpu-runtime/tests, direct light in crates/relight
// dispatch   64 patches a workgroup, workgroups in two dimensions
// units      W/m2, linear RGB; sky 1
// layout     the samples of a patch lie together
// tolerance  S eps max(H0), eps = 2^-23

struct PatchLightParams {
    patch_count: u32,
    samples: u32,
    unused_a: u32,
    unused_b: u32,
    // pi L_sky, W/m2.
    sky: vec4<f32>,
}

@group(0) @binding(0) var<uniform> params: PatchLightParams;
@group(0) @binding(1) var<storage, read> sample_light: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> sky_share: array<f32>;
@group(0) @binding(3) var<storage, read_write> h0: array<vec4<f32>>;

@compute @workgroup_size(64)
fn patch_light(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= params.patch_count {
        return;
    }
    var sum = vec3(0.0);
    for (var s = 0u; s < params.samples; s += 1u) {
        sum += sample_light[i * params.samples + s].xyz;
    }
    h0[i] = vec4(sum / f32(params.samples) + params.sky.xyz * sky_share[i], 0.0);
}
