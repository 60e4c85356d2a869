// SPDX-License-Identifier: MIT OR Apache-2.0
//
// hmatrix_scatter.wgsl: last step of the product with hierarchical blocks, the rows of the result.
//
// equation   H = A^{-1/2} (C t + squares of the codes of tiles x columns + entries that stand apart); in a rectangle there is
//            1 in place of sqrt(A), and each row adds its share of the sky; what packing took below 0 is 0
// twin       HMatrix::leaf in crates/hmatrix/src/hmatrix.rs, then not_negative in crates/relight/src/product.rs
// dispatch   one workgroup for eight rows of a leaf; 32 invocations a row take panels in turn, a quarter of one each
// units      carried, light W/m; H W/m2, linear RGB
// layout     leaves: for each its first place and number of rows, then runs of panels: where their codes start, codes
//            from one panel to the next, first panel, number of panels; the last run is of tiles. Codes are those of
//            16 lanes or columns at a row, 4 words; eight rows of a panel are 128 bytes that stand together
// bytes      all codes of panels and tiles once, carried of each panel once a leaf in it: 1.8 MB of codes and 12 bytes
//            a lane in 768 workgroups for 5175 patches at 1 %
// limits     4 KiB of workgroup storage
// tolerance  summands of a row x eps |C| |t|, eps = 2^-23

struct ScatterParams {
    // Workgroups of a leaf.
    parts: u32,
    // Runs of a leaf.
    runs: u32,
    unused_a: u32,
    unused_b: u32,
    // Irradiance of a whole sky in .xyz, pi L; 0 in symmetric operators.
    sky: vec4<f32>,
}

@group(0) @binding(0) var<uniform> params: ScatterParams;
@group(0) @binding(1) var<storage, read> leaves: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> codes: array<u32>;
@group(0) @binding(3) var<storage, read> carried: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> light: array<vec4<f32>>;
// Receiver of each row, and where its entries that stand apart start.
@group(0) @binding(5) var<storage, read> rows: array<vec2<u32>>;
// Sender, and the bits of the entry.
@group(0) @binding(6) var<storage, read> apart: array<vec2<u32>>;
// Of receivers: what they are divided by in .w, and, of a rectangle, their share of the sky in .x.
@group(0) @binding(7) var<storage, read> receivers: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> irradiance: array<vec4<f32>>;

const ROWS = 8u;
const PHASES = 8u;
var<workgroup> partial: array<vec3<f32>, 256>;

@compute @workgroup_size(256)
fn hmatrix_scatter(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let number = group.y * groups.x + group.x;
    let quad = invocation % 4u;
    let phase = invocation / 32u;
    let first = number / params.parts * (params.runs + 1u);
    let above = number % params.parts * ROWS;
    let row = above + invocation / 4u % ROWS;
    var sum = vec3(0.0);
    if first < arrayLength(&leaves) && row < leaves[first].y {
        // Runs are short, so phases go on in the next one where they stopped.
        var turn = phase;
        for (var r = 1u; r <= params.runs; r += 1u) {
            let run = leaves[first + r];
            for (var k = turn; k < run.w; k += PHASES) {
                let word = codes[4u * (run.x + k * run.y + row) + quad];
                var code = vec4<f32>(unpack4xI8(word));
                if r == params.runs {
                    code = vec4<f32>(unpack4xU8(word));
                    code *= code;
                }
                let at = 12u * (run.z + k) + 3u * quad;
                sum += vec3(dot(code, carried[at]), dot(code, carried[at + 1u]), dot(code, carried[at + 2u]));
            }
            turn = (turn + PHASES - run.w % PHASES) % PHASES;
        }
        let place = leaves[first].x + row;
        for (var e = rows[place].y + 4u * phase + quad; e < rows[place + 1u].y; e += 4u * PHASES) {
            sum += bitcast<f32>(apart[e].y) * light[apart[e].x].xyz;
        }
    }
    partial[invocation] = sum;
    workgroupBarrier();
    if invocation < 4u * ROWS {
        for (var k = 1u; k < PHASES; k += 1u) {
            sum += partial[invocation + 4u * ROWS * k];
        }
        partial[invocation] = sum;
    }
    workgroupBarrier();
    let last = above + invocation;
    if invocation < ROWS && first < arrayLength(&leaves) && last < leaves[first].y {
        let own = rows[leaves[first].x + last].x;
        let receiver = receivers[own];
        let q = 4u * invocation;
        let y = partial[q] + partial[q + 1u] + (partial[q + 2u] + partial[q + 3u]);
        let light = select(y, vec3(0.0), y < vec3(0.0));
        irradiance[own] = vec4(light / receiver.w + receiver.x * params.sky.xyz, 0.0);
    }
}
