// SPDX-License-Identifier: MIT OR Apache-2.0
//
// colour_core.wgsl: second step of colour, the small cores of the components. Joined behind colour.wgsl.
//
// equation   z_c = (sum_p e_pc C_p) t_c in every component, for red, green and blue
// twin       TextureProduct::carry in crates/relight/src/textures.rs
// dispatch   one invocation for a column
// units      t and z W/m, linear RGB
// layout     cores are symmetric, rank x rank entries of red, green and blue
// tolerance  rank eps |C| |t|, eps = 2^-23

@group(0) @binding(0) var<storage, read> columns: array<Column>;
@group(0) @binding(1) var<storage, read> cores: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> gathered: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> carried: array<vec4<f32>>;

@compute @workgroup_size(64)
fn colour_core(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let number = 64u * (group.y * groups.x + group.x) + lane;
    if number >= arrayLength(&columns) {
        return;
    }
    let column = columns[number];
    var sum = vec4(0.0);
    for (var k = 0u; k < column.rank; k += 1u) {
        sum += cores[column.core + k * column.rank + number - column.first] * gathered[column.first + k];
    }
    carried[number] = sum;
}
