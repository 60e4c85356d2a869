// SPDX-License-Identifier: MIT OR Apache-2.0
//
// hmatrix_gather.wgsl: first step of the product with hierarchical blocks, what every triple gathers.
//
// equation   t = C^T x in every cluster
// twin       gather in crates/hmatrix/src/kernels.rs
// dispatch   one workgroup for two panels; an invocation takes four lanes at every eighth place of its panel
// units      x W/m of patches, W/m2 of senders of a rectangle, linear RGB; codes 1, so t is as x
// layout     light: x of each sender, then t of each lane; codes: 16 signed bytes at each place of a panel, as 4 words
// bytes      all codes of panels once, 4 bytes a place of a cluster: 1.2 MB in 910 workgroups for 5175 patches at 1 %
// limits     3 KiB of workgroup storage
// tolerance  places eps |C|^T |x|, eps = 2^-23

struct Panel {
    // Where its codes start, in fours of words.
    codes: u32,
    place: u32,
    len: u32,
    // Where in light its sums go.
    sums: u32,
}

@group(0) @binding(0) var<storage, read> panels: array<Panel>;
@group(0) @binding(1) var<storage, read> codes: array<u32>;
// Sender at each place, and the bits of what its light is multiplied by.
@group(0) @binding(2) var<storage, read> places: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> light: array<vec4<f32>>;

const PHASES = 8u;
// Of four lanes each.
var<workgroup> red: array<vec4<f32>, 64>;
var<workgroup> green: array<vec4<f32>, 64>;
var<workgroup> blue: array<vec4<f32>, 64>;

@compute @workgroup_size(64)
fn hmatrix_gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let number = 2u * (group.y * groups.x + group.x) + invocation / 32u;
    let inside = invocation % 32u;
    var r = vec4(0.0);
    var g = vec4(0.0);
    var b = vec4(0.0);
    if number < arrayLength(&panels) {
        let panel = panels[number];
        for (var k = inside / 4u; k < panel.len; k += PHASES) {
            let code = vec4<f32>(unpack4xI8(codes[4u * (panel.codes + k) + inside % 4u]));
            let place = places[panel.place + k];
            let sent = bitcast<f32>(place.y) * light[place.x].xyz;
            r += code * sent.x;
            g += code * sent.y;
            b += code * sent.z;
        }
    }
    red[invocation] = r;
    green[invocation] = g;
    blue[invocation] = b;
    workgroupBarrier();
    if inside < 16u && number < arrayLength(&panels) {
        var sum = vec3(0.0);
        let first = invocation - inside + inside / 4u;
        for (var phase = 0u; phase < PHASES; phase += 1u) {
            let other = first + 4u * phase;
            sum += vec3(red[other][inside % 4u], green[other][inside % 4u], blue[other][inside % 4u]);
        }
        light[panels[number].sums + inside] = vec4(sum, 0.0);
    }
}
