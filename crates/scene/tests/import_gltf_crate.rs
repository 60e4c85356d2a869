//! The import against another reader of glTF, the `gltf` crate: where both can read a file, they say the same of
//! it; where only ours can, a test says what the crate lacks, which is why it is not the reader
//! (`docs/decisions/0005-gltf.md`).

mod gltf_crate;
mod import_support;

use std::{collections::HashSet, path::Path};

use glam::DVec3;
use gltf::{Gltf, json, khr_lights_punctual::Kind};
use gltf_crate::{Reading, Triangle};
use import_support::{Memory, corners, import_shared, png, shared, square};
use radfile::Material;
use scene::{ImportReport, Light, MAX_REFLECTANCE, Scene};
use serde_json::{Value, json};

/// Lumens per watt, by which both kinds of photometric units are divided.
const EFFICACY: f32 = 683.0;

/// Says where the import and the crate differ, if they do.
fn compare(name: &str, bytes: &[u8], (scene, report): &(Scene, ImportReport)) {
    let file = Gltf::from_slice_without_validation(bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
    let reading = Reading::of(&file);
    assert_eq!(report.found, reading.triangles.len(), "{name}");
    let ours = corners(scene);
    let largest = ours.as_flattened().as_flattened().iter().fold(0.0f64, |most, x| most.max(x.abs()));
    // The crate rounds every transform to single precision, the mesh every position.
    let near = |a: &[[f64; 3]; 3], b: &[DVec3; 3]| {
        let tolerance = 8.0 * f64::from(f32::EPSILON) * largest;
        a.iter().zip(b).all(|(a, b)| (DVec3::from(*a) - b).abs().max_element() <= tolerance)
    };
    let (mut at, mut seen) = (0, HashSet::new());
    for (number, theirs) in reading.triangles.iter().enumerate() {
        let is_new = seen.insert(place(theirs));
        if at < ours.len() && is_new && near(&ours[at], &theirs.corners) {
            let material = &scene.materials.materials[scene.mesh.triangle_material[at] as usize];
            compare_materials(&format!("{name}, triangle {number}"), material, &theirs.material);
            if let (Some(uv), Some(_)) = (theirs.uv, material.reflectance_texture) {
                assert_eq!(scene.mesh.triangles[at].map(|i| scene.mesh.uv[i as usize]), uv, "{name}");
            }
            at += 1;
        } else {
            assert!(!is_new || is_thin(&theirs.corners), "{name}: triangle {number} is missing or elsewhere");
        }
    }
    assert_eq!(at, ours.len(), "{name}: triangles that the crate does not know");
    compare_lights(name, scene, &reading);
}

/// What makes a triangle a repetition of another: material and corners, from the smallest on.
fn place(triangle: &Triangle) -> (Option<usize>, [[u32; 3]; 3]) {
    let mut corners = triangle.corners.map(|p| p.as_vec3().to_array().map(|x| (x + 0.0).to_bits()));
    let first = (0..3).min_by_key(|&i| corners[i]).expect("three corners");
    corners.rotate_left(first);
    (triangle.material.index(), corners)
}

/// Whether rounding to single precision may leave no normal.
fn is_thin(&[a, b, c]: &[DVec3; 3]) -> bool {
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    (b - a).cross(c - a).length() <= 1e-6 * longest
}

fn compare_materials(place: &str, ours: &Material, theirs: &gltf::Material) {
    if theirs.index().is_none() {
        // glTF's default is white metal, which no diffuse scene means.
        assert_eq!((ours.reflectance, ours.emission), ([0.5; 3], [0.0; 3]), "{place}");
        return;
    }
    let pbr = theirs.pbr_metallic_roughness();
    assert_eq!(ours.reflectance_texture.is_some(), pbr.base_color_texture().is_some(), "{place}");
    assert_eq!(ours.emission_texture.is_some(), theirs.emissive_texture().is_some(), "{place}");
    let most = if ours.reflectance_texture.is_some() { 1.0 } else { MAX_REFLECTANCE };
    let (strength, base) = (theirs.emissive_strength().unwrap_or(1.0), pbr.base_color_factor());
    for (c, emissive) in theirs.emissive_factor().into_iter().enumerate() {
        assert!((ours.reflectance[c] - base[c].min(most)).abs() <= f32::EPSILON, "{place}: {ours:?}, {base:?}");
        let emission = emissive * strength;
        assert!((ours.emission[c] - emission).abs() <= f32::EPSILON * emission, "{place}: {ours:?}, {emission}");
    }
    if let (Some(name), false) = (theirs.name(), ours.name.is_empty()) {
        assert_eq!(ours.name, name, "{place}");
    }
}

fn compare_lights(name: &str, scene: &Scene, reading: &Reading) {
    assert_eq!(scene.extras.lights.len(), reading.lights.len(), "{name}");
    for ((called, ours), (theirs, transform)) in scene.extras.lights.iter().zip(&reading.lights) {
        assert!(theirs.name().is_none_or(|n| n == called), "{name}: {called}");
        let strength = theirs.color().map(|c| c * theirs.intensity() / EFFICACY);
        let same_colour = |c: &[f32; 3]| c.iter().zip(strength).all(|(a, b)| (a - b).abs() <= 2.0 * f32::EPSILON * b);
        let origin = transform.transform_point3(DVec3::ZERO);
        let here = |p: &[f64; 3]| (DVec3::from(*p) - origin).length() <= 1e-6 * (1.0 + origin.length());
        let axis = transform.transform_vector3(DVec3::NEG_Z).normalize().as_vec3();
        let along = |d: &[f32; 3]| (glam::Vec3::from(*d) - axis).length() < 1e-5;
        let same = match (ours, theirs.kind()) {
            (Light::Point { position, intensity }, Kind::Point) => here(position) && same_colour(intensity),
            (Light::Directional { direction, irradiance }, Kind::Directional) => {
                along(direction) && same_colour(irradiance)
            }
            (
                Light::Spot { position, direction, intensity, half_angle_deg, penumbra_deg },
                Kind::Spot { inner_cone_angle, outer_cone_angle },
            ) => {
                let soft = (outer_cone_angle - inner_cone_angle).to_degrees();
                let angles = (half_angle_deg - outer_cone_angle.to_degrees()).abs() + (penumbra_deg - soft).abs();
                here(position) && along(direction) && same_colour(intensity) && angles < 1e-4
            }
            _ => false,
        };
        assert!(same, "{name}: {called}: {ours:?}");
    }
}

/// Every `.glb` below a folder's folders, as `folder/name`.
fn binary_files(scenes: &Path) -> Vec<String> {
    let list = |path: &Path| -> Vec<String> {
        let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
        entries.filter_map(|e| e.file_name().into_string().ok()).collect()
    };
    let inside = |folder: String| list(&scenes.join(&folder)).into_iter().map(move |n| format!("{folder}/{n}"));
    let mut files: Vec<String> = list(scenes).into_iter().flat_map(inside).filter(|n| n.ends_with(".glb")).collect();
    files.sort();
    files
}

#[test]
fn shared_scenes_are_the_same_to_both_readers() {
    let Some(scenes) = shared("scenes") else { return };
    let (mut refused, mut compared) = (vec![], 0);
    for path in binary_files(&scenes) {
        let Ok(read) = import_shared(&scenes, &path) else {
            refused.push(path);
            continue;
        };
        let bytes = std::fs::read(scenes.join(&path)).expect("it was read before");
        // The crate knows no instances, see below.
        if path != "dirty/simple-instancing.glb" {
            compare(&path, &bytes, &read);
            compared += 1;
        }
    }
    let broken = ["heart_draco", "index_out_of_range", "lying_accessor", "lying_length", "node_cycle"];
    let broken = [&broken[..], &["rooms_draco", "rooms_meshopt", "truncated"]].concat();
    assert_eq!(refused, broken.iter().map(|name| format!("dirty/{name}.glb")).collect::<Vec<_>>());
    assert!(compared >= 17, "{compared}");
}

/// The square with a tree of nodes over it; `change` says what else is special.
fn compare_square(name: &str, change: impl FnOnce(&mut import_support::Gltf)) {
    let mut g = square();
    g.json["scenes"] = json!([{"nodes": [0]}]);
    g.json["scene"] = json!(0);
    change(&mut g);
    let bytes = g.glb();
    let read = Memory::default().with("s.glb", bytes.clone()).import("s.glb").expect(name);
    compare(name, &bytes, &read);
}

#[test]
fn nodes_that_turn_mirror_and_shear_put_the_square_in_the_same_place() {
    compare_square("tree", |g| {
        g.json["nodes"] = json!([
            {"translation": [0.1, -2, 3], "scale": [2, 3, -0.5], "children": [2, 1]},
            {"mesh": 0, "rotation": [0, 0.6, 0, 0.8]},
            {"mesh": 0, "matrix": [1,0,0,0, 0.3,1,0,0, 0,0.2,-1,0, 5,6,7,1], "children": [3]},
            {"mesh": 0, "scale": [-1, 1, 1]}
        ]);
    });
}

#[test]
fn strips_fans_and_sparse_positions_make_the_same_triangles() {
    for mode in [4, 5, 6] {
        compare_square("mode", |g| {
            g.json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
            let (at, values) = (g.view(&[2, 0]), g.view(&[3.0f32, 4.0, 0.5].map(f32::to_le_bytes).concat()));
            g.json["accessors"][0]["sparse"] = json!({"count": 1, "indices": {"bufferView": at, "componentType": 5121}, "values": {"bufferView": values}});
        });
    }
}

#[test]
fn textured_and_shining_materials_are_the_same() {
    compare_square("materials", |g| {
        let uv = g.floats(&[[0.0f32, 0.0], [1.0, 0.25], [1.0, 1.0], [0.125, 1.0]]);
        let view = g.view(&png(&[[0, 0, 0], [255, 255, 255]]));
        g.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
        g.push("textures", json!({"source": 0}));
        g.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(uv);
        g.json["materials"][0] = json!({
            "pbrMetallicRoughness": {"baseColorFactor": [1, 0.3, 0.2, 1], "baseColorTexture": {"index": 0, "texCoord": 1}},
            "emissiveFactor": [0.1, 0.7, 1], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 12.3}}
        });
    });
    compare_square("white", |g| {
        g.json["materials"][0] = json!({"pbrMetallicRoughness": {"baseColorFactor": [1, 0.3, 0, 1]}});
    });
}

#[test]
fn lights_of_all_kinds_are_the_same() {
    compare_square("lights", |g| {
        g.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
            {"type": "point", "intensity": 40, "color": [1, 0.5, 0.1]},
            {"type": "spot", "name": "down", "intensity": 7, "spot": {"outerConeAngle": 0.5, "innerConeAngle": 0.4}},
            {"type": "spot", "spot": {}},
            {"type": "directional", "intensity": 3}
        ]}});
        let light = |i: usize| {
            json!({"rotation": [-0.6, 0, 0, 0.8], "scale": [3, 3, 3], "translation": [1, 2, i],
                "extensions": {"KHR_lights_punctual": {"light": i}}})
        };
        g.json["nodes"] = json!([{"mesh": 0, "children": [1, 2, 3, 4]}, light(0), light(1), light(2), light(3)]);
    });
}

/// The square after a change, as both readers see it: ours, and what the crate makes of the JSON.
fn both(change: impl FnOnce(&mut Value)) -> (scene::Result<(Scene, ImportReport)>, Result<json::Root, gltf::Error>) {
    let mut g = square();
    change(&mut g.json);
    let bytes = g.glb();
    let theirs = Gltf::from_slice_without_validation(&bytes).map(|file| file.document.into_json());
    (Memory::default().with("s.glb", bytes).import("s.glb"), theirs)
}

#[test]
fn the_crate_moves_squares_with_map_coordinates() {
    let (ours, theirs) = both(|j| j["nodes"][0]["translation"] = json!([500000.001, 200, 4649776.2]));
    let z = theirs.unwrap().nodes[0].translation.unwrap()[2];
    assert!((f64::from(z) - 4649776.2).abs() > 0.19, "{z}");
    assert!((corners(&ours.unwrap().0)[0][0][2] - 4649776.2).abs() < 1e-6);
}

/// The field that the crate misses, and a change of the JSON that leaves it out.
type Change = (&'static str, fn(&mut Value));

#[test]
fn the_crate_refuses_whole_files_for_parts_that_are_optional_or_ignored() {
    let changes: [Change; 3] = [
        ("nodes", |j| (j["scene"], j["scenes"]) = (json!(1), json!([{"name": "empty"}, {"nodes": [0]}]))),
        ("node", |j| {
            let target = json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/nodes/0"}}});
            j["animations"] = json!([{"samplers": [], "channels": [{"sampler": 0, "target": target}]}]);
        }),
        ("ymag", |j| j["cameras"] = json!([{"type": "orthographic", "orthographic": {"xmag": 1}}])),
    ];
    for (field, change) in changes {
        let (ours, theirs) = both(change);
        assert_eq!(ours.unwrap().1.triangles, 2, "{field}");
        let refusal = theirs.unwrap_err().to_string();
        assert!(refusal.contains(&format!("missing field `{field}`")), "{refusal}");
    }
}

#[test]
fn the_crate_forgets_the_numbers_that_a_refusal_must_name() {
    let (ours, theirs) = both(|j| j["nodes"][0]["mesh"] = json!(1u64 << 32));
    assert_eq!(theirs.unwrap().nodes[0].mesh.unwrap().value(), 0, "it wraps and reads another mesh");
    assert!(ours.unwrap_err().to_string().contains("mesh 4294967296 is named, there are 1"));
    let (ours, theirs) = both(|j| j["meshes"][0]["primitives"][0]["mode"] = json!(7));
    assert_eq!(theirs.unwrap().meshes[0].primitives[0].mode, json::validation::Checked::Invalid);
    assert!(ours.unwrap_err().to_string().contains("has the mode 7, expected 0 to 6"));
}

#[test]
fn the_crate_sees_one_of_many_instances() {
    let mut g = square();
    let translation = g.floats(&[[0.0f32, 0.0, 0.0], [5.0, 0.0, 0.0], [0.0, 5.0, 0.0]]);
    let instancing = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translation}}});
    g.json["nodes"][0]["extensions"] = instancing;
    g.json["scenes"] = json!([{"nodes": [0]}]);
    let bytes = g.glb();
    let file = Gltf::from_slice_without_validation(&bytes).unwrap();
    let (_, report) = Memory::default().with("s.glb", bytes).import("s.glb").unwrap();
    assert_eq!((Reading::of(&file).triangles.len(), report.found), (2, 6));
}

#[test]
fn the_crate_refuses_textures_whose_image_is_in_an_extension() {
    let mut g = square();
    g.push("textures", json!({"extensions": {"KHR_texture_basisu": {"source": 0}}}));
    g.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    let bytes = g.glb();
    let refusal = Gltf::from_slice(&bytes).unwrap_err().to_string();
    assert!(refusal.contains("textures[0].source"), "{refusal}");
    assert_eq!(Memory::default().with("s.glb", bytes).import("s.glb").unwrap().1.triangles, 2);
}
