// SPDX-License-Identifier: MIT OR Apache-2.0
//
// hmatrix_exchange.wgsl: second step of the product with hierarchical blocks, what every lane carries.
//
// equation   a lane of triples takes what the other end of its triple gathered, times the triple's scale; the first
//            lane of a cluster takes the means of blocks as well; a column of a tile takes what its patch sends, times
//            the tile's scale
// twin       HMatrix::exchange in crates/hmatrix/src/hmatrix.rs
// dispatch   one invocation a lane, four panels a workgroup; the lanes of a panel share its means
// units      light, carried W/m, linear RGB; factors 1
// layout     terms: one a lane, 16 a panel, then the means, those of panel p from mean_start[p] on; panels of columns
//            come last and have no means. carried: four lanes of red, of green, of blue; the next four lanes; …
// bytes      16 a lane and mean: 0.9 MB in about 800 workgroups for 5175 patches at 1 %
// limits     1 KiB of workgroup storage
// tolerance  means of a panel x eps |carried|, eps = 2^-23

struct Term {
    factor: vec3<f32>,
    // Which element of light.
    source: u32,
}

@group(0) @binding(0) var<storage, read> terms: array<Term>;
@group(0) @binding(1) var<storage, read> mean_start: array<u32>;
@group(0) @binding(2) var<storage, read> light: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> carried: array<f32>;

const LANES = 16u;
var<workgroup> means: array<vec3<f32>, 64>;

fn value(number: u32) -> vec3<f32> {
    let term = terms[number];
    return term.factor * light[term.source].xyz;
}

@compute @workgroup_size(64)
fn hmatrix_exchange(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let own = 64u * (group.y * groups.x + group.x) + invocation;
    let panel = own / LANES;
    let lane = own % LANES;
    var mean = vec3(0.0);
    if panel + 1u < arrayLength(&mean_start) {
        for (var m = mean_start[panel] + lane; m < mean_start[panel + 1u]; m += LANES) {
            mean += value(m);
        }
    }
    means[invocation] = mean;
    workgroupBarrier();
    if 3u * own >= arrayLength(&carried) {
        return;
    }
    var sum = value(own);
    if lane == 0u {
        for (var k = 0u; k < LANES; k += 1u) {
            sum += means[invocation + k];
        }
    }
    let to = 3u * LANES * panel + 12u * (lane / 4u) + lane % 4u;
    carried[to] = sum.x;
    carried[to + 4u] = sum.y;
    carried[to + 8u] = sum.z;
}
