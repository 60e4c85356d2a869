// SPDX-License-Identifier: MIT OR Apache-2.0
//
// shadow_map.wgsl: the nearest surface in every direction of a lamp's view, depth only.
//
// equation   view.wgsl; the instance number is the number of the view
// twin       scene::Rays::closest
// dispatch   one indexed draw of the whole mesh for each view, both sides
// units      metres, local axes
// limits     what lies nearer to a lamp than View.reach casts no shadow
// tolerance  one texel sideways

@group(0) @binding(0) var<uniform> lamp: Lamp;

@vertex
fn shadow_map(@location(0) position: vec3<f32>, @builtin(instance_index) view: u32) -> @builtin(position) vec4<f32> {
    return clip_position(lamp.views[view], position);
}
