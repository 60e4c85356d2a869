// SPDX-License-Identifier: MIT OR Apache-2.0
//
// radiosity.wgsl: what patches and their elements send into the last gather, all bounces so far.
//
// equation   B_e = rho_e (H0_e + H_p), p the patch that e is part of; B_p = sum_e share_e B_e
// twin       relight::radiosity
// dispatch   64 patches a workgroup, workgroups in two dimensions
// units      H0, H, B W/m2, linear RGB; elements: rho in .xyz, share of the patch's area in .w
// layout     the elements of patch p are start[p] .. start[p + 1]; in b the patches come first
// tolerance  2 eps B, eps = 2^-23; of a patch that times its elements

@group(0) @binding(0) var<storage, read> elements: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> start: array<u32>;
@group(0) @binding(2) var<storage, read> h0: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> h: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> b: array<vec4<f32>>;

@compute @workgroup_size(64)
fn radiosity(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let p = id.y * groups.x * 64u + id.x;
    let patches = arrayLength(&start) - 1u;
    if p >= patches {
        return;
    }
    var mean = vec3(0.0);
    for (var e = start[p]; e < start[p + 1u]; e += 1u) {
        let light = elements[e].xyz * (h0[e].xyz + h[p].xyz);
        b[patches + e] = vec4(light, 0.0);
        mean += elements[e].w * light;
    }
    b[p] = vec4(mean, 0.0);
}
