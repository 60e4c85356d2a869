// SPDX-License-Identifier: MIT OR Apache-2.0
//
// direct.wgsl: adds the light of one lamp to points: samples of patches, points of a list, pixels.
//
// equation   lamp.wgsl; times the part of the four nearest texels of the shadow map that do not hide the
//            point, weighted bilinearly
// twin       scene::Rays::visible in crates/gpu-runtime/tests, direct light in crates/relight
// dispatch   64 points a workgroup, workgroups in two dimensions
// units      position metres, local axes, .w > 0 where there is a point; irradiance W/m2, linear RGB
// limits     a texel's depth is compared with the depth of the point's own tangent plane in that texel
//            (J. R. Isidoro, Shadow Mapping: GPU-based Tips and Techniques, 2006), so a lit plane never
//            shadows itself; an occluder nearer to its receiver than 1e-4 of the lamp's distance is lost
// tolerance  3 % of ray-traced light on patches of a room, from texels along the edges of shadows

@group(0) @binding(0) var<uniform> lamp: Lamp;
@group(0) @binding(1) var shadow: texture_depth_2d_array;
@group(0) @binding(2) var<storage, read> position: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> normal: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> irradiance: array<vec4<f32>>;

const PI = 3.14159265358979;
// Shares of the distance, and of the slope across a texel, that depth may be off by rounding: vertices
// are snapped to 1/256 of a texel.
const DISTANCE_SLACK = 1e-4;
const SLOPE_SLACK = 0.02;

// The view whose axis is nearest to the direction of the point.
fn view_of(p: vec3<f32>) -> u32 {
    var best = 0u;
    var depth = along_view(lamp.views[0], p).z;
    for (var v = 1u; v < lamp.view_count; v += 1u) {
        let z = along_view(lamp.views[v], p).z;
        if z > depth {
            best = v;
            depth = z;
        }
    }
    return best;
}

// Distance along the view's axis of the surface in a texel.
fn stored(view: View, layer: u32, texel: vec2<i32>) -> f32 {
    let depth = textureLoad(shadow, texel, layer, 0);
    if view.perspective == 1u {
        return view.reach / max(depth, 1e-30);
    }
    return (1.0 - depth) * view.reach;
}

fn lit(p: vec3<f32>, n: vec3<f32>) -> f32 {
    let layer = view_of(p);
    let view = lamp.views[layer];
    let seen = along_view(view, p);
    // The tangent plane, dot(m, seen) = k, in the view's axes.
    let m = vec3(
        dot(n, view.right.xyz) / dot(view.right.xyz, view.right.xyz),
        dot(n, view.up.xyz) / dot(view.up.xyz, view.up.xyz),
        dot(n, view.forward.xyz),
    );
    let k = dot(m, seen);
    let ndc = select(seen.xy, seen.xy / seen.z, view.perspective == 1u);
    let size = f32(lamp.resolution);
    let at = (ndc * vec2(0.5, -0.5) + 0.5) * size - 0.5;
    let low = floor(at);
    let part = at - low;
    var texels: array<vec2<i32>, 4>;
    var plane: vec4<f32>;
    for (var i = 0; i < 4; i += 1) {
        let corner = vec2<i32>(low) + vec2(i & 1, i >> 1u);
        texels[i] = clamp(corner, vec2(0), vec2(i32(lamp.resolution) - 1));
        let c = ((vec2<f32>(texels[i]) + 0.5) / size - 0.5) * vec2(2.0, -2.0);
        if view.perspective == 1u {
            let slope = dot(m, vec3(c, 1.0));
            plane[i] = select(seen.z, k / slope, slope * k > 0.0);
        } else {
            plane[i] = select(seen.z, (k - dot(m.xy, c)) / m.z, abs(m.z) > 1e-6);
        }
    }
    let off = abs(plane - vec4(seen.z));
    let slack = DISTANCE_SLACK * select(view.reach, seen.z, view.perspective == 1u)
        + SLOPE_SLACK * max(max(off.x, off.y), max(off.z, off.w));
    var open: vec4<f32>;
    for (var i = 0; i < 4; i += 1) {
        // Where planes meet, the own plane may run behind the other one; then the own distance counts.
        open[i] = f32(stored(view, layer, texels[i]) >= min(plane[i], seen.z) - slack);
    }
    return mix(mix(open.x, open.y, part.x), mix(open.z, open.w, part.x), part.y);
}

// Unshadowed irradiance.
fn arriving(p: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    if lamp.kind == DIRECTIONAL {
        return lamp.colour * max(-dot(n, lamp.axis), 0.0);
    }
    let way = lamp.position - p;
    let d2 = max(dot(way, way), 1e-12);
    let to_lamp = way * inverseSqrt(d2);
    let cosine = max(dot(n, to_lamp), 0.0);
    if lamp.kind == POINT {
        return lamp.colour * cosine / d2;
    }
    let leaving = -dot(to_lamp, lamp.axis);
    if lamp.kind == SURFACE {
        return lamp.colour * lamp.area * cosine * max(leaving, 0.0) / (d2 + lamp.area / PI);
    }
    let angle = atan2(length(cross(to_lamp, lamp.axis)), leaving);
    var fade = f32(angle <= lamp.half_angle);
    if lamp.penumbra > 0.0 {
        fade = smoothstep(0.0, 1.0, (lamp.half_angle - angle) / lamp.penumbra);
    }
    return lamp.colour * fade * cosine / d2;
}

@compute @workgroup_size(64)
fn direct(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= arrayLength(&position) || position[i].w <= 0.0 {
        return;
    }
    let light = arriving(position[i].xyz, normal[i].xyz);
    if any(light > vec3(0.0)) {
        irradiance[i] += vec4(light * lit(position[i].xyz, normal[i].xyz), 0.0);
    }
}
