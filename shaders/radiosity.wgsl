// SPDX-License-Identifier: MIT OR Apache-2.0
//
// radiosity.wgsl: what patches send into the last gather, all bounces so far.
//
// equation   B = rho (H0 + H)
// twin       relight::radiosity
// dispatch   64 patches a workgroup, workgroups in two dimensions
// units      H0, H, B W/m2, linear RGB; patches: rho in .xyz
// tolerance  2 eps B, eps = 2^-23

@group(0) @binding(0) var<storage, read> patches: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> h0: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> h: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> b: array<vec4<f32>>;

@compute @workgroup_size(64)
fn radiosity(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i < arrayLength(&patches) {
        b[i] = vec4(patches[i].xyz * (h0[i].xyz + h[i].xyz), 0.0);
    }
}
