// SPDX-License-Identifier: MIT OR Apache-2.0
//
// colour_gather.wgsl: first step of colour, what every column of U gathers. Joined behind colour.wgsl.
//
// equation   t = U^T x
// twin       Gather in crates/relight/src/textures.rs
// dispatch   one workgroup for a column; each invocation takes every 64th word of codes
// units      x W/m; U 1; t W/m, linear RGB
// tolerance  members eps |U|^T |x|, eps = 2^-23

@group(0) @binding(0) var<storage, read> columns: array<Column>;
@group(0) @binding(1) var<storage, read> members: array<Member>;
@group(0) @binding(2) var<storage, read> codes: array<u32>;
@group(0) @binding(3) var<storage, read> x: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> gathered: array<vec4<f32>>;

const LANES = 64u;
var<workgroup> partial: array<vec4<f32>, 64>;

@compute @workgroup_size(64)
fn colour_gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let number = group.y * groups.x + group.x;
    var sum = vec4(0.0);
    if number < arrayLength(&columns) {
        let column = columns[number];
        for (var word = lane; 4u * word < column.count; word += LANES) {
            let values = vec4<f32>(unpack4xI8(codes[column.codes + word]));
            for (var i = 0u; i < 4u && 4u * word + i < column.count; i += 1u) {
                let member = members[column.members + 4u * word + i];
                sum += values[i] * member.scale * x[member.patch_number];
            }
        }
    }
    partial[lane] = sum;
    for (var step = LANES / 2u; step > 0u; step /= 2u) {
        workgroupBarrier();
        if lane < step {
            partial[lane] += partial[lane + step];
        }
    }
    if lane == 0u && number < arrayLength(&columns) {
        gathered[number] = partial[0];
    }
}
