//! Every scene of the reference data does what its authors want of it.
//! The data is not part of the repository: without it these tests say so and pass.

mod import_support;

use glam::DVec3;
use import_support::{Memory, area, corners, import_shared, png, shared};
use scene::{Camera, Error, ImportReport, Light, LightRig, Scene, Surfaces};

fn load(path: &str) -> Option<(Scene, ImportReport)> {
    let scenes = shared("scenes")?;
    Some(import_shared(&scenes, path).unwrap_or_else(|error| panic!("{path}: {error}")))
}

fn bounds(scene: &Scene) -> (DVec3, DVec3) {
    let all: Vec<DVec3> = corners(scene).into_iter().flatten().map(DVec3::from).collect();
    all.iter().fold((all[0], all[0]), |(low, high), p| (low.min(*p), high.max(*p)))
}

#[test]
fn every_scene_has_the_triangles_that_its_authors_counted() {
    let Some(scenes) = shared("scenes") else { return };
    // Path, triangles in the file, of these dropped as repetitions or without area, materials, textures.
    for (path, found, dropped, materials, textures) in [
        ("cornell_box/CornellBox-Original.obj", 36, 4, 8, 0),
        ("cornell_box/cornell_box.glb", 36, 4, 8, 0),
        ("cornell_box/cornell_empty.glb", 12, 0, 6, 0),
        ("sponza/sponza.glb", 66_444, 4, 20, 12),
        ("sibenik/sibenik.glb", 75_276, 151, 15, 3),
        ("conference/conference.glb", 331_179, 0, 35, 0),
        ("breakfast_room/breakfast_room.glb", 269_538, 0, 15, 3),
        ("living_room/living_room.glb", 128_543, 0, 17, 3),
        ("rooms/rooms.obj", 120, 0, 7, 0),
        ("rooms/rooms.glb", 120, 0, 7, 0),
        ("rooms/corridor.obj", 68, 0, 4, 0),
        ("rooms/corridor.glb", 68, 0, 4, 0),
        ("furnace/furnace_50.obj", 12, 0, 1, 0),
        ("furnace/furnace_50.glb", 12, 0, 1, 0),
        ("dirty/house.glb", 10_497, 2504, 2, 1),
        ("dirty/vr-gallery.glb", 1930, 0, 1, 2),
        ("dirty/rooms_quantized.glb", 120, 0, 7, 0),
        ("dirty/simple-instancing.glb", 125 * 12, 0, 1, 0),
        ("dirty/instances_uv1_lights.glb", 60, 0, 3, 1),
        ("dirty/Lights.glb", 12, 0, 1, 0),
        ("dirty/geometry-camera-light.glb", 14, 0, 2, 0),
    ] {
        let (scene, report) = import_shared(&scenes, path).unwrap_or_else(|error| panic!("{path}: {error}"));
        assert_eq!((report.found, report.triangles), (found, found - dropped), "{path}");
        assert_eq!((report.materials, report.textures), (materials, textures), "{path}");
        assert_eq!(
            (scene.mesh.triangles.len(), scene.mesh.triangle_material.len()),
            (found - dropped, found - dropped)
        );
        assert_eq!(scene.mesh.origin, [0.0; 3], "{path} is near its origin");
        Surfaces::new(&scene.mesh, &scene.materials).unwrap_or_else(|error| panic!("{path}: {error}"));
    }
}

#[test]
fn the_cornell_box_is_the_same_from_obj_and_from_gltf() {
    let Some((obj, _)) = load("cornell_box/CornellBox-Original.obj") else { return };
    let (glb, report) = load("cornell_box/cornell_box.glb").unwrap();
    assert_eq!(report.warnings, ["exact repetitions of a triangle are dropped: 4"]);
    assert!((area(&obj) - area(&glb)).abs() < 1e-5);
    for scene in [&obj, &glb] {
        let lamp = &scene.materials.materials[7];
        assert_eq!((lamp.name.as_str(), lamp.reflectance), ("light", [0.78; 3]));
        assert!(lamp.emission.iter().zip([17.0, 12.0, 4.0]).all(|(e, k)| (e - k).abs() < 1e-5), "{lamp:?}");
        let surfaces = Surfaces::new(&scene.mesh, &scene.materials).unwrap();
        let emitters = surfaces.emitters();
        assert_eq!(emitters.len(), 2);
        for t in emitters {
            let [a, b, c] = corners(scene)[t as usize].map(DVec3::from);
            assert!((b - a).cross(c - a).y < 0.0, "the lamp shines down");
        }
    }
}

#[test]
fn the_cornell_box_in_millimetres_of_a_map_is_the_same_up_to_scale() {
    let Some((far, report)) = load("dirty/CornellBox_utm.obj") else { return };
    let (near, _) = load("cornell_box/cornell_box.glb").unwrap();
    assert!(report.warnings[0].starts_with("coordinates are large"), "{:?}", report.warnings);
    assert!((far.mesh.origin[2] - 4.649776e9).abs() < 1e4);
    assert!((area(&far) / area(&near) - 1e6).abs() < 1.0);
    let shift = DVec3::new(500_000_000.0, 20_000.0, 4_649_776_000.0);
    for (f, n) in corners(&far).iter().flatten().zip(corners(&near).iter().flatten()) {
        assert!((DVec3::from(*f) - shift - 1000.0 * DVec3::from(*n)).length() < 1e-3, "{f:?} {n:?}");
    }
    for (f, n) in far.materials.materials.iter().zip(&near.materials.materials) {
        assert_eq!((&f.name, f.reflectance), (&n.name, n.reflectance));
    }
}

#[test]
fn quantised_meshes_equal_the_ones_they_were_made_from() {
    for (plain, quantised, tolerance) in
        [("dirty/house.glb", "dirty/house_quantized.glb", 2e-3), ("rooms/rooms.glb", "dirty/rooms_quantized.glb", 5e-4)]
    {
        let Some((plain, p)) = load(plain) else { return };
        let (quantised, q) = load(quantised).unwrap();
        assert_eq!(p.found, q.found);
        let ((l, h), (ql, qh)) = (bounds(&plain), bounds(&quantised));
        let size = (h - l).length();
        assert!((l - ql).length() < tolerance * size && (h - qh).length() < tolerance * size, "{l} {ql} {h} {qh}");
        let (a, b) = (area(&plain), area(&quantised));
        assert!((a / b - 1.0).abs() < tolerance, "{a} {b}");
    }
}

#[test]
fn instances_are_placed_and_mirrored_and_lit_as_the_file_says() {
    let Some((scene, report)) = load("dirty/instances_uv1_lights.glb") else { return };
    assert_eq!(report.triangles, 60);
    // The root doubles everything, the room is a unit cube scaled by (-3, 1.5, 3).
    let (low, high) = bounds(&scene);
    assert!((low - DVec3::new(-3.0, -1.5, -3.0)).length() < 1e-6 && (high + low).length() < 1e-6, "{low} {high}");
    // Seen from inside as it was made: the unit cube's fronts look outwards, mirrored or not.
    let volume = |range: std::ops::Range<usize>| -> f64 {
        let signed = |t: &[[f64; 3]; 3]| {
            let [a, b, c] = t.map(DVec3::from);
            a.dot(b.cross(c)) / 6.0
        };
        corners(&scene)[range].iter().map(signed).sum()
    };
    let room = volume(0..12);
    assert!((room.abs() - 6.0 * 3.0 * 6.0).abs() < 1e-4, "{room}");
    assert!((1..5).all(|k| volume(12 * k..12 * (k + 1)) * room > 0.0), "mirrored and plain boxes face the same way");
    let textured = scene.materials.materials[1].reflectance_texture.is_some();
    assert!(textured && scene.mesh.uv.iter().any(|uv| *uv != [0.0; 2]));
    assert_eq!(scene.materials.materials[2].emission, [12.5, 11.25, 10.0]);
    let kinds: Vec<&str> = scene.extras.lights.iter().map(|(_, light)| light.kind()).collect();
    assert_eq!(kinds, ["point", "spot"]);
    let Light::Point { position, intensity } = scene.extras.lights[0].1 else { panic!() };
    assert!((DVec3::from(position) - DVec3::new(1.6, 0.6, 1.6)).length() < 1e-12);
    assert!((intensity[0] - 40.0 / 683.0).abs() < 1e-7);
}

#[test]
fn lights_and_cameras_of_exported_files_are_found() {
    let Some((scene, _)) = load("dirty/Lights.glb") else { return };
    let names: Vec<&str> = scene.extras.lights.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["Light", "Spot", "Spot.001", "Sun"]);
    assert_eq!(scene.extras.cameras.len(), 1);
    let (scene, report) = load("dirty/geometry-camera-light.glb").unwrap();
    assert_eq!((scene.extras.lights.len(), scene.extras.cameras.len()), (2, 1));
    let (name, camera) = &scene.extras.cameras[0];
    assert_eq!(name, "Persp");
    assert!((camera.fov_x_deg - 39.6).abs() < 0.01, "{camera:?}");
    assert!(report.warnings.iter().any(|w| w.ends_with("impossible numbers are ignored: Ortho")));
}

#[test]
fn warts_are_counted_and_what_is_sound_is_loaded() {
    let Some((scene, report)) = load("dirty/warts.obj") else { return };
    // Two quads twice, one quad, two triangles, one turned over, an L of four, a fin of three.
    assert_eq!(report.triangles, 4 * 2 + 2 + 2 + 1 + 4 + 3);
    let said = [
        "vertices that are not three finite numbers: 2",
        "lines and points are ignored: 2",
        "statements that are not understood are ignored: curv",
        "faces with fewer than three corners are dropped: 1",
        "faces with an index out of range are dropped: 1",
        "faces with a vertex that is not three finite numbers are dropped: 2",
        "material libraries are missing: not_there.mtl",
        "textures are missing, the plain colour of their materials is used: missing_texture.png",
        "materials are not defined and are grey 0.5: undefined_material",
        "triangles without area are dropped: 2",
        "exact repetitions of a triangle are dropped: 1",
        "triangles lie exactly on another with a different winding or material and are kept: 1",
    ];
    assert_eq!(report.warnings, said);
    let l: f64 = corners(&scene)[13..17]
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(DVec3::from);
            (b - a).cross(c - a).length() / 2.0
        })
        .sum();
    assert!((l - 3.0).abs() < 1e-6, "the L covers three squares once: {l}");
    let names: Vec<&str> = scene.materials.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["wall", "two words", "undefined_material"]);
}

#[test]
fn textures_named_in_the_wrong_case_are_found() {
    let Some(scenes) = shared("scenes") else { return };
    let mtl = std::fs::read(scenes.join("dirty/sponza_original_case_mismatch.mtl")).unwrap();
    let text = "mtllib s.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl sp_00_luk_mali\nf 1/1 2/1 3/1\n";
    let folder = Memory::default().with("s.obj", text).with("s.mtl", mtl).with("sp_luk.JPG", png(&[[9; 3]]));
    let (scene, report) = folder.import("s.obj").unwrap();
    assert!(scene.materials.materials[0].reflectance_texture.is_some());
    let said = "files were found only under a name in another case: SP_LUK.JPG";
    assert!(report.warnings.iter().any(|w| w == said), "{:?}", report.warnings);
}

#[test]
fn broken_files_are_refused_in_one_sentence_that_says_what_is_wrong() {
    let Some(scenes) = shared("scenes") else { return };
    for (name, expected) in [
        ("truncated.glb", "its header says 6128 bytes, the file holds 4085; it was cut short, copy it again"),
        ("lying_length.glb", "its header says 2147483647 bytes, the file holds 6128"),
        ("lying_accessor.glb", "accessor 0 counts 1000000000 elements of 12 bytes from byte 0 on"),
        ("node_cycle.glb", "node 0 (\"floor\") is reached twice, expected a tree"),
        ("index_out_of_range.glb", "has the index 60000 at place 0, expected less than 4, the number of its vertices"),
        ("empty.obj", "no usable triangle (it has no faces)"),
        ("no_faces.obj", "no usable triangle (it has no faces)"),
        ("rooms_draco.glb", "needs the glTF extension KHR_draco_mesh_compression, which is not supported; export"),
        ("heart_draco.glb", "needs the glTF extension KHR_draco_mesh_compression, which is not supported; export"),
        ("rooms_meshopt.glb", "needs the glTF extension EXT_meshopt_compression, which is not supported; export"),
    ] {
        let error = import_shared(&scenes, &format!("dirty/{name}")).expect_err(name);
        let text = error.to_string();
        assert!(text.starts_with(&format!("{name}: ")) && text.contains(expected), "{text}");
        assert!(!text.contains('\n'), "{text}");
        match name {
            "empty.obj" | "no_faces.obj" => assert!(matches!(error, Error::Empty { .. })),
            _ if name.contains("draco") || name.contains("meshopt") => {
                assert!(matches!(error, Error::Extension { .. }))
            }
            _ => assert!(matches!(error, Error::Malformed { .. })),
        }
    }
}

#[test]
fn unlit_and_textured_scenes_give_colours_between_black_and_white() {
    for path in ["dirty/vr-gallery.glb", "sponza/sponza.glb"] {
        let Some((scene, _)) = load(path) else { return };
        let surfaces = Surfaces::new(&scene.mesh, &scene.materials).unwrap();
        let colours: Vec<[f32; 3]> =
            (0..scene.mesh.triangles.len() as u32).map(|t| surfaces.reflectance(t, 0.3, 0.3)).collect();
        assert!(colours.iter().flatten().all(|c| (0.0..=scene::MAX_REFLECTANCE).contains(c)));
        let mean = colours.iter().flatten().map(|&c| f64::from(c)).sum::<f64>() / (3.0 * colours.len() as f64);
        assert!((0.02..0.7).contains(&mean), "{path}: mean {mean}");
    }
}

#[test]
fn reference_lights_and_cameras_are_read() {
    let (Some(lights), Some(cameras)) = (shared("reference/lights"), shared("reference/cameras")) else { return };
    let texts = |folder: &std::path::Path| -> Vec<(String, String)> {
        let files = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
        files.map(|p| (p.display().to_string(), std::fs::read_to_string(&p).unwrap())).collect()
    };
    let mut count = 0;
    for (name, text) in texts(&lights) {
        let rig = LightRig::from_json(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(rig.use_scene_emission || !rig.lights.is_empty(), "{name}");
        count += rig.lights.len();
    }
    assert_eq!(count, 5);
    for (name, text) in texts(&cameras) {
        Camera::from_json(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

/// Points of the path-traced references carry the albedo of the texel, found by another program. That program
/// counted the rows of a texture from the bottom, unlike glTF, so it saw what we see at 1 - v; where the scene
/// itself says which is up (v falls with the height on its walls), glTF's reading is the upright one.
#[test]
fn textures_give_the_albedo_that_the_reference_renderer_saw() {
    let (Some(results), Some((mut scene, _))) = (shared("reference/results"), load("sponza/sponza.glb")) else {
        return;
    };
    scene.mesh.uv.iter_mut().for_each(|uv| uv[1] = 1.0 - uv[1]);
    let text = std::fs::read_to_string(results.join("sponza_points.csv")).unwrap();
    let mut rows = text.lines().filter(|l| !l.starts_with('#')).map(|l| l.split(',').collect::<Vec<_>>());
    let header = rows.next().expect("a header");
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap_or_else(|| panic!("column {name}"));
    let (p, albedo) = (["px", "py", "pz"].map(column), ["albedo_r", "albedo_g", "albedo_b"].map(column));
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials).unwrap();
    let number = |row: &[&str], at: usize| row[at].parse::<f64>().expect("a number");
    let (mut worst, mut off, mut n) = (0.0f64, 0, 0);
    for row in rows.step_by(4) {
        let point = DVec3::from(p.map(|c| number(&row, c)));
        let Some((t, u, v)) = nearest(&scene, point) else { continue };
        let ours = surfaces.reflectance(t, u, v);
        let theirs = albedo.map(|c| number(&row, c));
        let error = (0..3).map(|c| (f64::from(ours[c]) - theirs[c]).abs()).fold(0.0, f64::max);
        worst = worst.max(error);
        off += usize::from(error > 0.01);
        n += 1;
    }
    assert!(n > 100, "{n}");
    // Where sheets of different materials touch, the point may be taken for the other's.
    assert!(off * 50 <= n, "{off} of {n} points differ by more than 0.01, the worst by {worst}");
}

/// The triangle on which a point lies, and its barycentric weights.
fn nearest(scene: &Scene, point: DVec3) -> Option<(u32, f32, f32)> {
    let mut best: Option<(f64, (u32, f32, f32))> = None;
    for (t, corners) in corners(scene).into_iter().enumerate() {
        let [a, b, c] = corners.map(DVec3::from);
        let (e, f, g) = (b - a, c - a, point - a);
        let n = e.cross(f);
        let square = n.length_squared();
        let (u, v) = (g.cross(f).dot(n) / square, e.cross(g).dot(n) / square);
        let distance = (g.dot(n) / square.sqrt()).abs();
        if u > -1e-5 && v > -1e-5 && u + v < 1.0 + 1e-5 && distance < 1e-4 && best.is_none_or(|(d, _)| distance < d) {
            best = Some((distance, (t as u32, u as f32, v as f32)));
        }
    }
    best.map(|(_, hit)| hit)
}
