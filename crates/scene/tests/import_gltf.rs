//! glTF files made on the spot, and what becomes of them.

mod import_support;

use glam::{DVec3, Vec3};
use import_support::{Gltf, Memory, area, corners, png, square};
use radfile::Wrap;
use scene::{Light, Surfaces};
use serde_json::{Value, json};

fn normal(corners: [[f64; 3]; 3]) -> DVec3 {
    let [a, b, c] = corners.map(DVec3::from);
    (b - a).cross(c - a).normalize()
}

fn close(a: DVec3, b: [f64; 3]) -> bool {
    (a - DVec3::from(b)).length() < 1e-6
}

#[test]
fn a_square_keeps_its_triangles_material_and_place() {
    let (scene, report) = square().import().unwrap();
    let [a, b, c, d] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    assert_eq!(corners(&scene), [[a, b, c], [a, c, d]]);
    assert_eq!(scene.materials.materials[0].reflectance, [0.5, 0.4, 0.3]);
    assert_eq!((scene.mesh.origin, scene.mesh.uv.len(), scene.mesh.one_sided), ([0.0; 3], 0, false));
    assert_eq!((report.found, report.triangles, report.materials, report.textures), (2, 2, 1, 0));
    assert!(report.warnings.is_empty(), "{:?}", report.warnings);
}

#[test]
fn transforms_of_parents_apply_from_the_root_down_in_depth_first_order() {
    let mut g = square();
    g.json["nodes"] = json!([
        {"translation": [10, 0, 0], "children": [2, 1]},
        {"mesh": 0, "translation": [0, 0, 7]},
        {"mesh": 0, "scale": [2, 2, 2], "rotation": [0, 0, 1, 1], "children": [3]},
        {"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1]}
    ]);
    g.json["scenes"] = json!([{"nodes": [0]}]);
    let (scene, _) = g.import().unwrap();
    let first: Vec<DVec3> = corners(&scene).iter().step_by(2).map(|t| t[1].into()).collect();
    // A quarter turn about z takes x to y.
    assert!(close(first[0], [10.0, 2.0, 0.0]) && close(first[1], [10.0, 2.0, 10.0]), "{first:?}");
    assert!(close(first[2], [11.0, 0.0, 7.0]));
}

#[test]
fn mirrored_nodes_keep_their_front_sides() {
    for (scale, facing) in [([1, 1, 1], 1.0), ([-1, 1, 1], 1.0), ([1, 1, -1], -1.0), ([-1, -1, -1], -1.0)] {
        let mut g = square();
        g.json["nodes"] = json!([{"mesh": 0, "scale": scale}]);
        let (scene, _) = g.import().unwrap();
        // The front side looks where the transform takes it, as the normal of an unmirrored twin would.
        assert!(corners(&scene).iter().all(|&t| close(normal(t), [0.0, 0.0, facing])), "{scale:?}");
    }
}

#[test]
fn nodes_with_map_coordinates_keep_millimetres() {
    let mut g = square();
    g.json["nodes"] = json!([
        {"mesh": 0, "translation": [500000.001, 200, 4649776.002]},
        {"mesh": 0, "translation": [500003.004, 200, 4649776.006]}
    ]);
    let (scene, report) = g.import().unwrap();
    let at = |t: usize| DVec3::from(corners(&scene)[t][0]);
    assert!((at(2) - at(0) - DVec3::new(3.003, 0.0, 0.004)).length() < 1e-6);
    assert!((at(0) - DVec3::new(500000.001, 200.0, 4649776.002)).length() < 1e-6);
    assert!(report.warnings[0].starts_with("coordinates are large"), "{:?}", report.warnings);
}

#[test]
fn the_default_scene_is_read_or_all_of_them_or_the_whole_file() {
    for (scene, scenes, expected) in [
        (json!(1), json!([{"nodes": [0]}, {"nodes": [1, 2]}]), 4),
        (Value::Null, json!([{"nodes": [0]}, {"nodes": [1, 0]}]), 4),
        (Value::Null, json!([]), 6),
    ] {
        let mut g = square();
        let at = |x: i32| json!({"mesh": 0, "translation": [x, 0, 0]});
        g.json["nodes"] = json!([at(0), at(2), at(4)]);
        (g.json["scene"], g.json["scenes"]) = (scene, scenes);
        assert_eq!(g.import().unwrap().1.triangles, expected);
    }
}

#[test]
fn strips_fans_and_lists_without_indices_make_the_same_square() {
    let [a, b, c, d] = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    for (mode, points) in [(5, vec![a, b, d, c]), (6, vec![a, b, c, d]), (4, vec![a, b, c, a, c, d])] {
        let mut g = square();
        let positions = g.floats(&points);
        g.json["meshes"][0]["primitives"] = json!([{"attributes": {"POSITION": positions}, "mode": mode}]);
        let (scene, report) = g.import().unwrap();
        assert_eq!((report.triangles, area(&scene)), (2, 1.0), "mode {mode}");
        assert!(corners(&scene).iter().all(|&t| close(normal(t), [0.0, 0.0, 1.0])), "mode {mode}");
        assert_eq!(report.warnings, ["primitives without a material are grey 0.5"]);
        assert_eq!(scene.materials.materials[0].reflectance, [0.5; 3]);
    }
}

#[test]
fn points_and_lines_are_counted_and_a_file_of_nothing_else_is_empty() {
    let mut g = square();
    g.json["meshes"][0]["primitives"][0]["mode"] = json!(1);
    let error = g.import().unwrap_err().to_string();
    assert_eq!(error, "s.glb: no usable triangle (primitives of points and lines are ignored: 1)");
}

#[test]
fn quantised_positions_are_what_their_integers_mean() {
    for (component, normalized, bytes, expected) in [
        (5122, true, [0i16, 32767, -32768].map(i16::to_le_bytes).concat(), [0.0, 1.0, -1.0]),
        (5122, false, [0i16, 300, -7].map(i16::to_le_bytes).concat(), [0.0, 300.0, -7.0]),
        (5120, true, vec![0, 127, 128], [0.0, 1.0, -1.0]),
        (5121, true, vec![0, 255, 51], [0.0, 1.0, 0.2]),
        (5123, false, [0u16, 65535, 9].map(u16::to_le_bytes).concat(), [0.0, 65535.0, 9.0]),
    ] {
        let mut g = square();
        g.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let size = bytes.len() / 3;
        let component_at = |k: usize| &bytes[k * size..(k + 1) * size];
        // Three corners: (0, 0, 0), (x, 0, 0), (0, y, 0) of the numbers above, padded to four bytes.
        let stride = (3 * size).next_multiple_of(4);
        let mut data = vec![];
        for corner in [[0, 0, 0], [1, 0, 0], [0, 2, 0]] {
            let start = data.len();
            corner.iter().for_each(|&k| data.extend(component_at(k)));
            data.resize(start + stride, 0);
        }
        let view = g.view(&data);
        g.json["bufferViews"][view]["byteStride"] = json!(stride);
        let accessor = json!({"bufferView": view, "componentType": component, "normalized": normalized, "count": 3, "type": "VEC3"});
        let positions = g.push("accessors", accessor);
        g.json["meshes"][0]["primitives"] = json!([{"attributes": {"POSITION": positions}}]);
        let [a, b, c] = corners(&g.import().unwrap().0)[0].map(DVec3::from);
        let (x, y) = (expected[1], expected[2]);
        assert!(close(a, [0.0; 3]) && close(b, [x, 0.0, 0.0]) && close(c, [0.0, y, 0.0]), "{component} {normalized}");
    }
}

#[test]
fn sparse_accessors_replace_the_vertices_that_they_name() {
    let mut g = square();
    let (indices, values) = (g.view(&[2, 0]), g.view(&[3.0f32, 4.0, 0.0].map(f32::to_le_bytes).concat()));
    g.json["accessors"][0]["sparse"] = json!({"count": 1, "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": values}});
    let (scene, _) = g.import().unwrap();
    assert_eq!(corners(&scene)[0], [[0., 0., 0.], [1., 0., 0.], [3., 4., 0.]]);
}

#[test]
fn every_instance_of_gpu_instancing_is_there() {
    let mut g = square();
    let translation = g.floats(&[[0.0f32, 0.0, 0.0], [5.0, 0.0, 0.0], [0.0, 5.0, 0.0]]);
    let scale = g.floats(&[[1.0f32, 1.0, 1.0], [2.0, 2.0, 2.0], [-1.0, 1.0, 1.0]]);
    let attributes = json!({"TRANSLATION": translation, "SCALE": scale, "_ID": 77});
    g.json["nodes"] = json!([{"mesh": 0, "translation": [0, 0, 1], "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}]);
    let (scene, report) = g.import().unwrap();
    assert_eq!((report.triangles, area(&scene)), (6, 1.0 + 4.0 + 1.0));
    let t = corners(&scene);
    assert_eq!(t[2], [[5., 0., 1.], [7., 0., 1.], [7., 2., 1.]]);
    assert!(t.iter().all(|&t| close(normal(t), [0.0, 0.0, 1.0])), "the mirrored one is turned");
}

/// The square with a texture of two texels, dark and bright, and two sets of coordinates.
fn textured(info: Value, emissive: Value) -> Gltf {
    let mut g = square();
    let one = g.floats(&[[0.25f32, 0.5], [0.25, 0.5], [0.25, 0.5], [0.25, 0.5]]);
    let two = g.floats(&[[0.75f32, 0.5], [0.75, 0.5], [0.75, 0.5], [0.75, 0.5]]);
    let view = g.view(&png(&[[0, 0, 0], [255, 255, 255]]));
    g.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    g.push("samplers", json!({"wrapS": 33071, "wrapT": 33648}));
    g.push("textures", json!({"source": 0, "sampler": 0}));
    g.json["materials"][0] = json!({
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "baseColorTexture": info, "metallicFactor": 0},
        "emissiveFactor": [1, 1, 1], "emissiveTexture": emissive,
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}}
    });
    g.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(one);
    g.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(two);
    g
}

fn colours(g: Gltf) -> (f32, f32, usize) {
    let (scene, report) = g.import().unwrap();
    assert_eq!(report.textures, 1);
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials).unwrap();
    (surfaces.reflectance(1, 0.3, 0.3)[0], surfaces.emission(1, 0.3, 0.3)[0], scene.mesh.emission_uv.len())
}

#[test]
fn each_texture_takes_the_coordinates_that_its_material_names() {
    let (set0, set1) = (json!({"index": 0}), json!({"index": 0, "texCoord": 1}));
    assert_eq!(colours(textured(set0.clone(), set1.clone())), (0.0, 8.0, 4));
    assert_eq!(colours(textured(set1.clone(), set0.clone())), (0.5, 0.0, 4));
    assert_eq!(colours(textured(set1.clone(), set1.clone())), (0.5, 8.0, 0), "one set is kept once");
    assert_eq!(colours(textured(Value::Null, set1.clone())), (0.5, 8.0, 0), "a lone texture needs one set");
    assert_eq!(colours(textured(set0, Value::Null)), (0.0, 8.0, 0));
}

#[test]
fn the_second_set_is_kept_for_a_lightmap_without_any_transform() {
    let moved = json!({"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0]}}});
    let (scene, _) = textured(moved, Value::Null).import().unwrap();
    assert_eq!(scene.mesh.lightmap_uv, [[0.75, 0.5]; 4]);
    assert_eq!(scene.mesh.uv, [[1.25, 0.5]; 4]);
    assert!(square().import().unwrap().0.mesh.lightmap_uv.is_empty());
}

#[test]
fn what_has_no_second_set_lies_at_the_origin_of_the_lightmap() {
    let mut g = textured(json!({"index": 0}), Value::Null);
    let mut plain = g.json["meshes"][0].clone();
    plain["primitives"][0]["attributes"].as_object_mut().unwrap().remove("TEXCOORD_1");
    let plain = g.push("meshes", plain);
    g.json["nodes"] = json!([{"mesh": 0}, {"mesh": plain, "translation": [3, 0, 0]}]);
    g.json["scenes"] = json!([{"nodes": [0, 1]}]);
    let (scene, _) = g.import().unwrap();
    assert_eq!(scene.mesh.lightmap_uv, [[[0.75, 0.5]; 4], [[0.0; 2]; 4]].concat());
}

#[test]
fn a_broken_second_set_refuses_no_scene_that_does_not_need_it() {
    let mut g = textured(json!({"index": 0}), Value::Null);
    g.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(99);
    let (scene, report) = g.import().unwrap();
    assert!(scene.mesh.lightmap_uv.is_empty());
    let said = "coordinates of a lightmap (TEXCOORD_1) that cannot be read are ignored; primitives: 1";
    assert!(report.warnings.iter().any(|w| w == said), "{:?}", report.warnings);
}

#[test]
fn texture_transforms_are_applied_to_the_coordinates() {
    let moved = json!({"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0]}}});
    assert_eq!(colours(textured(moved, json!({"index": 0}))), (0.5, 0.0, 4));
}

#[test]
fn samplers_decide_how_textures_go_on() {
    let (scene, _) = textured(json!({"index": 0}), Value::Null).import().unwrap();
    assert_eq!(scene.materials.textures[0].wrap, [Wrap::Clamp, Wrap::Mirror]);
}

#[test]
fn textures_that_cannot_be_used_leave_the_factor() {
    for (change, said) in [
        (json!({"source": 0, "sampler": 0}), "textures cannot be decoded (expected PNG or JPEG)"),
        (json!({"extensions": {"KHR_texture_basisu": {"source": 0}}}), "textures have no PNG or JPEG image"),
    ] {
        let mut g = textured(json!({"index": 0}), Value::Null);
        let view = g.view(b"\xabKTX 20\xbb\r\n\x1a\n and so on");
        g.json["images"][0]["bufferView"] = json!(view);
        g.json["textures"][0] = change;
        let (scene, report) = g.import().unwrap();
        assert_eq!(scene.materials.materials[0].reflectance, [0.5; 3]);
        assert_eq!((scene.materials.textures.len(), scene.mesh.uv.len()), (0, 0));
        assert!(report.warnings[0].starts_with(said), "{:?}", report.warnings);
    }
}

#[test]
fn a_primitive_without_coordinates_takes_the_first_texel_and_says_so() {
    let mut g = textured(json!({"index": 0, "texCoord": 3}), Value::Null);
    g.json["extensionsUsed"] = json!(["KHR_texture_transform"]);
    let (_, report) = g.import().unwrap();
    assert!(report.warnings.iter().any(|w| w.starts_with("textured primitives have no texture coordinates")));
}

#[test]
fn gltf_text_finds_its_buffer_and_image_in_files_and_in_itself() {
    let mut g = textured(json!({"index": 0, "texCoord": 1}), Value::Null);
    g.json["images"][0] = json!({"uri": "my%20maps/Two%C3%B6.png"});
    let (json, binary) = (&mut g.json, g.binary);
    let folder = || Memory::default().with("my maps/Twoö.PNG", png(&[[0; 3], [255; 3]]));
    json["buffers"] = json!([{"uri": "scene.bin", "byteLength": binary.len()}]);
    let outside = folder().with("s.gltf", json.to_string()).with("scene.bin", binary.clone());
    json["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{}", base64(&binary)));
    let inside = folder().with("s.gltf", format!("\u{feff}{json}"));
    for files in [outside, inside] {
        let (scene, report) = files.import("s.gltf").unwrap();
        assert_eq!((report.triangles, report.textures), (2, 1));
        assert_eq!(scene.materials.textures[0].name, "my%20maps/Two%C3%B6.png");
        assert!(report.warnings[0].starts_with("files were found only under a name in another case"), "{report:?}");
    }
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |three: &[u8]| {
        let bits = three.iter().fold(0u32, |bits, &b| bits << 8 | u32::from(b)) << (8 * (3 - three.len()));
        let letter = move |k: u32| LETTERS[(bits >> (18 - 6 * k) & 63) as usize] as char;
        (0..=three.len() as u32).map(letter).collect::<String>()
    };
    bytes.chunks(3).map(group).collect()
}

#[test]
fn lights_and_cameras_come_in_watts_and_world_axes() {
    let mut g = square();
    g.json["extensionsRequired"] = json!(["KHR_lights_punctual"]);
    g.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "intensity": 683, "color": [1, 0.5, 0], "range": 3},
        {"type": "spot", "name": "down", "intensity": 1366, "spot": {"outerConeAngle": 0.5, "innerConeAngle": 0.4}},
        {"type": "directional", "intensity": 683},
        {"type": "area", "intensity": 683},
        {"type": "spot", "intensity": -1}
    ]}});
    g.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1.0, "aspectRatio": 2, "znear": 0.1}}));
    g.push("cameras", json!({"type": "orthographic", "orthographic": {"xmag": 1}, "name": "plan"}));
    let light = |i: usize| {
        json!({"name": format!("node {i}"), "rotation": [-1, 0, 0, 1], "scale": [3, 3, 3],
        "translation": [1, 2, 3], "extensions": {"KHR_lights_punctual": {"light": i}}})
    };
    g.json["nodes"] = json!([{"mesh": 0}, light(0), light(1), light(2), light(3), light(4),
        {"camera": 0, "translation": [0, 1, 9]}, {"camera": 1}]);
    let (scene, report) = g.import().unwrap();
    let lights = &scene.extras.lights;
    let names: Vec<&str> = lights.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["node 0", "down", "node 2"]);
    assert_eq!(lights[0].1, Light::Point { position: [1.0, 2.0, 3.0], intensity: [1.0, 0.5, 0.0] });
    let Light::Spot { direction, intensity, half_angle_deg, penumbra_deg, .. } = lights[1].1 else { panic!() };
    assert!((Vec3::from(direction) - Vec3::NEG_Y).length() < 1e-6 && intensity == [2.0; 3]);
    assert!((half_angle_deg - 28.64789).abs() < 1e-4 && (penumbra_deg - 5.729578).abs() < 1e-4);
    let Light::Directional { direction, irradiance } = lights[2].1 else { panic!() };
    assert!((Vec3::from(direction) - Vec3::NEG_Y).length() < 1e-6 && irradiance == [1.0; 3]);
    let (_, camera) = &scene.extras.cameras[0];
    assert_eq!((camera.origin, camera.target, camera.up), ([0., 1., 9.], [0., 1., 8.], [0., 1., 0.]));
    assert!((camera.fov_x_deg - 2.0 * (2.0 * 0.5f64.tan()).atan().to_degrees()).abs() < 1e-9);
    let said = [
        "the range of lights is ignored, light falls with the square of the distance; lights: 1",
        "lights of an unknown type or with impossible numbers are ignored: node 3, node 4",
        "cameras without perspective or with impossible numbers are ignored: plan",
    ];
    assert_eq!(report.warnings, said);
}

#[test]
fn what_is_ignored_by_contract_is_said_once_each() {
    let mut g = textured(json!({"index": 0}), Value::Null);
    g.json["materials"][0]["alphaMode"] = json!("MASK");
    g.json["materials"][0]["normalTexture"] = json!({"index": 0});
    g.json["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = json!(0.2);
    g.json["materials"][0]["extensions"]["KHR_materials_unlit"] = json!({});
    g.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(0);
    g.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
    g.json["nodes"] = json!([{"mesh": 0, "skin": 0}]);
    g.json["animations"] = json!([{}, {}]);
    g.json["extensionsUsed"] = json!(["KHR_materials_unlit", "KHR_materials_clearcoat", "KHR_texture_transform"]);
    let said = [
        "extensions are ignored: KHR_materials_clearcoat",
        "animations are ignored, everything stands as in the file: 2",
        "skins are ignored, skinned meshes stand where their node is: 1",
        "morph targets are ignored; primitives: 1",
        "vertex colours are ignored; primitives: 1",
        "metalness is ignored, surfaces are diffuse; materials: 1",
        "alpha is ignored, surfaces are opaque; materials: 1",
        "normal maps are ignored; materials: 1",
        "unlit materials are lit like all others; materials: 1",
    ];
    assert_eq!(g.import().unwrap().1.warnings, said);
}

#[test]
fn the_old_specular_glossiness_materials_give_their_diffuse_colour() {
    let mut g = square();
    g.json["materials"][0] =
        json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.1, 0.2, 0.3, 1]}}});
    assert_eq!(g.import().unwrap().0.materials.materials[0].reflectance, [0.1, 0.2, 0.3]);
}

#[test]
fn one_sided_scenes_say_so() {
    let folder = Memory::default().with("s.glb", square().glb());
    let options = scene::ImportOptions { one_sided: true };
    assert!(scene::import("s.glb", &folder, options).unwrap().0.mesh.one_sided);
}
