//! What `export` writes: read back by other programs' readers, and held against `relight`.

use std::path::{Path, PathBuf};

use allbounce_tests::{asset, program::allbounce, reference::Table, text};
use exr::prelude::read_first_flat_layer_from_file;
use radfile::{Container, Lightmap, Mesh, Record, Transfer};
use tempfile::TempDir;

/// A small bake of the Cornell box with a lightmap, and its folder.
fn bake() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let bake = folder.path().join("bake.rad");
    let size = ["--patches", "400", "--lightmap", "900", "--edge", "0.2m", "-q"];
    allbounce(["bake", &asset("cornell/cornell.obj"), "-o", &text(&bake)].iter().chain(&size)).done();
    (folder, bake)
}

/// Exports the bake under the lamp.
fn export(bake: &Path, to: &Path, options: &[&str]) -> serde_json::Value {
    let (lamp, report) = (asset("cornell/lamp.json"), bake.with_file_name("report.json"));
    let args = ["export", &text(bake), "--lights", &lamp, "-o", &text(to), "--report", &text(&report), "-q"];
    allbounce(args.iter().chain(options)).done();
    serde_json::from_str(&std::fs::read_to_string(report).expect("a report")).expect("JSON")
}

/// The pixels of an EXR file, R, G, B.
fn pixels(path: &Path) -> Vec<[f32; 3]> {
    let image = read_first_flat_layer_from_file(path).expect("an EXR file");
    let channel = |name: &str| {
        let found = image.layer_data.channel_data.list.iter().find(|c| c.name.eq(name));
        found.expect("the channel").sample_data.values_as_f32().collect::<Vec<f32>>()
    };
    let [r, g, b] = ["R", "G", "B"].map(channel);
    (0..r.len()).map(|i| [r[i], g[i], b[i]]).collect()
}

/// Document and buffer of a glTF file.
fn opened(path: &Path) -> (gltf::Document, Vec<u8>) {
    let file = gltf::Gltf::from_slice(&std::fs::read(path).expect("a file")).expect("a glTF file");
    (file.document, file.blob.expect("a buffer"))
}

/// Points in the axes of the scene file as a CSV file.
fn write_points(mesh: &Mesh, position: &[[f32; 3]], normal: &[[f32; 3]], path: &Path) {
    let mut writer = csv::Writer::from_path(path).expect("a file");
    writer.write_record(["px", "py", "pz", "nx", "ny", "nz"]).expect("a record");
    for (p, n) in position.iter().zip(normal) {
        let place = (0..3).map(|a| (f64::from(p[a]) + mesh.origin[a]).to_string());
        writer.write_record(place.chain(n.iter().map(f32::to_string))).expect("a record");
    }
    writer.flush().expect("a file");
}

/// Irradiance of the rows of `relight`.
fn irradiance(path: &Path) -> Vec<[f64; 3]> {
    let table = Table::read(path);
    let column = |c: &str| {
        let [direct, indirect] = ["direct", "indirect"].map(|part| table.column(&format!("{part}_{c}")));
        direct.iter().zip(indirect).map(|(d, i)| d + i).collect::<Vec<f64>>()
    };
    let [r, g, b] = ["r", "g", "b"].map(column);
    (0..r.len()).map(|i| [r[i], g[i], b[i]]).collect()
}

/// Root of the mean square of the difference of two tables, relative to the mean of the second.
fn rms(found: &[[f64; 3]], expected: &[[f64; 3]]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let n = (3 * found.len()) as f64;
    let square: f64 =
        found.as_flattened().iter().zip(expected.as_flattened()).map(|(f, e)| (f - e).powi(2)).sum::<f64>();
    (square / n).sqrt() / (expected.as_flattened().iter().sum::<f64>() / n)
}

#[test]
fn texels_have_the_light_that_points_have_and_gltf_shows_where_they_lie() {
    let (folder, bake) = bake();
    let out = folder.path().join("out");
    let report = export(&bake, &out, &[]);
    let container = Container::open(&bake).expect("the bake");
    let (mesh, map) = (Mesh::read(&container).expect("mesh"), Lightmap::read(&container).expect("a lightmap"));

    // Each texel shows its receiver, the others nothing.
    let linear = pixels(&out.join("lightmap.exr"));
    assert_eq!(linear.len(), map.receiver.len());
    let at_receivers: Vec<[f64; 3]> = map.texel.iter().map(|&x| linear[x as usize].map(f64::from)).collect();
    for (pixel, &receiver) in linear.iter().zip(&map.receiver) {
        let expected = map.texel.get(receiver as usize).map_or([0.0; 3], |&x| linear[x as usize]);
        assert_eq!(*pixel, expected);
    }
    let (points, answers) = (folder.path().join("points.csv"), folder.path().join("answers.csv"));
    write_points(&mesh, &map.position, &map.normal, &points);
    let lamp = asset("cornell/lamp.json");
    let ask = ["relight", &text(&bake), "--lights", &lamp, "--points", &text(&points), "-o", &text(&answers), "-q"];
    allbounce(ask).done();
    // Packed, and by other rays of the last gather and other samples of the lamp.
    let error = rms(&at_receivers, &irradiance(&answers));
    assert!(error < 0.03, "texels are {error} off");

    let radiance = pixels(&out.join("lightmap_radiance.exr"));
    let brighter = |(l, e): (&[f32; 3], &[f32; 3])| (0..3).any(|c| l[c] * std::f32::consts::PI > e[c] * 0.9901);
    assert!(!radiance.iter().zip(&linear).any(brighter), "a surface reflects more than it gets");
    assert!(radiance.iter().any(|l| l[0] > 0.0));

    let (document, buffer) = opened(&out.join("scene.glb"));
    let mut triangles = 0;
    for primitive in document.meshes().flat_map(|m| m.primitives().collect::<Vec<_>>()) {
        let reader = primitive.reader(|_| Some(&buffer));
        let positions: Vec<[f32; 3]> = reader.read_positions().expect("positions").collect();
        let uv: Vec<[f32; 2]> = reader.read_tex_coords(0).expect("coordinates").into_f32().collect();
        assert_eq!(uv.len(), positions.len());
        assert!(uv.as_flattened().iter().all(|x| (0.0..=1.0).contains(x)));
        let bounds = primitive.bounding_box();
        let within = |p: &[f32; 3]| (0..3).all(|a| (bounds.min[a]..=bounds.max[a]).contains(&p[a]));
        assert!(positions.iter().all(within));
        for corners in reader.read_indices().expect("indices").into_u32().collect::<Vec<_>>().as_chunks::<3>().0 {
            // The triangle is one of the mesh, with its own coordinates.
            let corners = corners.map(|i| (positions[i as usize], uv[i as usize]));
            let same = |t: usize| (0..3).all(|k| (mesh.corners(t)[k], map.corner_uv[t][k]) == corners[k]);
            assert!((0..mesh.triangles.len()).any(same), "{corners:?}");
            triangles += 1;
        }
    }
    assert_eq!(triangles, mesh.triangles.len());
    assert_eq!(report["lightmap"]["receivers"], map.receivers());
    assert_eq!(report["files"].as_array().map(Vec::len), Some(7));
}

#[test]
fn colours_of_vertices_are_the_light_of_their_receivers() {
    let (folder, bake) = bake();
    let out = folder.path().join("out");
    let report = export(&bake, &out, &["--vertex-colours", "--csv"]);
    assert!(!out.join("lightmap.exr").exists() && !out.join("scene.glb").exists(), "they were not asked for");
    let container = Container::open(&bake).expect("the bake");
    let (mesh, transfer) = (Mesh::read(&container).expect("mesh"), Transfer::read(&container).expect("transfer"));
    let light = irradiance(&out.join("receivers.csv"));
    assert_eq!(light.len(), transfer.receivers());
    let white = report["vertex_colours"]["irradiance_of_white"].as_f64().expect("a number");
    let (document, buffer) = opened(&out.join("vertex_colours.glb"));
    let node = document.nodes().next().expect("a node").transform().decomposed().0;
    assert_eq!(node, mesh.origin.map(|x| x as f32));
    let mut expected: Vec<([u32; 3], [f64; 3])> = Vec::new();
    for (t, corners) in transfer.fine.triangle.iter().enumerate() {
        for side in transfer.fine.receiver[t].iter().filter(|side| !side.contains(&radfile::NO_RECEIVER)) {
            let corner =
                |k: usize| (transfer.fine.vertex[corners[k] as usize].map(f32::to_bits), light[side[k] as usize]);
            expected.extend((0..3).map(corner));
        }
    }
    let mut corners = 0;
    for primitive in document.meshes().flat_map(|m| m.primitives().collect::<Vec<_>>()) {
        let reader = primitive.reader(|_| Some(&buffer));
        let positions: Vec<[f32; 3]> = reader.read_positions().expect("positions").collect();
        let colours: Vec<[f32; 4]> = reader.read_colors(0).expect("colours").into_rgba_f32().collect();
        for i in reader.read_indices().expect("indices").into_u32() {
            let (place, colour) = (positions[i as usize].map(f32::to_bits), colours[i as usize]);
            let near = |e: &[f64; 3]| (0..3).all(|c| (f64::from(colour[c]) * white - e[c]).abs() < 1e-5 * white);
            assert!(
                expected.iter().any(|(p, e)| *p == place && near(e)),
                "{colour:?} is the light of no receiver there"
            );
            corners += 1;
        }
    }
    assert_eq!(corners, expected.len());
}

#[test]
fn inputs_are_not_overwritten_and_what_is_missing_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let bake = folder.path().join("bake.rad");
    let size = ["--patches", "150", "--gather-rays", "64", "-q"];
    allbounce(["bake", &asset("cornell/cornell.obj"), "-o", &text(&bake)].iter().chain(&size)).done();
    let lights = folder.path().join("receivers.csv");
    std::fs::copy(asset("cornell/lamp.json"), &lights).expect("a copy");
    let run = |options: &[&str]| {
        let args = ["export", &text(&bake), "--lights", &text(&lights), "-o", &text(folder.path()), "-q"];
        allbounce(args.iter().chain(options))
    };
    run(&["--lightmap"]).refused(&["bake.rad", "the bake has no lightmap", "transfer --lightmap"]);
    run(&["--csv"]).refused(&["receivers.csv", "would overwrite the lights"]);
    assert!(run(&["--vertex-colours"]).done().stderr.is_empty());
    assert!(folder.path().join("vertex_colours.glb").exists());
}

#[test]
fn textures_are_in_the_file_as_they_were() {
    let folder = tempfile::tempdir().expect("a folder");
    let [scene, bake, out] = ["room.obj", "bake.rad", "out"].map(|name| folder.path().join(name));
    let board = image::RgbImage::from_fn(4, 2, |x, y| image::Rgb([40 + 50 * x as u8, 200 - 60 * y as u8, 90]));
    board.save(folder.path().join("board.png")).expect("a texture");
    let materials = "newmtl board\nKd 1 1 1\nmap_Kd board.png\nnewmtl plain\nKd 0.5 0.4 0.3\n";
    std::fs::write(folder.path().join("room.mtl"), materials).expect("a file");
    // A textured floor below a plain ceiling.
    let corners = "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\n";
    let coordinates = "vt 0 0\nvt 0 2\nvt 1 2\nvt 1 0\n";
    let faces = "usemtl board\nf 1/1 2/2 3/3 4/4\nusemtl plain\nf 5/1 6/2 7/3 8/4\n";
    std::fs::write(&scene, format!("mtllib room.mtl\n{corners}{coordinates}{faces}")).expect("a scene");
    let size = ["--voxel", "0.5m", "--rays", "256", "--gather-rays", "64", "--lightmap", "100", "-q"];
    allbounce(["bake", &text(&scene), "-o", &text(&bake)].iter().chain(&size)).done();
    export(&bake, &out, &["--lightmap"]);

    let container = Container::open(&bake).expect("the bake");
    let mesh = Mesh::read(&container).expect("mesh");
    let (document, buffer) = opened(&out.join("scene.glb"));
    let mut textured = 0;
    for primitive in document.meshes().flat_map(|m| m.primitives().collect::<Vec<_>>()) {
        let Some(colour) = primitive.material().pbr_metallic_roughness().base_color_texture() else {
            assert_eq!(primitive.material().name(), Some("plain"));
            continue;
        };
        assert_eq!(primitive.material().name(), Some("board"));
        let gltf::image::Source::View { view, mime_type } = colour.texture().source().source() else {
            panic!("the image is not in the file")
        };
        assert_eq!(mime_type, "image/png");
        let bytes = &buffer[view.offset()..][..view.length()];
        assert_eq!(image::load_from_memory(bytes).expect("an image").into_rgb8(), board);
        // The lightmap's coordinates come after the texture's.
        assert_eq!(colour.tex_coord(), 0);
        let reader = primitive.reader(|_| Some(&buffer));
        assert!(reader.read_tex_coords(1).is_some());
        let positions: Vec<[f32; 3]> = reader.read_positions().expect("positions").collect();
        let uv: Vec<[f32; 2]> = reader.read_tex_coords(0).expect("coordinates").into_f32().collect();
        for corner in reader.read_indices().expect("indices").into_u32() {
            let (position, uv) = (positions[corner as usize], uv[corner as usize]);
            let of_file: Vec<[f32; 2]> = mesh
                .triangles
                .iter()
                .flatten()
                .map(|v| *v as usize)
                .filter(|v| mesh.positions[*v] == position)
                .map(|v| mesh.uv[v])
                .collect();
            assert!(of_file.contains(&uv), "{uv:?} is none of {of_file:?}");
            textured += 1;
        }
    }
    assert_eq!(textured, 6, "corners of the floor's two triangles");
}
