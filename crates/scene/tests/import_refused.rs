//! Files that must not be read: one clear sentence each, and nothing worse for any damage.

mod import_support;

use import_support::{Memory, square};
use serde_json::{Value, json};

/// The refusal of the square after a change of its JSON.
fn refusal(change: impl FnOnce(&mut Value)) -> String {
    let mut g = square();
    change(&mut g.json);
    g.import().expect_err("a broken file").to_string()
}

#[test]
fn compressed_meshes_are_refused_by_name_with_a_remedy() {
    for extension in ["KHR_draco_mesh_compression", "EXT_meshopt_compression"] {
        let text = refusal(|json| json["extensionsRequired"] = json!([extension]));
        let expected = format!(
            "s.glb: needs the glTF extension {extension}, which is not supported; export the scene again with mesh compression switched off, or decompress the file first"
        );
        assert_eq!(text, expected);
    }
    let text = refusal(|json| json["extensionsRequired"] = json!(["KHR_texture_basisu"]));
    assert!(text.ends_with("export the scene again with PNG or JPEG textures"), "{text}");
    let text = refusal(|json| json["extensionsRequired"] = json!(["KHR_lights_punctual", "ACME_brushes"]));
    assert!(text.contains("glTF extension ACME_brushes") && text.ends_with("again without it"), "{text}");
}

#[test]
fn compressed_meshes_that_are_not_declared_are_refused_too() {
    let text = refusal(|json| {
        json["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_draco_mesh_compression": {"bufferView": 0}});
        json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    });
    assert!(text.contains("needs the glTF extension KHR_draco_mesh_compression"), "{text}");
    let mut g = square();
    g.json["bufferViews"][0]["buffer"] = json!(1);
    g.json["bufferViews"][0]["extensions"] = json!({"EXT_meshopt_compression": {"buffer": 0}});
    let json = g.json;
    let mut json = json;
    json["buffers"] = json!([{"uri": "data:;base64,AAAA", "byteLength": 3}, {"byteLength": 48}]);
    let text = Memory::default().with("s.gltf", json.to_string()).import("s.gltf").unwrap_err().to_string();
    assert!(text.contains("needs the glTF extension EXT_meshopt_compression"), "{text}");
}

/// A change of the JSON, and what must be said of it.
type Case = (fn(&mut Value), &'static str);

#[test]
fn numbers_that_point_nowhere_are_refused_with_their_place() {
    let cases: [Case; 18] = [
        (|j| j["accessors"][0]["count"] = json!(1_000_000_000), "accessor 0 counts 1000000000 elements of 12 bytes"),
        (|j| j["accessors"][0]["count"] = json!(u64::MAX), "accessor 0 counts 18446744073709551615 elements"),
        (
            |j| j["accessors"][0]["byteOffset"] = json!(u64::MAX),
            "accessor 0 counts 4 elements of 12 bytes from byte 1844",
        ),
        (|j| j["accessors"][0]["type"] = json!("VEC2"), "accessor 0 is of type \"VEC2\", expected VEC3"),
        (
            |j| j["accessors"][0]["componentType"] = json!(1),
            "accessor 0 has the component type 1, which does not exist",
        ),
        (|j| j["accessors"][1]["componentType"] = json!(5122), "has indices that are no unsigned integers"),
        (|j| j["accessors"][0]["bufferView"] = json!(9), "buffer view 9 is named, there are 2"),
        (|j| j["accessors"][0]["bufferView"] = Value::Null, "has positions without data"),
        (
            |j| j["bufferViews"][0]["byteLength"] = json!(1000),
            "buffer view 0 takes 1000 bytes from byte 0 of buffer 0, which has 60",
        ),
        (|j| j["bufferViews"][0]["byteOffset"] = json!(u64::MAX), "buffer view 0 takes 48 bytes from byte 1844"),
        (|j| j["bufferViews"][0]["byteStride"] = json!(4), "accessor 0 has elements of 12 bytes, 4 apart"),
        (|j| j["bufferViews"][0]["buffer"] = json!(3), "buffer 3 is named, there are 1"),
        (|j| j["nodes"][0]["mesh"] = json!(5), "mesh 5 is named, there are 1"),
        (
            |j| (j["scenes"], j["nodes"]) = (json!([{"nodes": [0]}]), json!([{"children": [0]}])),
            "node 0 (\"\") is reached twice, expected a tree",
        ),
        (|j| j["scenes"] = json!([{"nodes": [7]}]), "node 7 is named, there are 1"),
        (|j| j["meshes"][0]["primitives"][0]["material"] = json!(4), "material 4 is named, there are 1"),
        (
            |j| j["meshes"][0]["primitives"][0]["mode"] = json!(7),
            "primitive 0 of mesh 0 (\"\") has the mode 7, expected 0 to 6",
        ),
        (|j| j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(8), "accessor 8 is named, there are 2"),
    ];
    for (change, expected) in cases {
        let text = refusal(change);
        assert!(text.starts_with("s.glb: ") && text.contains(expected), "{text}\nexpected: {expected}");
    }
}

#[test]
fn an_index_beyond_the_vertices_is_refused() {
    let mut g = square();
    let indices = g.indices(&[0, 1, 60000]);
    g.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let text = g.import().unwrap_err().to_string();
    assert!(text.contains("has the index 60000 at place 2, expected less than 4"), "{text}");
}

#[test]
fn sparse_accessors_that_promise_much_cost_nothing() {
    let mut g = square();
    let (indices, values) = (g.view(&[1, 0]), g.view(&[0; 12]));
    let sparse = json!({"count": 1, "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": values}});
    let empty = json!({"componentType": 5126, "count": 1_000_000_000, "type": "VEC3", "sparse": sparse});
    let accessor = g.push("accessors", empty);
    g.json["meshes"][0]["primitives"] = json!([{"attributes": {"POSITION": accessor}}]);
    let text = g.import().unwrap_err().to_string();
    assert!(text.contains("counts 1000000000 elements and has no buffer view"), "{text}");
    let text = refusal(|j| {
        j["accessors"][0]["sparse"] =
            json!({"count": 9, "indices": {"bufferView": 0, "componentType": 5121}, "values": {"bufferView": 1}})
    });
    assert!(text.contains("counts 9 elements of 12 bytes from byte 0 on, its buffer view 1 has 12 bytes"), "{text}");
    let text = refusal(|j| {
        j["accessors"][0]["sparse"] =
            json!({"count": 2, "indices": {"bufferView": 0, "componentType": 5121}, "values": {"bufferView": 0}})
    });
    assert!(text.contains("is sparse with indices that do not ascend below 4"), "{text}");
}

#[test]
fn instances_without_number_are_refused_before_they_are_made() {
    let mut g = square();
    let view = g.view(&[0; 60]);
    let many = json!({"bufferView": view, "componentType": 5126, "count": 5, "type": "VEC3"});
    let (five, four) = (g.push("accessors", many), g.floats(&[[1.0f32; 3]; 4]));
    g.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": five, "SCALE": four}}});
    let text = g.import().unwrap_err().to_string();
    assert!(text.contains("have 5 of one attribute and 4 of another"), "{text}");
}

#[test]
fn a_tower_of_instances_is_refused_by_its_count() {
    let mut g = square();
    // 200 nodes of 100,000 instances of two triangles, from 1.2 MB.
    let translation = g.floats(&vec![[0.0f32; 3]; 100_000]);
    let node =
        json!({"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translation}}}});
    g.json["nodes"] = json!(vec![node; 200]);
    g.json["meshes"][0]["primitives"] = json!(vec![g.json["meshes"][0]["primitives"][0].clone(); 200]);
    let text = g.import().unwrap_err().to_string();
    assert!(text.contains("triangles or more once instances are counted, expected at most 33554432"), "{text}");
}

#[test]
fn other_formats_and_versions_are_named() {
    let import = |name: &str, bytes: &[u8]| Memory::default().with(name, bytes).import(name).unwrap_err().to_string();
    assert_eq!(import("a.fbx", b"x"), "a.fbx: the ending is unknown, expected .obj, .gltf or .glb");
    assert_eq!(import("scene", b"x"), "scene: the ending is unknown, expected .obj, .gltf or .glb");
    assert!(import("a.glb", b"\x1f\x8b").contains("does not start with the letters glTF"));
    assert!(import("a.gltf", b"{}").contains("it is glTF version \"\", expected 2.x"));
    assert!(import("a.gltf", br#"{"asset":{"version":"1.0"}}"#).contains("it is glTF version \"1.0\""));
    assert!(import("a.gltf", b"\xff\xfe").contains("its JSON cannot be read: "));
    assert!(import("a.gltf", &[b'['; 100_000]).contains("its JSON cannot be read: "), "deep nesting ends somewhere");
    let missing = Memory::default().import("gone.obj").unwrap_err().to_string();
    assert!(missing.starts_with("gone.obj: "), "{missing}");
    let buffer = br#"{"asset":{"version":"2.0"},"buffers":[{"uri":"gone.bin","byteLength":1}]}"#;
    assert!(import("a.gltf", buffer).starts_with("gone.bin: "));
    let short = br#"{"asset":{"version":"2.0"},"buffers":[{"uri":"data:;base64,AAAA","byteLength":9}]}"#;
    assert!(import("a.gltf", short).contains("buffer 0 should have 9 bytes, 3 are there"));
    assert!(import("a.obj", b"\x00\xff\xfenot text at all").contains("no usable triangle ("));
}

/// A chain of nodes deeper than any stack.
#[test]
fn nodes_may_be_nested_as_deep_as_they_like() {
    let mut g = square();
    let n = 100_000;
    let node = |i: usize| if i == n { json!({"mesh": 0}) } else { json!({"children": [i + 1]}) };
    g.json["nodes"] = (0..=n).map(node).collect();
    assert_eq!(g.import().unwrap().1.triangles, 2);
}

#[test]
fn a_glb_cut_anywhere_is_refused() {
    let whole = square().glb();
    for length in 0..whole.len() {
        let result = Memory::default().with("s.glb", &whole[..length]).import("s.glb");
        assert!(!result.expect_err("a cut file").to_string().is_empty(), "{length} bytes");
    }
}

#[test]
fn a_glb_with_any_bit_flipped_does_no_harm() {
    let whole = square().glb();
    let mut refused = 0;
    for bit in 0..8 * whole.len() {
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        refused += usize::from(Memory::default().with("s.glb", bytes).import("s.glb").is_err());
    }
    assert!(refused > whole.len(), "most damage is noticed");
}

#[test]
fn an_obj_cut_or_flipped_anywhere_does_no_harm() {
    let obj = b"mtllib m.mtl\r\nv 0 0 0\nv 1 0 0\nv 1 1 0 1 0 0\nv 0 1e0 0\nvt 0.5 -1\nusemtl a b\nf 1/1 2/1 3 -1/-1\nf 1//1 2 \\\n 3\n";
    let mtl = b"newmtl a b\nKd 0.5 .5 0.5\nKe 1 2 3\nmap_Kd -s 1 1 1 t.png\nd 0.5\n";
    let import = |obj: &[u8], mtl: &[u8]| {
        let folder =
            Memory::default().with("s.obj", obj).with("m.mtl", mtl).with("t.png", import_support::png(&[[9; 3]]));
        let _ = folder.import("s.obj");
    };
    for (file, other, is_obj) in [(&obj[..], &mtl[..], true), (&mtl[..], &obj[..], false)] {
        let import = |bytes: &[u8]| if is_obj { import(bytes, other) } else { import(other, bytes) };
        (0..file.len()).for_each(|length| import(&file[..length]));
        for bit in 0..8 * file.len() {
            let mut bytes = file.to_vec();
            bytes[bit / 8] ^= 1 << (bit % 8);
            import(&bytes);
        }
    }
}
