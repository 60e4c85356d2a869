// SPDX-License-Identifier: MIT OR Apache-2.0
//
// colour_scatter.wgsl: last step of colour, which is added to what luma brought. Joined behind colour.wgsl.
//
// equation   H += A^{-1/2} U z
// twin       Scatter in crates/relight/src/textures.rs
// dispatch   one invocation for a member of a component
// units      z W/m; H W/m2, linear RGB
// limits     a patch is a member of one component at most, so no two invocations write the same place
// tolerance  rank eps |U| |z|, eps = 2^-23

@group(0) @binding(0) var<storage, read> columns: array<Column>;
@group(0) @binding(1) var<storage, read> members: array<Member>;
@group(0) @binding(2) var<storage, read> codes: array<u32>;
@group(0) @binding(3) var<storage, read> patches: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> carried: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> irradiance: array<vec4<f32>>;

@compute @workgroup_size(64)
fn colour_scatter(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let number = 64u * (group.y * groups.x + group.x) + lane;
    if number >= arrayLength(&members) {
        return;
    }
    let member = members[number];
    let first = columns[member.first];
    let own = number - first.members;
    let words = (first.count + 3u) / 4u;
    var sum = vec4(0.0);
    for (var k = 0u; k < first.rank; k += 1u) {
        let values = unpack4xI8(codes[first.codes + k * words + own / 4u]);
        sum += f32(values[own % 4u]) * carried[member.first + k];
    }
    let i = member.patch_number;
    irradiance[i] += vec4(sum.xyz * member.scale / patches[i].w, 0.0);
}
