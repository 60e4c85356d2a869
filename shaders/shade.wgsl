// SPDX-License-Identifier: MIT OR Apache-2.0
//
// shade.wgsl: radiance of each pixel from what it sees and the light that arrives there.
//
// equation   L = rho (H_direct + H_indirect) / pi + L_emitted; H_indirect is interpolated between the
//            receivers of the triangle's corners on the side that is seen, leaving out corners without one
// twin       pictures of crates/relight
// dispatch   64 pixels a workgroup, workgroups in two dimensions
// units      H W/m2, L W/(m2 sr), linear RGB
// layout     buffers of surface.wgsl's targets, row-major, rows of `pitch` samples, detail x detail samples a
//            pixel; receivers: six a triangle, the front's corners, then the back's, 0xffffffff for none
// tolerance  8 eps L, eps = 2^-23

struct ShadeParams {
    width: u32,
    height: u32,
    pitch: u32,
    // Samples along the edge of a pixel.
    detail: u32,
    // 1 where surfaces that emit are shown shining.
    glow: f32,
    unused_a: u32,
    unused_b: u32,
    unused_c: u32,
    // Radiance where no surface is seen, W/(m2 sr).
    background: vec4<f32>,
}

@group(0) @binding(0) var<uniform> params: ShadeParams;
@group(0) @binding(1) var<storage, read> position: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> normal: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> reflectance: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> emission: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> receivers: array<u32>;
@group(0) @binding(6) var<storage, read> receiver_light: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> direct_light: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> radiance: array<vec4<f32>>;

const PI = 3.14159265358979;
const NO_RECEIVER = 0xffffffffu;

fn interpolated(at: u32) -> vec3<f32> {
    let side = normal[at].w >> 31u;
    let triangle = normal[at].w & 0x7fffffffu;
    let second = reflectance[at].w;
    let third = emission[at].w;
    let weights = vec3(1.0 - second - third, second, third);
    var sum = vec3(0.0);
    var total = 0.0;
    for (var k = 0u; k < 3u; k += 1u) {
        let r = receivers[6u * triangle + 3u * side + k];
        if r != NO_RECEIVER {
            sum += weights[k] * receiver_light[r].xyz;
            total += weights[k];
        }
    }
    return select(vec3(0.0), sum / total, total > 1e-6);
}

fn sample_radiance(at: u32) -> vec3<f32> {
    if position[at].w <= 0.0 {
        return params.background.xyz;
    }
    let light = direct_light[at].xyz + interpolated(at);
    return reflectance[at].xyz * light / PI + params.glow * emission[at].xyz;
}

@compute @workgroup_size(64)
fn shade(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= params.width * params.height {
        return;
    }
    let corner = params.detail * (i / params.width * params.pitch + i % params.width);
    var sum = vec3(0.0);
    for (var y = 0u; y < params.detail; y += 1u) {
        for (var x = 0u; x < params.detail; x += 1u) {
            sum += sample_radiance(corner + y * params.pitch + x);
        }
    }
    radiance[i] = vec4(sum / f32(params.detail * params.detail), 0.0);
}
