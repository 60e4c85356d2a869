//! The product with textures against the decoded matrix in double precision.

use radfile::{BlockFormat, Colour, NO_COMPONENT, PackedOperator, Packing, ValueMap, half_blocks};
use relight::TextureProduct;

/// SplitMix64.
struct Numbers(u64);

impl Numbers {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u64 << 24) as f32
    }
}

fn packing(n: u32, channels: u32, format: BlockFormat, map: ValueMap) -> Packing {
    let (tile, tiles) = Packing::tiling(n);
    Packing { n, channels, bounces: None, format, map, scale: [0.5; 3], tile, tiles }
}

/// Every mode of every block comes up; a few outliers in each row, some negative.
fn whole(n: u32, channels: u32, format: BlockFormat, map: ValueMap) -> PackedOperator<'static> {
    let mut numbers = Numbers(u64::from(n));
    let packing = packing(n, channels, format, map);
    let words = packing.tile_count() * packing.tile_bytes() / 8;
    let column = (0..n).flat_map(|i| [i % (n / 2), n / 2 + i % (n / 2)]);
    PackedOperator {
        blocks: (0..words).flat_map(|_| numbers.bits().to_le_bytes()).collect(),
        outlier_start: (0..=n).map(|i| 2 * i).collect(),
        outlier_column: column.collect(),
        outlier_value: (0..2 * n * channels).map(|_| numbers.unit() - 0.3).collect(),
        half: None,
        packing,
    }
}

/// Half of it: two components of colour, of which one has more columns than a vector, and patches without.
fn half(n: u32, grey: bool, map: ValueMap) -> PackedOperator<'static> {
    let mut numbers = Numbers(u64::from(n));
    let component: Vec<u16> = (0..n).map(|i| [0, 0, 1, NO_COMPONENT][i as usize % 4]).collect();
    let count = |k: u16| component.iter().filter(|c| **c == k).count();
    // A component has no more columns than members.
    let rank = [19.min(count(0)), 3.min(count(1))];
    let codes = rank[0] * count(0) + rank[1] * count(1);
    let pairs: usize = rank.iter().map(|r| r * (r + 1) / 2).sum();
    let colour = Colour {
        axes: vec![[0.7, -0.3, 0.1], [-0.1, 0.0, 0.9]],
        rank: rank.map(|r| r as u32).to_vec(),
        scale: (0..n).map(|_| numbers.unit()).collect(),
        codes: (0..codes).map(|_| numbers.bits() as u8).collect(),
        core: (0..2 * pairs).map(|_| 0.5 * (numbers.unit() - 0.5)).collect(),
        component: component.into(),
    };
    let mut start = vec![0];
    let mut column = Vec::new();
    for row in 0..n {
        column.extend((0..=row).filter(|j| (row + j) % 37 == 0 || *j == row && row % 3 == 0));
        start.push(column.len() as u32);
    }
    PackedOperator {
        packing: packing(n, if grey { 1 } else { 3 }, BlockFormat::Bc4, map),
        blocks: (0..half_blocks(n)).flat_map(|_| numbers.bits().to_le_bytes()).collect(),
        outlier_start: start.into(),
        outlier_value: column.iter().map(|_| numbers.unit() - 0.3).collect(),
        outlier_column: column.into(),
        half: Some(if grey { Colour::default() } else { colour }),
    }
}

fn every_form(n: u32) -> Vec<PackedOperator<'static>> {
    let log = ValueMap::Log { shift: 6.0 };
    vec![
        whole(n, 3, BlockFormat::Bc1, log),
        whole(n, 1, BlockFormat::Bc1, ValueMap::Sqrt),
        whole(n, 3, BlockFormat::Bc4, ValueMap::Sqrt),
        whole(n, 1, BlockFormat::Bc4, log),
        half(n, false, ValueMap::Sqrt),
        half(n, false, log),
        half(n, true, ValueMap::Sqrt),
    ]
}

fn light(n: u32) -> Vec<[f32; 3]> {
    let mut numbers = Numbers(3);
    (0..n).map(|_| std::array::from_fn(|_| numbers.unit())).collect()
}

fn product(packed: &PackedOperator<'static>, x: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let product = TextureProduct::new(packed.clone());
    let (mut workspace, mut y) = (product.workspace(), vec![[f32::NAN; 3]; x.len()]);
    // Twice: nothing of a frame may stay in the workspace.
    product.multiply(&vec![[1e6; 3]; x.len()], &mut y, &mut workspace);
    product.multiply(x, &mut y, &mut workspace);
    y
}

#[test]
fn the_product_is_that_of_the_decoded_matrix() {
    // Sizes that end inside lanes, blocks and parts.
    for n in [4, 6, 61, 333] {
        let x = light(n);
        for packed in every_form(n) {
            let found = product(&packed, &x);
            for c in 0..3 {
                let matrix = packed.decode(c);
                let exact: Vec<f64> = matrix
                    .chunks_exact(n as usize)
                    .map(|row| row.iter().zip(&x).map(|(&k, x)| f64::from(k) * f64::from(x[c])).sum())
                    .collect();
                let mean = exact.iter().map(|v| v.abs()).sum::<f64>() / f64::from(n);
                for (i, (found, exact)) in found.iter().zip(&exact).enumerate() {
                    let off = (f64::from(found[c]) - exact).abs();
                    assert!(off < 1e-5 * mean, "{:?} row {i} channel {c}: {off:e} of {mean}", packed.packing);
                }
            }
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let x = light(333);
    for packed in every_form(333) {
        let [one, five] = [1, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| product(&packed, &x))
        });
        assert_eq!(one, five);
    }
}
