// SPDX-License-Identifier: MIT OR Apache-2.0
//
// element_light.wgsl: direct irradiance of elements, the mean over the points on each of them.
//
// equation   H0_e = (1 / S_e) sum_s H0(e, s) + pi L_sky sky_e
// twin       relight::element_irradiance
// dispatch   64 elements a workgroup, workgroups in two dimensions
// units      W/m2, linear RGB; sky 1
// layout     the samples of an element lie together, range[e].x .. range[e].y
// tolerance  S_e eps max(H0), eps = 2^-23

struct ElementLightParams {
    // pi L_sky, W/m2.
    sky: vec4<f32>,
}

@group(0) @binding(0) var<uniform> params: ElementLightParams;
@group(0) @binding(1) var<storage, read> sample_light: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> range: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> sky_share: array<f32>;
@group(0) @binding(4) var<storage, read_write> h0: array<vec4<f32>>;

@compute @workgroup_size(64)
fn element_light(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let e = id.y * groups.x * 64u + id.x;
    if e >= arrayLength(&range) {
        return;
    }
    var sum = vec3(0.0);
    for (var s = range[e].x; s < range[e].y; s += 1u) {
        sum += sample_light[s].xyz;
    }
    let mean = sum / f32(range[e].y - range[e].x);
    h0[e] = vec4(mean + params.sky.xyz * sky_share[e], 0.0);
}
