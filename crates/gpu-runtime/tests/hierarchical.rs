//! The product with hierarchical blocks on the device: against the CPU's, against the decoded operator, in frames.

mod common;

use common::{Numbers, Room, cornell, diagonal_operator, gpu, off, room, wall};
use gpu_runtime::{Clock, Gpu, GpuRuntime, Params};
use hmatrix::{HMatrix, compress};
use radfile::{Operator, Patches, Quiet};
use scene::{Light, LightRig};

/// A symmetric operator that falls with distance and is rough where patches are near, of other colours elsewhere.
fn operator(patches: &Patches, channels: usize) -> Operator<'static> {
    let n = patches.len();
    let mut numbers = Numbers(17);
    let rough: Vec<f32> = (0..n).map(|_| numbers.unit()).collect();
    let value = |at: usize| {
        let (c, i, j) = (at / (n * n), at / n % n, at % n);
        let [p, q] = [i, j].map(|k| patches.position[k]);
        let square: f32 = (0..3).map(|a| (p[a] - q[a]).powi(2)).sum();
        let colour = 1.0 + patches.reflectance[i][c] + patches.reflectance[j][c];
        let near = (rough[i] + rough[j]) * (-8.0 * square).exp();
        (patches.area[i] * patches.area[j]).sqrt() * (colour / (20.0 + square) + near)
    };
    Operator { n, channels, bounces: None, values: (0..channels * n * n).map(value).collect() }
}

fn packed(patches: &Patches, channels: usize, error: f64, leaf: usize) -> HMatrix {
    let params = hmatrix::Params { leaf, ..hmatrix::Params::error(error) };
    compress(&operator(patches, channels), patches, &params, &Quiet).expect("it is symmetric and positive").0
}

fn runtime(gpu: &Gpu, room: &Room, matrix: &HMatrix) -> GpuRuntime {
    let params = Params { patch_samples: 2, shadow_resolution: 64, ..Params::default() };
    GpuRuntime::new(gpu, &room.bake(), matrix, &params).expect("it fits")
}

/// Direct light that varies from patch to patch.
fn light(n: usize) -> Vec<[f32; 3]> {
    let mut numbers = Numbers(11);
    (0..n).map(|_| std::array::from_fn(|_| numbers.unit())).collect()
}

/// H = A^{-1/2} y for y = K A^{1/2} ρ H⁰.
fn irradiance(patches: &Patches, h0: &[[f32; 3]], multiply: impl Fn(&[[f32; 3]]) -> Vec<[f32; 3]>) -> Vec<[f32; 3]> {
    let root: Vec<f32> = patches.area.iter().map(|a| a.sqrt()).collect();
    let x: Vec<[f32; 3]> =
        (0..h0.len()).map(|i| std::array::from_fn(|c| root[i] * patches.reflectance[i][c] * h0[i][c])).collect();
    multiply(&x).iter().zip(root).map(|(y, root)| y.map(|y| y / root)).collect()
}

fn on_the_cpu(matrix: &HMatrix, x: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut y = vec![[0.0; 3]; x.len()];
    matrix.multiply(x, &mut y, &mut matrix.workspace());
    y
}

/// By the definition, in double precision.
fn decoded(matrix: &HMatrix, x: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let n = x.len();
    let dense: Vec<Vec<f64>> = (0..matrix.channels()).map(|c| matrix.decode(c).expect("own bytes")).collect();
    let entry = |c: usize, at: usize| dense[c.min(dense.len() - 1)][at];
    let dot = |i: usize, c: usize| (0..n).map(|j| entry(c, i * n + j) * f64::from(x[j][c])).sum::<f64>() as f32;
    (0..n).map(|i| std::array::from_fn(|c| dot(i, c))).collect()
}

/// Sums of a few hundred terms in single precision: 1e-5 is a hundred units in the last place.
#[test]
fn the_product_is_that_of_the_cpu_and_of_the_decoded_operator() {
    let Some(gpu) = gpu() else { return };
    for (cells, channels, error, leaf) in
        [(4, 3, 0.01, 24), (9, 1, 0.001, 60), (9, 3, 0.001, 7), (13, 3, 0.01, 24), (15, 1, 0.003, 33)]
    {
        let room = cornell(cells);
        let matrix = packed(&room.patches, channels, error, leaf);
        let layout = matrix.layout();
        let tiles = layout.leaves.iter().filter(|leaf| !leaf.near.senders.is_empty()).count();
        let apart: usize = layout.leaves.iter().map(|leaf| leaf.near.apart.len()).sum();
        let h0 = light(room.patches.len());
        let runtime = runtime(&gpu, &room, &matrix);
        let found = runtime.patch_indirect(&h0).unwrap();
        let cpu = off(&found, &irradiance(&room.patches, &h0, |x| on_the_cpu(&matrix, x)));
        let exact = off(&found, &irradiance(&room.patches, &h0, |x| decoded(&matrix, x)));
        println!(
            "{} patches, {channels} channels, {error}: {} levels, tiles in {tiles} of {} leaves, {apart} entries apart, \
             {} means; off by {cpu:.1e} from the CPU, {exact:.1e} from the decoded operator; {} bytes packed, {} here",
            matrix.patches(),
            layout.leaves[0].above.len(),
            layout.leaves.len(),
            layout.means.len(),
            matrix.to_bytes().len(),
            runtime.report().operator_bytes,
        );
        assert!(cpu < 1e-5 && exact < 1e-5, "{cpu:e} from the CPU, {exact:e} from the decoded operator");
        assert_eq!(found, runtime.patch_indirect(&h0).unwrap(), "the same bits again");
        assert!(runtime.report().operator_bytes > matrix.to_bytes().len());
    }
}

/// All kinds of blocks have been multiplied with above, or the test has seen little.
#[test]
fn the_operators_of_these_tests_have_blocks_of_all_kinds() {
    let room = cornell(13);
    let matrix = packed(&room.patches, 3, 0.01, 24);
    let layout = matrix.layout();
    let lengths: Vec<usize> = layout.leaves.iter().map(|leaf| leaf.rows.len()).collect();
    assert!(lengths.first() > lengths.last(), "leaves of unequal size: {lengths:?}");
    assert!(layout.leaves[0].above.len() >= 3, "levels");
    assert!(layout.panels.iter().any(|p| p.len > 200) && layout.panels.iter().any(|p| p.len < 30), "clusters");
    assert!(!layout.means.is_empty(), "means");
    assert!(layout.leaves.iter().any(|leaf| leaf.near.senders.len() > 16), "tiles");
    assert!(layout.leaves.iter().any(|leaf| !leaf.near.apart.is_empty()), "entries that stand apart");
    let coloured = |lanes: &hmatrix::Lanes| (0..hmatrix::LANES).any(|k| lanes[0][k] != lanes[1][k]);
    assert!(layout.factor.iter().any(coloured), "planes of colour");
}

#[test]
fn few_patches_are_multiplied_as_well() {
    let Some(gpu) = gpu() else { return };
    for n in [1, 2, 7, 8, 9, 25, 49] {
        let room = room(&[wall([0.0; 3], [n as f32, 0.0, 0.0], [0.0, 1.0, 0.0], [n, 1])]);
        for channels in [1, 3] {
            let matrix = packed(&room.patches, channels, 0.01, 4);
            let h0 = light(n as usize);
            let found = runtime(&gpu, &room, &matrix).patch_indirect(&h0).unwrap();
            let truth = irradiance(&room.patches, &h0, |x| decoded(&matrix, x));
            assert!(off(&found, &truth) < 1e-5, "{n} patches: {found:?}, decoded {truth:?}");
        }
    }
}

/// The same rig twice: what the frame before left in the buffers does not count, and no new ones are made.
#[test]
fn frames_bring_the_light_that_the_cpu_computes_from_their_direct_light() {
    let Some(gpu) = gpu() else { return };
    let room = cornell(6);
    let matrix = packed(&room.patches, 3, 0.01, 24);
    let runtime = &runtime(&gpu, &room, &matrix);
    let rig = |intensity: f32| {
        let lights = vec![
            Light::Point { position: [2.7, 2.8, 4.5], intensity: [5.0 * intensity, 4.0, 3.0] },
            Light::Sky { radiance: [0.2, 0.3 * intensity, 0.4] },
        ];
        LightRig { lights, ..LightRig::default() }
    };
    let first = runtime.relight(&rig(1.0)).unwrap();
    let other = runtime.relight(&rig(30.0)).unwrap();
    for frame in [&first, &other] {
        let expected = irradiance(&room.patches, &frame.direct, |x| on_the_cpu(&matrix, x));
        assert!(off(&frame.indirect, &expected) < 1e-5);
        assert_eq!(frame.receivers, runtime.gather(&room.rows, &frame.indirect).unwrap());
    }
    assert!(other.indirect[0][0] > 10.0 * first.indirect[0][0]);
    assert_eq!(runtime.relight(&rig(1.0)).unwrap(), first, "the same frame again");
    let both = std::thread::scope(|scope| {
        let threads = [1.0, 30.0].map(|intensity| scope.spawn(move || runtime.relight(&rig(intensity)).unwrap()));
        threads.map(|thread| thread.join().expect("a frame"))
    });
    assert_eq!(both, [first.clone(), other], "two threads wait for each other");
    let before = gpu.buffers_made();
    assert_eq!(runtime.relight(&rig(1.0)).unwrap(), first);
    runtime.patch_indirect(&first.direct).unwrap();
    assert_eq!(gpu.buffers_made(), before, "a later frame makes no buffers");
}

#[test]
fn an_operator_of_another_bake_is_refused() {
    let Some(gpu) = gpu() else { return };
    let [room, other] = [cornell(4), cornell(3)];
    let matrix = packed(&other.patches, 1, 0.1, 24);
    let params = Params { patch_samples: 1, shadow_resolution: 4, ..Params::default() };
    let made = GpuRuntime::new(&gpu, &room.bake(), &matrix, &params);
    let text = made.err().expect("refused").to_string();
    assert!(text.starts_with("the packed operator is of ") && text.contains("one bake"), "{text}");
}

/// Times are no tests; that they are of what they say can be tested.
#[test]
fn a_product_is_timed_without_changing_it() {
    let Some(gpu) = gpu() else { return };
    let room = cornell(6);
    let matrix = packed(&room.patches, 3, 0.01, 24);
    let runtime = runtime(&gpu, &room, &matrix);
    let h0 = light(room.patches.len());
    let before = runtime.patch_indirect(&h0).unwrap();
    let timing = runtime.time_product(&h0, 20).unwrap();
    println!("{timing:?}, the device copies {:.1} GB/s", gpu.copy_bandwidth().unwrap());
    assert!(timing.milliseconds > 0.0 && timing.milliseconds < 1e3);
    assert!(timing.bytes_read > runtime.report().operator_bytes, "codes are read twice");
    assert!(matches!(timing.by, Clock::Timestamps | Clock::WallClock));
    assert_eq!(runtime.patch_indirect(&h0).unwrap(), before);
    let textures = diagonal_operator(room.patches.len() as u32, 0.5);
    let params = Params { patch_samples: 1, shadow_resolution: 4, ..Params::default() };
    let by_textures = GpuRuntime::new(&gpu, &room.bake(), &textures, &params).unwrap();
    let timing = by_textures.time_product(&h0, 3).unwrap();
    assert_eq!(timing.bytes_read, by_textures.report().operator_bytes, "blocks are read once");
    let text = runtime.time_product(&h0, 0).unwrap_err().to_string();
    assert!(text.contains("0 repetitions"), "{text}");
}
