//! The irradiance volume that `export` writes: its texture read by another program's reader, its light held against
//! `relight` and a furnace.

use std::{
    f32::consts::PI,
    path::{Path, PathBuf},
};

use allbounce_tests::{
    asset,
    mesh_text::{MeshText, Paint},
    program::allbounce,
    reference::Table,
    shapes::inside_of_box,
    text,
};
use half::f16;
use radfile::{Container, Mesh, Record, Volume};
use serde_json::{Value, json};

fn bake(scene: &str, folder: &Path, options: &[&str]) -> PathBuf {
    let bake = folder.join("bake.rad");
    let few = ["--patches", "300", "--edge", "0.5m", "-q"];
    allbounce(["bake", scene, "-o", &text(&bake)].iter().chain(&few).chain(options)).done();
    bake
}

/// Exports the volume; returns what `volume.json` says.
fn export(bake: &Path, lights: &str, to: &Path, options: &[&str]) -> Value {
    let args = ["export", &text(bake), "--lights", lights, "-o", &text(to), "-q"];
    allbounce(args.iter().chain(options)).done();
    serde_json::from_str(&std::fs::read_to_string(to.join("volume.json")).expect("a description")).expect("JSON")
}

/// Numbers of a raw file, so many colours a cell.
fn raw<const N: usize>(path: &Path) -> Vec<[[f32; 3]; N]> {
    let bytes = std::fs::read(path).expect("a file");
    let numbers: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|&b| f32::from_le_bytes(b)).collect();
    assert_eq!(numbers.len() % (3 * N), 0);
    numbers.as_chunks::<3>().0.as_chunks::<N>().0.to_vec()
}

/// Irradiance at every probe in its six directions, gathered anew by `relight`.
fn asked(bake: &Path, volume: &Volume, lights: &str, folder: &Path) -> Vec<[f64; 3]> {
    let origin = Mesh::read(&Container::open(bake).expect("the bake")).expect("mesh").origin;
    let (points, answers) = (folder.join("points.csv"), folder.join("answers.csv"));
    let mut writer = csv::Writer::from_path(&points).expect("a file");
    writer.write_record(["px", "py", "pz", "nx", "ny", "nz"]).expect("a record");
    for (position, normal) in volume.position.iter().flat_map(|p| Volume::NORMALS.map(|n| (p, n))) {
        let place = (0..3).map(|a| (f64::from(position[a]) + origin[a]).to_string());
        writer.write_record(place.chain(normal.iter().map(f32::to_string))).expect("a record");
    }
    writer.flush().expect("a file");
    let ask = ["relight", &text(bake), "--lights", lights, "--points", &text(&points), "-o", &text(&answers)];
    allbounce(ask.iter().chain(&["--gather-rays", "1024", "-q"])).done();
    let table = Table::read(&answers);
    let [r, g, b] = ["r", "g", "b"].map(|c| {
        let [direct, indirect] = ["direct", "indirect"].map(|part| table.column(&format!("{part}_{c}")));
        direct.iter().zip(indirect).map(|(d, i)| d + i).collect::<Vec<f64>>()
    });
    (0..r.len()).map(|i| [r[i], g[i], b[i]]).collect()
}

#[test]
fn the_cornell_box_lights_its_probes_and_all_files_say_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let (lamp, out) = (asset("cornell/lamp.json"), folder.path().join("out"));
    let bake = bake(&asset("cornell/cornell.obj"), folder.path(), &["--volume", "0.06m"]);
    let told = export(&bake, &lamp, &out, &["--volume"]);
    assert!(!out.join("vertex_colours.glb").exists(), "it was not asked for");
    let volume = Volume::read(&Container::open(&bake).expect("the bake")).expect("a volume");
    let [nx, ny, nz] = volume.count.map(|n| n as usize);
    assert_eq!((told["cells"].clone(), [nx, ny, nz]), (json!(volume.count), [10; 3]));

    // The blocks are solid: no probe is in them, and what stands there is not dark.
    let cubes: Vec<[[f32; 3]; 6]> = raw(&out.join("volume.raw"));
    assert_eq!(cubes.len(), nx * ny * nz);
    let filled = told["filled_cells"].as_array().expect("a list");
    assert!(filled.contains(&json!(3 + nx * (1 + ny * 3))), "the short block stands here: {filled:?}");
    assert_eq!(filled.len(), volume.cells() - volume.probes());
    assert!(cubes.iter().all(|cube| cube.iter().all(|e| e[0] > 0.0)));
    // The red wall is at large x, the green one at small x; the floor is below.
    let middle = |x: usize| &cubes[x + nx * (6 + ny * 2)];
    let red = |e: &[f32; 3]| e[0] / e[1];
    assert!(red(&middle(9)[0]) > 5.0 && red(&middle(0)[1]) < 0.7, "{:?} {:?}", middle(9)[0], middle(0)[1]);
    assert!(red(&middle(0)[0]) < red(&middle(9)[0]), "it is redder beside the red wall");

    // Packed, and by other rays of the last gather and other samples of the lamp.
    let expected = asked(&bake, &volume, &lamp, folder.path());
    let found = volume.cell.iter().flat_map(|&cell| cubes[cell as usize]);
    let (mut error, mut light) = (0.0, 0.0);
    for (found, expected) in found.zip(&expected) {
        for c in 0..3 {
            error += (f64::from(found[c]) - expected[c]).powi(2);
            light += expected[c].powi(2);
        }
    }
    let relative = (error / light).sqrt();
    assert!(relative < 0.03, "probes are {relative} off");

    let harmonics: Vec<[[f32; 3]; 4]> = raw(&out.join("volume_sh.raw"));
    for (cube, [a, bx, by, bz]) in cubes.iter().zip(&harmonics) {
        for c in 0..3 {
            let off = |b: &[f32; 3], axis: usize| b[c] - 0.5 * (cube[2 * axis][c] - cube[2 * axis + 1][c]);
            let mean = cube.iter().map(|e| e[c]).sum::<f32>() / 6.0;
            assert!([off(bx, 0), off(by, 1), off(bz, 2), a[c] - mean].iter().all(|d| d.abs() < 1e-4 * mean));
        }
    }
    check_texture(&out.join("volume.ktx2"), &cubes, [nx, ny, nz]);

    let bevy = &told["volume.ktx2"]["bevy"];
    let number = |list: &str, a: usize| bevy[list][a].as_f64().expect("a number");
    for a in 0..3 {
        let low = told["lower_corner"][a].as_f64().expect("a number");
        assert!((number("translation", a) - 0.5 * number("scale", a) - low).abs() < 1e-6);
        assert!((number("scale", a) - 0.556).abs() < 0.01, "the box is half a metre and a bit");
    }
    assert_eq!(bevy["intensity"], 1.0);
}

/// The texture is the cubes over π, a direction where Bevy's shader looks for it.
fn check_texture(path: &Path, cubes: &[[[f32; 3]; 6]], [nx, ny, nz]: [usize; 3]) {
    let file = ktx2::Reader::new(std::fs::read(path).expect("a file")).expect("a KTX2 file");
    let header = file.header();
    assert_eq!(header.format, Some(ktx2::Format::R16G16B16A16_SFLOAT));
    let size = [header.pixel_width, header.pixel_height, header.pixel_depth].map(|n| n as usize);
    assert_eq!((size, header.level_count, header.supercompression_scheme), ([nx, 2 * ny, 3 * nz], 1, None));
    assert_eq!(file.transfer_function(), Some(ktx2::TransferFunction::Linear));
    let samples: Vec<[f32; 2]> = file
        .basic_dfd()
        .expect("a descriptor")
        .sample_information
        .iter()
        .map(|s| [s.bit_offset.into(), s.bit_length.get().into()])
        .collect();
    assert_eq!(samples, [[0.0, 16.0], [16.0, 16.0], [32.0, 16.0], [48.0, 16.0]]);
    let level = file.levels().next().expect("a level");
    let texels = level.data.as_chunks::<2>().0.as_chunks::<4>().0;
    assert_eq!(texels.len(), 36 * cubes.len() / 6);
    for (cell, cube) in cubes.iter().enumerate() {
        let [x, y, z] = [cell % nx, cell / nx % ny, cell / nx / ny];
        for (direction, expected) in cube.iter().enumerate() {
            let (axis, negative) = (direction / 2, direction % 2);
            let [u, v, w] = [x, y + negative * ny, z + axis * nz];
            let texel = texels[u + size[0] * (v + size[1] * w)].map(|b| f16::from_le_bytes(b).to_f32());
            // Half precision has eleven bits.
            let near = |c: usize| (texel[c] * PI - expected[c]).abs() <= expected[c] / 2048.0 + 1e-6;
            assert!((0..3).all(near) && texel[3] == 1.0, "cell {cell}, direction {direction}: {texel:?}, {expected:?}");
        }
    }
}

/// Walls of reflectance ρ that emit 1 − ρ: irradiance is 1 everywhere (theory.md (7.1)).
#[test]
fn in_a_furnace_every_probe_gets_the_same_from_everywhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let reflectance = [0.5, 0.8, 0.95];
    let glow = Paint { name: "glow", reflectance, emission: reflectance.map(|rho| (1.0 - rho) / std::f64::consts::PI) };
    let mut mesh = MeshText::default();
    inside_of_box([-1.0, 10.0, 3.0], [2.0, 12.0, 5.5]).iter().for_each(|wall| wall.add(&mut mesh, glow));
    let [scene, lights, out] = ["room.obj", "lights.json", "out"].map(|name| folder.path().join(name));
    std::fs::write(&scene, mesh.obj("room.mtl")).expect("a file");
    std::fs::write(folder.path().join("room.mtl"), mesh.mtl()).expect("a file");
    std::fs::write(&lights, json!({ "use_scene_emission": true, "lights": [] }).to_string()).expect("a file");
    let bake = bake(&text(&scene), folder.path(), &["--one-sided", "--volume", "0.5m"]);
    let told = export(&bake, &text(&lights), &out, &["--volume"]);
    assert_eq!((&told["cells"], &told["lower_corner"]), (&json!([6, 4, 5]), &json!([-1.0, 10.0, 3.0])));
    assert_eq!(told["filled_cells"], json!([]));
    // Packing may change the light of single receivers by a few times what it changes all of it by.
    close_to([1.0; 3], &out);
    // Without bounces it is what the walls emit.
    export(&bake, &text(&lights), &out, &["--volume", "--direct-only"]);
    close_to(reflectance.map(|rho| 1.0 - rho), &out);
}

/// Asserts that all irradiances are what is expected, to 1 % in the mean and 10 % at most.
fn close_to(expected: [f64; 3], out: &Path) {
    let cubes = raw::<6>(&out.join("volume.raw"));
    for (c, expected) in expected.into_iter().enumerate() {
        let off: Vec<f64> = cubes.as_flattened().iter().map(|e| f64::from(e[c]) / expected - 1.0).collect();
        let rms = (off.iter().map(|d| d * d).sum::<f64>() / off.len() as f64).sqrt();
        let worst = off.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        println!("irradiance {expected} is off by {rms:.1e}, at most {worst:.1e}");
        assert!(rms < 0.01 && worst < 0.1, "irradiance {expected} is off by {rms}, at most {worst}");
    }
}

#[test]
fn a_bake_without_a_volume_says_how_to_get_one_and_too_many_cells_how_many_fit() {
    let folder = tempfile::tempdir().expect("a folder");
    let bake = bake(&asset("cornell/cornell.obj"), folder.path(), &["--gather-rays", "64"]);
    let lamp = asset("cornell/lamp.json");
    let args = ["export", &text(&bake), "--lights", &lamp, "-o", &text(folder.path()), "--volume", "-q"];
    allbounce(args).refused(&["bake.rad", "the bake has no irradiance volume", "transfer --volume"]);
    let finer = folder.path().join("finer.rad");
    allbounce(["transfer", &text(&bake), "-o", &text(&finer), "--volume", "1mm", "-q"]).refused(&[
        "probes every 0.001 m are [556, 549, 560]",
        "the limit is 131072",
        "a spacing of 0.01",
    ]);
}
