// SPDX-License-Identifier: MIT OR Apache-2.0
//
// lamp.wgsl: one lamp of a frame and its shadow views. Joined in front of the shaders that use it,
// behind view.wgsl; holds no entry point.
//
// equation   H0 = intensity cos / d2              point and spot (times the spot's fade)
//            H0 = irradiance cos                  directional
//            H0 = radiance area cos cos' / (d2 + area / pi)   a piece of a shining surface, taken as a
//                 disc: exact on the disc's axis at any distance, and finite next to it
// twin       crates/gpu-runtime/src/lamp.rs fills it
// units      colour: W/sr, W/m2 or W/(m2 sr) by kind; area m2; angles rad
// limits     at most 6 views: a cube about a point, 5 of its faces over a surface, 1 for a narrow spot

const POINT = 0u;
const SPOT = 1u;
const DIRECTIONAL = 2u;
const SURFACE = 3u;

struct Lamp {
    views: array<View, 6>,
    position: vec3<f32>,
    kind: u32,
    // The way the light travels, or the normal of the shining surface; a unit vector.
    axis: vec3<f32>,
    view_count: u32,
    colour: vec3<f32>,
    // Edge of the square of the shadow map that is used, texels.
    resolution: u32,
    half_angle: f32,
    penumbra: f32,
    area: f32,
    unused: u32,
}
