//! The gather at receivers, and frames put together from their parts.

mod common;

use common::{Numbers, cornell, diagonal_operator, gpu, room, wall};
use gpu_runtime::{GpuRuntime, Params};
use radfile::{PointRows, Rows};
use scene::{Light, LightRig};

/// Weights of a few patches each, some rows empty.
fn rows(receivers: u32, patches: u32) -> Rows {
    let mut numbers = Numbers(3);
    let mut rows = Rows { row_start: vec![0], ..Rows::default() };
    for r in 0..receivers {
        for _ in 0..r % 7 {
            rows.patch.push((numbers.unit() * patches as f32) as u32);
            rows.weight.push(numbers.unit() / 6.0);
        }
        rows.row_start.push(rows.patch.len() as u32);
    }
    rows
}

fn small() -> Params {
    Params { patch_samples: 4, shadow_resolution: 128, light_samples: 4, ..Params::default() }
}

#[test]
fn the_gather_is_that_of_the_rows() {
    let Some(gpu) = gpu() else { return };
    let room = room(&[wall([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [10, 10])]);
    let packed = diagonal_operator(100, 0.5);
    let runtime =
        GpuRuntime::new(&gpu, &room.scene, &room.patches, &packed, &room.sky, &room.transfer, &small()).unwrap();
    let mut numbers = Numbers(9);
    let light: Vec<[f32; 3]> = (0..100).map(|_| std::array::from_fn(|_| 10.0 * numbers.unit())).collect();
    let rows = rows(1000, 100);
    let (found, truth) = (runtime.gather(&rows, &light).unwrap(), rows.gather(&light));
    for (f, t) in found.as_flattened().iter().zip(truth.as_flattened()) {
        assert!((f - t).abs() <= 1e-5 * t.abs().max(1.0), "{f} {t}");
    }
    assert_eq!(runtime.gather(&Rows { row_start: vec![0], ..Rows::default() }, &light).unwrap(), [[0.0; 3]; 0]);
}

#[test]
fn a_frame_in_one_submission_is_the_sum_of_its_parts() {
    let Some(gpu) = gpu() else { return };
    let mut room = cornell(4);
    room.sky.iter_mut().enumerate().for_each(|(i, s)| *s = (i % 3) as f32 * 0.1);
    let packed = diagonal_operator(room.patches.len() as u32, 0.5);
    let runtime =
        GpuRuntime::new(&gpu, &room.scene, &room.patches, &packed, &room.sky, &room.transfer, &small()).unwrap();
    let lights = vec![
        Light::Point { position: [2.7, 2.8, 4.5], intensity: [5.0, 4.0, 3.0] },
        Light::Quad { corner: [2.0, 2.0, 5.4], edge_u: [0.0, 1.0, 0.0], edge_v: [1.0, 0.0, 0.0], radiance: [1.0; 3] },
        Light::Sky { radiance: [0.2, 0.3, 0.4] },
    ];
    let rig = LightRig { lights, ..LightRig::default() };
    let frame = runtime.relight(&rig).unwrap();
    assert_eq!(frame.direct, runtime.patch_direct(&rig).unwrap());
    assert_eq!(frame.indirect, runtime.patch_indirect(&frame.direct).unwrap());
    assert_eq!(frame.receivers, runtime.gather(&room.transfer.rows, &frame.indirect).unwrap());
    for (i, (h, h0)) in frame.indirect.iter().zip(&frame.direct).enumerate() {
        let expected = 0.5 * room.patches.reflectance[i][0] * h0[0];
        assert!((h[0] - expected).abs() <= 1e-5 * expected, "patch {i}: {h:?}, half of what is reflected {expected}");
    }
    // The sky adds pi L times what the patch sees of it, and nothing else.
    let dark = LightRig { lights: rig.lights[..2].to_vec(), ..LightRig::default() };
    for (i, (with, without)) in frame.direct.iter().zip(runtime.patch_direct(&dark).unwrap()).enumerate() {
        let sky = std::f32::consts::PI * 0.4 * room.sky[i];
        assert!((with[2] - without[2] - sky).abs() < 1e-5 * (1.0 + with[2]), "patch {i}");
    }
    let (position, normal) = (&room.transfer.position, &room.transfer.normal);
    let rows = PointRows::Interpolated(room.transfer.rows.clone());
    assert_eq!(runtime.relight_points(&rig, position, normal, &rows).unwrap().indirect, frame.receivers);

    // A last gather takes what the patches send, and the sky as its points see it.
    let seen: Vec<f32> = (0..position.len()).map(|i| (i % 5) as f32 * 0.2).collect();
    let rows = PointRows::Gathered { rows: room.transfer.rows.clone(), sky: seen.clone() };
    let gathered = runtime.relight_points(&rig, position, normal, &rows).unwrap();
    let in_the_dark = runtime.relight_points(&dark, position, normal, &rows).unwrap();
    let bake_light = relight::Frame { direct: frame.direct, indirect: frame.indirect };
    let expected = room.transfer.rows.gather(&relight::radiosity(&room.patches, &bake_light));
    for (i, (found, wanted)) in gathered.indirect.iter().zip(&expected).enumerate() {
        assert!((found[1] - wanted[1]).abs() <= 1e-5 * wanted[1], "point {i}: {found:?}, the twin has {wanted:?}");
        let sky = std::f32::consts::PI * 0.4 * seen[i];
        let found = gathered.direct[i][2] - in_the_dark.direct[i][2];
        assert!((found - sky).abs() < 1e-5 * (1.0 + gathered.direct[i][2]), "point {i}: sky {found}, expected {sky}");
    }
    let short = PointRows::Gathered { rows: room.transfer.rows.clone(), sky: seen[1..].to_vec() };
    let text = runtime.relight_points(&rig, position, normal, &short).unwrap_err().to_string();
    assert!(text.contains("shares of the sky"), "{text}");
}
