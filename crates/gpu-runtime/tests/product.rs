//! The packed product on the device against the exact decoding of the same operator.

mod common;

use common::{Numbers, Room, empty_operator, gpu, room, wall};
use gpu_runtime::{Decode, Gpu, GpuRuntime, Params};
use radfile::{BlockFormat, Colour, NO_COMPONENT, PackedOperator, ValueMap, half_blocks};

const LOG: ValueMap = ValueMap::Log { shift: 9.0 };

/// A strip of patches of unequal area and colour.
fn strip(n: u32) -> Room {
    let mut room = room(&[wall([0.0; 3], [n as f32, 0.0, 0.0], [0.0, 1.0, 0.0], [n, 1])]);
    let mut numbers = Numbers(5);
    for i in 0..n as usize {
        room.patches.area[i] = 0.1 + numbers.unit();
        room.patches.reflectance[i] = std::array::from_fn(|_| 0.9 * numbers.unit());
    }
    room
}

fn runtime(gpu: &Gpu, room: &Room, packed: &PackedOperator, decode: Decode) -> GpuRuntime {
    let params = Params { decode, patch_samples: 1, shadow_resolution: 4, ..Params::default() };
    GpuRuntime::new(gpu, &room.bake(), packed, &params).expect("it fits")
}

/// Direct light that varies from patch to patch.
fn light(n: u32) -> Vec<[f32; 3]> {
    let mut numbers = Numbers(11);
    (0..n).map(|_| std::array::from_fn(|_| numbers.unit())).collect()
}

/// H = A^{-1/2} M A^{1/2} ρ H⁰ in double precision; `matrix(channel)` gives M.
fn exact(room: &Room, h0: &[[f32; 3]], matrix: impl Fn(usize) -> Vec<f32>) -> Vec<[f32; 3]> {
    let (n, p) = (h0.len(), &room.patches);
    let mut h = vec![[0.0; 3]; n];
    for channel in 0..3 {
        let m = matrix(channel);
        let send = |j: usize| f64::from(p.area[j]).sqrt() * f64::from(p.reflectance[j][channel] * h0[j][channel]);
        let x: Vec<f64> = (0..n).map(send).collect();
        for i in 0..n {
            let y: f64 = m[i * n..][..n].iter().zip(&x).map(|(&k, x)| f64::from(k) * x).sum();
            h[i][channel] = (y / f64::from(p.area[i]).sqrt()) as f32;
        }
    }
    h
}

/// Random blocks; BC1 only in the mode with four colours. Every row has outliers, some of them negative.
fn random_operator(n: u32, channels: u32, format: BlockFormat, map: ValueMap) -> PackedOperator<'static> {
    let mut packed = empty_operator(n, channels, format, map);
    let mut numbers = Numbers(u64::from(n) + 7);
    for block in packed.blocks.to_mut().as_chunks_mut::<8>().0 {
        *block = numbers.bits().to_le_bytes();
        let ends = [u16::from_le_bytes([block[0], block[1]]), u16::from_le_bytes([block[2], block[3]])];
        if format == BlockFormat::Bc1 && ends[0] <= ends[1] {
            let ends = if ends[0] == ends[1] { [1, 0] } else { [ends[1], ends[0]] };
            block[..4].copy_from_slice(bytes(ends).as_slice());
        }
    }
    let (mut start, mut column, mut value) = (vec![0], vec![], vec![]);
    for row in 0..n {
        for k in 0..row % 5 {
            column.push((row * 7 % (n / 5)) + k * (n / 5));
            value.extend((0..channels).map(|_| 3.0 * numbers.unit() - 1.0));
        }
        start.push(column.len() as u32);
    }
    (packed.outlier_start, packed.outlier_column, packed.outlier_value) = (start.into(), column.into(), value.into());
    packed
}

/// Half of random blocks, and colour in two components beside patches without.
fn half_operator(n: u32, map: ValueMap) -> PackedOperator<'static> {
    let mut packed = random_operator(n, 3, BlockFormat::Bc4, map);
    let mut numbers = Numbers(u64::from(n) + 9);
    packed.packing.scale = [0.9; 3];
    packed.blocks = (0..half_blocks(n)).flat_map(|_| numbers.bits().to_le_bytes()).collect();
    let (mut start, mut column) = (vec![0], vec![]);
    for row in 0..n {
        column.extend((0..=row).filter(|j| (row + j) % 31 == 0));
        start.push(column.len() as u32);
    }
    packed.outlier_value = column.iter().map(|_| numbers.unit() - 0.3).collect();
    (packed.outlier_start, packed.outlier_column) = (start.into(), column.into());
    let component: Vec<u16> = (0..n).map(|i| [0, 0, 1, NO_COMPONENT][i as usize % 4]).collect();
    let count = |k: u16| component.iter().filter(|c| **c == k).count();
    let codes = 21 * count(0) + 2 * count(1);
    packed.half = Some(Colour {
        axes: vec![[0.7, -0.3, 0.1], [-0.1, 0.0, 0.9]],
        rank: vec![21, 2],
        scale: (0..n).map(|_| numbers.unit()).collect(),
        codes: (0..codes).map(|_| numbers.bits() as u8).collect(),
        core: (0..2 * (21 * 22 / 2 + 3)).map(|_| 0.5 * (numbers.unit() - 0.5)).collect(),
        component: component.into(),
    });
    packed
}

/// More blocks than a row of the texture holds, at 405 patches, and fewer.
#[test]
fn half_an_operator_and_its_colour_give_the_exact_product() {
    let Some(gpu) = gpu() else { return };
    for (n, map) in [(61, LOG), (405, ValueMap::Sqrt), (405, LOG)] {
        let (room, h0, packed) = (strip(n), light(n), half_operator(n, map));
        let truth = exact(&room, &h0, |c| packed.decode(c));
        let mut grey = packed.clone();
        grey.half = Some(Colour::default());
        let without = exact(&room, &h0, |c| grey.decode(c));
        assert!(common::off(&without, &truth) > 0.05, "the colour is to be seen");
        let found = runtime(&gpu, &room, &packed, Decode::Stored).patch_indirect(&h0).unwrap();
        let off = common::off(&found, &truth);
        assert!(off < 1e-5, "{n} {map:?}: {off:e}");
        let found = runtime(&gpu, &room, &grey, Decode::Stored).patch_indirect(&h0).unwrap();
        let off = common::off(&found, &without);
        assert!(off < 1e-5, "{n} {map:?} without colour: {off:e}");
    }
}

/// Blocks of ends only, as of the whole operator: then the sampler has nothing to round.
#[test]
fn the_sampler_finds_every_block_of_half_an_operator() {
    let Some(gpu) = gpu() else { return };
    for n in [61, 405] {
        let (room, h0, mut packed) = (strip(n), light(n), half_operator(n, ValueMap::Sqrt));
        for block in packed.blocks.to_mut().as_chunks_mut::<8>().0 {
            let bits = u64::from_le_bytes(*block);
            *block = (bits & 0o1111_1111_1111_1111 << 16 | bits & 0xffff).to_le_bytes();
        }
        let found = runtime(&gpu, &room, &packed, Decode::Sampled).patch_indirect(&h0).unwrap();
        let off = common::off(&found, &exact(&room, &h0, |c| packed.decode(c)));
        assert!(off < 2e-5, "{n}: {off:e}");
    }
}

fn bytes([a, b]: [u16; 2]) -> [u8; 4] {
    let ([a, b], [c, d]) = (a.to_le_bytes(), b.to_le_bytes());
    [a, b, c, d]
}

const KINDS: [(u32, BlockFormat, ValueMap); 6] = [
    (1, BlockFormat::Bc4, LOG),
    (3, BlockFormat::Bc4, LOG),
    (1, BlockFormat::Bc4, ValueMap::Sqrt),
    (3, BlockFormat::Bc4, ValueMap::Sqrt),
    (3, BlockFormat::Bc1, LOG),
    (3, BlockFormat::Bc1, ValueMap::Sqrt),
];

/// Sums of n positive terms in single precision, decoded by formulas that are good to a few units in the last
/// place: 1e-5 is a hundred such units.
#[test]
fn blocks_decoded_by_the_kernel_give_the_exact_product() {
    let Some(gpu) = gpu() else { return };
    let (n, h0) = (203, light(203));
    let room = strip(n);
    for (channels, format, map) in KINDS {
        let packed = random_operator(n, channels, format, map);
        let found = runtime(&gpu, &room, &packed, Decode::Stored).patch_indirect(&h0).unwrap();
        let off = common::off(&found, &exact(&room, &h0, |c| packed.decode(c)));
        assert!(off < 1e-5, "{channels} {format:?} {map:?}: {off:e}");
    }
}

/// A sampler may be off by 2/255 in every texel, but no further: each row must lie within what that makes.
#[test]
fn blocks_decoded_by_the_sampler_stay_within_its_rounding() {
    let Some(gpu) = gpu() else { return };
    let (n, h0) = (203, light(203));
    let room = strip(n);
    for (channels, format, map) in KINDS {
        let packed = random_operator(n, channels, format, map);
        let found = runtime(&gpu, &room, &packed, Decode::Sampled).patch_indirect(&h0).unwrap();
        let truth = exact(&room, &h0, |c| packed.decode(c));
        let slack = exact(&room, &h0, |c| rounding(&packed, c));
        for (i, ((f, t), s)) in found.iter().zip(&truth).zip(&slack).enumerate() {
            for c in 0..3 {
                let (off, slack) = ((f[c] - t[c]).abs(), s[c] + 1e-5 * t[c].abs());
                assert!(off <= slack, "{channels} {format:?} {map:?} row {i} channel {c}: {off} > {slack}");
            }
        }
        println!("{channels} {format:?} {map:?}: mean {:+.2e}", common::difference(&found, &truth).0);
    }
}

/// What 2/255 of code change in every texel.
fn rounding(packed: &PackedOperator, channel: usize) -> Vec<f32> {
    let (p, n) = (&packed.packing, packed.packing.n as usize);
    let scale = p.scale[if p.channels == 1 { 0 } else { channel }];
    let off = |k: usize| {
        let value = packed.texel(channel, k / n, k % n);
        let u = p.map.encode(value, scale);
        let at = |u: f32| p.map.decode(u.clamp(0.0, 1.0), scale);
        (at(u + 2.0 / 255.0) - value).max(value - at(u - 2.0 / 255.0))
    };
    (0..n * n).map(off).collect()
}

/// Where every texel is one of the two ends of its block nothing is mixed, and BC4 has no rounding left.
#[test]
fn blocks_of_ends_only_are_exact_through_the_sampler() {
    let Some(gpu) = gpu() else { return };
    let (n, h0) = (96, light(96));
    let room = strip(n);
    for map in [LOG, ValueMap::Sqrt] {
        let mut packed = random_operator(n, 3, BlockFormat::Bc4, map);
        for block in packed.blocks.to_mut().as_chunks_mut::<8>().0 {
            // Keep the lowest bit of every 3-bit index.
            let bits = u64::from_le_bytes(*block);
            *block = (bits & 0o1111_1111_1111_1111 << 16 | bits & 0xffff).to_le_bytes();
        }
        let found = runtime(&gpu, &room, &packed, Decode::Sampled).patch_indirect(&h0).unwrap();
        let off = common::off(&found, &exact(&room, &h0, |c| packed.decode(c)));
        assert!(off < 1e-5, "{map:?}: {off:e}");
    }
}

#[test]
fn an_operator_of_several_tiles_multiplies_like_one() {
    let Some(gpu) = gpu() else { return };
    let n = 4100;
    let (room, h0, packed) = (strip(n), light(n), random_operator(n, 1, BlockFormat::Bc4, ValueMap::Sqrt));
    assert_eq!(packed.packing.tiles, 2);
    let truth = exact(&room, &h0, |c| packed.decode(c));
    for (decode, tolerance) in [(Decode::Stored, 1e-5), (Decode::Sampled, 0.01)] {
        let found = runtime(&gpu, &room, &packed, decode).patch_indirect(&h0).unwrap();
        let off = common::off(&found, &truth);
        assert!(off < tolerance, "{decode:?}: {off:e}");
    }
}

/// Texel values of a smooth operator in BC4: largest and smallest code as ends, nearest mixtures between.
fn smooth_operator(n: u32, map: ValueMap) -> PackedOperator<'static> {
    let mut packed = empty_operator(n, 1, BlockFormat::Bc4, map);
    let value = |i: u32, j: u32| {
        let d = (i as f32 - j as f32) / n as f32;
        0.9 * (0.001 + (-40.0 * d * d).exp() * (1.0 + 0.3 * (i as f32 * 0.7).sin() * (j as f32 * 0.7).sin()) / 1.3)
    };
    for block in 0..(n / 4) * (n / 4) {
        let (row, column) = (4 * (block / (n / 4)), 4 * (block % (n / 4)));
        let codes: [f32; 16] =
            std::array::from_fn(|t| 255.0 * map.encode(value(row + t as u32 / 4, column + t as u32 % 4), 0.9));
        let high = codes.iter().fold(0.0f32, |m, &c| m.max(c)).ceil() as u8;
        let low = codes.iter().fold(255.0f32, |m, &c| m.min(c)).floor() as u8;
        let mut bits = u64::from(high) | u64::from(low) << 8;
        for (t, code) in codes.into_iter().enumerate() {
            let step = (7.0 * (f32::from(high) - code) / f32::from(high.abs_diff(low).max(1))).round() as u64;
            let index = [0, 2, 3, 4, 5, 6, 7, 1][step.min(7) as usize];
            bits |= index << (16 + 3 * t);
        }
        let at = packed.packing.block_offset(0, row as usize, column as usize);
        packed.blocks.to_mut()[at..at + 8].copy_from_slice(&bits.to_le_bytes());
    }
    packed
}

/// Both backends answer from the same packed operator, so whatever the device decides they may not differ by more
/// than half a percent; the twin decodes on the CPU.
#[test]
fn whoever_decodes_the_light_is_that_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let n = 512;
    let (room, h0) = (strip(n), light(n));
    for map in [ValueMap::Sqrt, LOG, ValueMap::Log { shift: 14.0 }] {
        let packed = smooth_operator(n, map);
        let twin = relight::indirect(&room.patches, &packed.clone().into(), &h0);
        let chosen = runtime(&gpu, &room, &packed, Decode::Auto);
        let sampled = runtime(&gpu, &room, &packed, Decode::Sampled);
        let off = |r: &GpuRuntime| common::difference(&r.patch_indirect(&h0).unwrap(), &twin);
        let ((mean, rms), (sampled_mean, sampled_rms)) = (off(&chosen), off(&sampled));
        println!(
            "{map:?}: {:?}, probe {:+.2e}; mean {mean:+.2e} rms {rms:.2e}; by the sampler {sampled_mean:+.2e} {sampled_rms:.2e}",
            chosen.report().decode,
            chosen.report().sampler_bias.unwrap_or(0.0)
        );
        assert!(mean.abs() < 0.005 && rms < 0.005, "{map:?}: mean {mean}, rms {rms}");
        let probed = chosen.report().sampler_bias.expect("Auto probes where there is the feature");
        assert!((probed - sampled_mean).abs() < 0.002, "the probe says {probed}, the product {sampled_mean}");
    }
}
