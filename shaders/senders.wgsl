// SPDX-License-Identifier: MIT OR Apache-2.0
//
// senders.wgsl: what patches send after the first bounce, scaled for the symmetric operator.
//
// equation   x = sqrt(A) rho H0
// twin       the same line in crates/gpu-runtime/tests and crates/relight
// dispatch   64 patches a workgroup, workgroups in two dimensions
// units      H0 W/m2, linear RGB; patches: rho in .xyz, sqrt(A) in .w, metres; x W/m
// layout     x is longer than the patches, up to whole tiles; the rest stays 0
// tolerance  2 eps x, eps = 2^-23

@group(0) @binding(0) var<storage, read> patches: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> h0: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> x: array<vec4<f32>>;

@compute @workgroup_size(64)
fn senders(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i < arrayLength(&patches) {
        x[i] = vec4(patches[i].xyz * patches[i].w * h0[i].xyz, 0.0);
    }
}
