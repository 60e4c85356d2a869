//! Exact quantiles of many numbers without sorting or copying them.
//!
//! The bits of non-negative floats are ordered as the floats are, so two histograms, of the upper
//! and then of the lower 16 bits, find any rank in two passes.

use rayon::prelude::*;

const BINS: usize = 1 << 16;
const CHUNK: usize = 1 << 20;

/// The smallest of the numbers (or 0) that at most `share` of them exceed.
///
/// All of `values` must be finite and ≥ 0.
pub fn threshold(values: &[f32], share: f64) -> f32 {
    let above = (share * values.len() as f64) as u64;
    if above >= values.len() as u64 {
        return 0.0;
    }
    let upper = histogram(values, |bits| Some(bits >> 16));
    let (high, rest) = bin_at(&upper, above);
    let lower = histogram(values, |bits| (bits >> 16 == high).then_some(bits & 0xffff));
    let (low, _) = bin_at(&lower, rest);
    f32::from_bits(high << 16 | low)
}

/// Counts of `bin(bits)`. Integer sums do not depend on the order of the threads.
fn histogram(values: &[f32], bin: impl Fn(u32) -> Option<u32> + Sync) -> Vec<u64> {
    let count = |chunk: &[f32]| {
        let mut bins = vec![0u64; BINS];
        for bin in chunk.iter().filter_map(|v| bin((v + 0.0).to_bits())) {
            bins[bin as usize] += 1;
        }
        bins
    };
    let add = |mut a: Vec<u64>, b: Vec<u64>| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        a
    };
    values.par_chunks(CHUNK).map(count).reduce(|| vec![0; BINS], add)
}

/// The bin that holds the number with `above` larger ones, and how many of those lie in the bin.
fn bin_at(bins: &[u64], above: u64) -> (u32, u64) {
    let mut rest = above;
    for (bin, &count) in bins.iter().enumerate().rev() {
        if rest < count {
            return (bin as u32, rest);
        }
        rest -= count;
    }
    (0, 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_is_the_one_that_sorting_finds() {
        let values: Vec<f32> = (0..5000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 20) as f32 * 1e-4).collect();
        let mut sorted = values.clone();
        sorted.sort_by(|a, b| b.total_cmp(a));
        for share in [0.0, 0.0001, 0.01, 0.3333, 0.5, 0.999] {
            let found = threshold(&values, share);
            assert_eq!(found, sorted[(share * 5000.0) as usize], "share {share}");
            let above = values.iter().filter(|&&v| v > found).count();
            assert!(above as f64 <= share * 5000.0, "{above} numbers above the threshold of share {share}");
        }
        assert_eq!(threshold(&values, 1.0), 0.0);
    }

    #[test]
    fn minus_zero_counts_as_zero() {
        assert_eq!(threshold(&[-0.0, 0.0, -0.0, 1.0], 0.25), 0.0);
    }
}
