// SPDX-License-Identifier: MIT OR Apache-2.0
//
// view.wgsl: from a point of the scene to what a lamp or a camera sees. Joined in front of the
// shaders that use it; holds no entry point.
//
// equation   perspective: ndc = (right.p, up.p) / forward.p, depth = near / forward.p
//            parallel:    ndc = (right.p, up.p),             depth = 1 - forward.p / range
//            Both depths fall from 1 to 0 with distance, so that single precision is spread evenly.
// twin       crates/gpu-runtime/src/view.rs
// units      metres, local axes; ndc and depth 1
// layout     rows hold a vector and its offset: right.p stands for dot(right.xyz, p) + right.w

struct View {
    right: vec4<f32>,
    up: vec4<f32>,
    forward: vec4<f32>,
    // Nearest distance of a perspective, or the range of a parallel view, metres.
    reach: f32,
    // 1 for a perspective, 0 for a parallel view.
    perspective: u32,
    unused_a: u32,
    unused_b: u32,
}

fn along_view(view: View, p: vec3<f32>) -> vec3<f32> {
    return vec3(
        dot(view.right.xyz, p) + view.right.w,
        dot(view.up.xyz, p) + view.up.w,
        dot(view.forward.xyz, p) + view.forward.w,
    );
}

fn clip_position(view: View, p: vec3<f32>) -> vec4<f32> {
    let seen = along_view(view, p);
    if view.perspective == 1u {
        return vec4(seen.xy, view.reach, seen.z);
    }
    return vec4(seen.xy, 1.0 - seen.z / view.reach, 1.0);
}
