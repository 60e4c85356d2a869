//! The gather at receivers, and frames put together from their parts.

mod common;

use common::{Numbers, cornell, diagonal_operator, gpu, room, wall};
use gpu_runtime::{GpuRuntime, Params};
use radfile::{GatherCertificate, Gathered, PointRows, Quiet, Rows, Weights};
use scene::{Light, LightRig};

/// Weights of a few patches each, some rows empty.
fn rows(receivers: u32, patches: u32) -> Rows {
    let mut numbers = Numbers(3);
    let mut rows = Rows { row_start: vec![0], ..Rows::default() };
    for r in 0..receivers {
        for _ in 0..r % 7 {
            rows.sender.push((numbers.unit() * patches as f32) as u32);
            rows.weight.push(numbers.unit() / 6.0);
        }
        rows.row_start.push(rows.sender.len() as u32);
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
    let runtime = GpuRuntime::new(&gpu, &room.bake(), &packed, &small()).unwrap();
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
    let runtime = GpuRuntime::new(&gpu, &room.bake(), &packed, &small()).unwrap();
    let lights = vec![
        Light::Point { position: [2.7, 2.8, 4.5], intensity: [5.0, 4.0, 3.0] },
        Light::Quad { corner: [2.0, 2.0, 5.4], edge_u: [0.0, 1.0, 0.0], edge_v: [1.0, 0.0, 0.0], radiance: [1.0; 3] },
        Light::Sky { radiance: [0.2, 0.3, 0.4] },
    ];
    let rig = LightRig { lights, ..LightRig::default() };
    let frame = runtime.relight(&rig).unwrap();
    assert_eq!(frame.direct, runtime.patch_direct(&rig).unwrap());
    assert_eq!(frame.indirect, runtime.patch_indirect(&frame.direct).unwrap());
    assert_eq!(frame.receivers, runtime.gather(&room.rows, &frame.indirect).unwrap());
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
    let rows = PointRows::Interpolated(room.rows.clone());
    assert_eq!(runtime.relight_points(&rig, position, normal, &rows).unwrap().indirect, frame.receivers);

    // A last gather takes what the patches send, and the sky as its points see it.
    let seen: Vec<f32> = (0..position.len()).map(|i| (i % 5) as f32 * 0.2).collect();
    let rows = PointRows::Gathered { rows: room.rows.clone(), sky: seen.clone() };
    let gathered = runtime.relight_points(&rig, position, normal, &rows).unwrap();
    let in_the_dark = runtime.relight_points(&dark, position, normal, &rows).unwrap();
    let bake_light =
        relight::Frame { element_direct: frame.direct.clone(), direct: frame.direct, indirect: frame.indirect };
    let expected = room.rows.gather(&relight::radiosity(&room.elements, &bake_light));
    for (i, (found, wanted)) in gathered.indirect.iter().zip(&expected).enumerate() {
        assert!((found[1] - wanted[1]).abs() <= 1e-5 * wanted[1], "point {i}: {found:?}, the twin has {wanted:?}");
        let sky = std::f32::consts::PI * 0.4 * seen[i];
        let found = gathered.direct[i][2] - in_the_dark.direct[i][2];
        assert!((found - sky).abs() < 1e-5 * (1.0 + gathered.direct[i][2]), "point {i}: sky {found}, expected {sky}");
    }
    let short = PointRows::Gathered { rows: room.rows.clone(), sky: seen[1..].to_vec() };
    let text = runtime.relight_points(&rig, position, normal, &short).unwrap_err().to_string();
    assert!(text.contains("shares of the sky"), "{text}");
}

/// Receivers that gather from patches and elements: the GPU's frame against the CPU's radiosities and product.
#[test]
fn gathered_receivers_have_the_light_of_the_twin() {
    let Some(gpu) = gpu() else { return };
    let mut room = cornell(3);
    let (n, receivers) = (room.patches.len(), room.transfer.receivers());
    room.sky.fill(0.1);
    let row = |receiver: usize, out: &mut hmatrix::Row| {
        // A third of the patches as a whole, as many elements: here each is a patch of its own.
        out.extend((0..n as u32).filter(|p| (*p as usize + receiver).is_multiple_of(3)).map(|p| (p, 1.2 / n as f32)));
        out.extend((0..n as u32).filter(|p| (*p as usize + receiver) % 3 == 1).map(|p| (n as u32 + p, 0.9 / n as f32)));
    };
    let twice = |values: &[[f32; 3]]| [values, values].concat();
    let (position, normal) = (twice(&room.patches.position), twice(&room.patches.normal));
    let (area, reflectance) = ([&room.patches.area[..]; 2].concat(), twice(&room.patches.reflectance));
    let senders = hmatrix::Senders { position: &position, normal: &normal, area: &area, reflectance: &reflectance };
    let places = hmatrix::Receivers { position: &room.transfer.position, normal: &room.transfer.normal };
    let packed = hmatrix::compress_rows(&places, &senders, &row, &hmatrix::Params::error(0.001), &Quiet).unwrap().0;
    let certificate = GatherCertificate { senders: 2 * n as u32, rays: 1, error_wanted: 0.001, ..Default::default() };
    let gathered = Gathered { certificate, stream: packed.to_bytes().to_vec(), sky: vec![0.2; receivers] };
    room.transfer.weights = Weights::Gathered(gathered);
    let operator = diagonal_operator(n as u32, 0.5);
    let runtime = GpuRuntime::new(&gpu, &room.bake(), &operator, &small()).unwrap();
    let lamp = Light::Point { position: [2.7, 2.8, 4.5], intensity: [5.0, 4.0, 3.0] };
    let lights = vec![lamp, Light::Sky { radiance: [0.2, 0.3, 0.4] }];
    let rig = LightRig { lights, ..LightRig::default() };
    let frame = runtime.relight(&rig).unwrap();
    let light = relight::Frame { element_direct: frame.direct.clone(), direct: frame.direct, indirect: frame.indirect };
    let mut expected = vec![[0.0; 3]; receivers];
    packed.multiply(&relight::radiosity(&room.elements, &light), &mut expected, &mut packed.workspace());
    let mean = expected.iter().map(|e| e[1]).sum::<f32>() / receivers as f32;
    for (i, (found, wanted)) in frame.receivers.iter().zip(&expected).enumerate() {
        assert!((found[1] - wanted[1]).abs() <= 1e-5 * mean, "receiver {i}: {found:?}, the twin has {wanted:?}");
    }
    let alone = runtime.relight_receivers(&rig, &room.transfer).unwrap();
    assert_eq!(alone.indirect, frame.receivers);
    let dark = runtime
        .relight_receivers(&LightRig { lights: rig.lights[..1].to_vec(), ..LightRig::default() }, &room.transfer);
    let sky = alone.direct[0][2] - dark.unwrap().direct[0][2];
    assert!((sky - std::f32::consts::PI * 0.4 * 0.2).abs() < 1e-4, "the sky adds {sky}");
    let Weights::Gathered(gathered) = &mut room.transfer.weights else { panic!("they gather") };
    gathered.stream.truncate(40);
    assert!(GpuRuntime::new(&gpu, &room.bake(), &operator, &small()).is_err(), "a cut stream is refused");
}
