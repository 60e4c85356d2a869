//! How alike neighbours are in an order, without building the reordered matrix.

use radfile::{FormFactors, Operator, Permutation};
use rayon::prelude::*;

use crate::report::{NeighbourDifference, ZeroTiles};

/// Edge of the tiles that are looked at for zeros.
const TILE: usize = 16;
/// Seed of the random order; part of the yardstick's definition.
const RANDOM_ORDER: u64 = 2019;

/// Compares the present order, `new` and a random order.
pub fn compare(operator: &Operator, new: &Permutation) -> NeighbourDifference {
    let n = operator.n;
    NeighbourDifference {
        before: difference(operator, Permutation::identity(n).new_to_old()),
        after: difference(operator, new.new_to_old()),
        random: difference(operator, random_order(n).new_to_old()),
    }
}

/// Mean absolute difference of neighbours along rows and columns over the mean value.
fn difference(operator: &Operator, order: &[u32]) -> f64 {
    let n = operator.n;
    if n < 2 {
        return 0.0;
    }
    // For every new row: differences to the right, differences to the next row, values.
    let sums = |channel: &[f32], k: usize| {
        let row = &channel[order[k] as usize * n..][..n];
        let right = order.windows(2).map(|p| f64::from((row[p[0] as usize] - row[p[1] as usize]).abs())).sum::<f64>();
        let down = order.get(k + 1).map_or(0.0, |&next| {
            let next = &channel[next as usize * n..][..n];
            row.iter().zip(next).map(|(a, b)| f64::from((a - b).abs())).sum()
        });
        [right + down, row.iter().map(|v| f64::from(v.abs())).sum()]
    };
    let mut total = [0.0; 2];
    for channel in 0..operator.channels {
        let rows: Vec<[f64; 2]> = (0..n).into_par_iter().map(|k| sums(operator.channel(channel), k)).collect();
        rows.iter().for_each(|row| total = [total[0] + row[0], total[1] + row[1]]);
    }
    let pairs = (2 * n * (n - 1)) as f64;
    if total[1] > 0.0 { total[0] / pairs / (total[1] / (n * n) as f64) } else { 0.0 }
}

/// Share of 16 × 16 tiles of F that are exactly zero, in the present order and in `new`.
///
/// # Panics
///
/// If `new` is about another number of patches: a bug in the caller.
#[track_caller]
pub fn zero_tiles(factors: &FormFactors, new: &Permutation) -> ZeroTiles {
    assert_eq!(factors.len(), new.new_to_old().len(), "form factors and order of the same patches");
    let share = |order: &[u32]| {
        let strips: Vec<&[u32]> = order.chunks(TILE).collect();
        let dark = |rows: &[u32], columns: &[u32]| {
            rows.iter().all(|&i| {
                let row = factors.row(i as usize);
                columns.iter().all(|&j| row[j as usize] == 0.0)
            })
        };
        let zero: usize =
            strips.par_iter().map(|rows| strips.iter().filter(|columns| dark(rows, columns)).count()).sum();
        if strips.is_empty() { 0.0 } else { zero as f64 / (strips.len() * strips.len()) as f64 }
    };
    ZeroTiles { before: share(Permutation::identity(factors.len()).new_to_old()), after: share(new.new_to_old()) }
}

/// The paper's yardstick, an order without any sense; always the same. Fisher-Yates shuffle from a fixed seed.
pub fn random_order(n: usize) -> Permutation {
    let mut random = SplitMix(RANDOM_ORDER);
    let mut order: Vec<u32> = (0..n as u32).collect();
    for i in (1..n).rev() {
        let j = (random.next() * (i + 1) as f64) as usize;
        order.swap(i, j);
    }
    Permutation::new(order).expect("swaps keep a permutation")
}

/// Reproducible numbers. Source: G. L. Steele, D. Lea, C. H. Flood, Fast splittable pseudorandom number
/// generators, OOPSLA 2014.
pub struct SplitMix(pub u64);

impl SplitMix {
    /// The next number, 0 ≤ x < 1.
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }
}
