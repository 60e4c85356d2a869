// SPDX-License-Identifier: MIT OR Apache-2.0
//
// surface.wgsl: what each pixel sees: position, normal, triangle, reflectance, emission. No light yet.
//
// equation   view.wgsl; reflectance = min(factor x texture, 0.99), both linear
// twin       scene::Rays::closest with scene::Surfaces
// dispatch   one draw for each material over the fine mesh, both sides
// units      position metres, local axes; reflectance 1; emission W/(m2 sr)
// layout     four targets of four words, floats as bits:
//            0: position, 1 where there is a surface
//            1: unit normal towards the camera, triangle of the fine mesh (bit 31: its back is seen)
//            2: reflectance, weight of the second corner
//            3: emission, weight of the third corner
// limits     textures are read at their finest level, so what is far away may flicker
// tolerance  1e-5 of the scene's size in position; 1/255 in texels

struct Material {
    reflectance: vec4<f32>,
    // .w is 1 where back sides reflect nothing.
    emission: vec4<f32>,
}

struct Camera {
    view: View,
    // The eye, metres, local axes.
    eye: vec4<f32>,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var reflectance_texture: texture_2d<f32>;
@group(1) @binding(2) var reflectance_sampler: sampler;
@group(1) @binding(3) var emission_texture: texture_2d<f32>;
@group(1) @binding(4) var emission_sampler: sampler;

const MAX_REFLECTANCE = 0.99;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) @interpolate(flat) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) emission_uv: vec2<f32>,
    @location(4) weights: vec2<f32>,
    @location(5) @interpolate(flat) triangle: u32,
}

struct Seen {
    @location(0) position: vec4<u32>,
    @location(1) normal: vec4<u32>,
    @location(2) reflectance: vec4<u32>,
    @location(3) emission: vec4<u32>,
}

@vertex
fn surface(
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) emission_uv: vec2<f32>,
    @builtin(vertex_index) index: u32,
) -> Corner {
    let k = index % 3u;
    let weights = vec2(f32(k == 1u), f32(k == 2u));
    return Corner(clip_position(camera.view, position), position, normal, uv, emission_uv, weights, index / 3u);
}

@fragment
fn seen(corner: Corner) -> Seen {
    let front = dot(corner.normal, camera.eye.xyz - corner.position) >= 0.0;
    let texel = textureSampleLevel(reflectance_texture, reflectance_sampler, corner.uv, 0.0).xyz;
    let glow = textureSampleLevel(emission_texture, emission_sampler, corner.emission_uv, 0.0).xyz;
    let dark = !front && material.emission.w > 0.0;
    let reflectance = select(min(material.reflectance.xyz * texel, vec3(MAX_REFLECTANCE)), vec3(0.0), dark);
    let emission = select(vec3(0.0), material.emission.xyz * glow, front);
    let triangle = corner.triangle | select(0x80000000u, 0u, front);
    return Seen(
        vec4(bitcast<vec3<u32>>(corner.position), bitcast<u32>(1.0)),
        vec4(bitcast<vec3<u32>>(select(-corner.normal, corner.normal, front)), triangle),
        vec4(bitcast<vec3<u32>>(reflectance), bitcast<u32>(corner.weights.x)),
        vec4(bitcast<vec3<u32>>(emission), bitcast<u32>(corner.weights.y)),
    );
}
