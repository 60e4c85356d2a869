//! Sampling until it is enough.
//!
//! Paths are taken in batches. Within a batch they share a scrambled low-discrepancy sequence;
//! batches are independent of each other, so the spread of their means is an honest standard error.

use radfile::Progress;
use rayon::prelude::*;

use crate::statistics::Tally;

/// Share of the mean over all points (or pixels) below which a value need not be known any better.
pub const FLOOR: f64 = 0.05;
/// Batches before a standard error is trusted.
const FIRST: u32 = 32;
/// Most batches at once: their estimates are held until they are added in order.
const MOST: u32 = 64 * FIRST;

/// When an estimate is good enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// This many paths for each point or pixel; at least 2, rounded up to whole batches.
    Samples(u32),
    /// A point or pixel is done as soon as the standard error of its luminance is at most
    /// `error` · max(its luminance, [`FLOOR`] · mean luminance of all). For points this holds for direct and for
    /// indirect light, each by its own mean. It is looked at after 32 batches and after each further half.
    RelativeError {
        /// Standard error over value, such as 0.01.
        error: f64,
        /// Paths after which a point or pixel is given up, rounded up to whole batches.
        max_samples: u32,
    },
}

impl Stop {
    /// Paths in a batch: at most `largest`, a power of two, and few enough for an honest standard error.
    pub fn batch(&self, largest: u32) -> u32 {
        let samples = match *self {
            Stop::Samples(samples) => samples,
            Stop::RelativeError { max_samples, .. } => max_samples,
        };
        let size = (samples / FIRST).clamp(1, largest);
        1 << size.ilog2()
    }
}

/// Estimates `N` channels of each of `targets` things, until `stop`.
///
/// `estimate(target, batch)` is the mean over one batch of `size` paths. `judged` are the channels that the
/// relative error is asked of. Returns the tallies and how many things did not reach the error.
pub fn converge<const N: usize>(
    targets: usize,
    size: u32,
    stop: Stop,
    judged: &[usize],
    progress: &dyn Progress,
    estimate: impl Fn(usize, u32) -> [f64; N] + Sync,
) -> (Vec<Tally<N>>, usize) {
    let (mut done, last) = (0, batches(stop, size));
    let mut round = match stop {
        Stop::Samples(_) => MOST.min(last),
        Stop::RelativeError { .. } => FIRST.min(last),
    };
    let mut tallies = vec![Tally::default(); targets];
    let mut active: Vec<usize> = (0..targets).collect();
    while round > 0 && !active.is_empty() {
        progress.begin("light paths", active.len() as u64);
        let next: Vec<Tally<N>> = active
            .par_iter()
            .map(|&target| {
                let estimates: Vec<[f64; N]> =
                    (done..done + round).into_par_iter().map(|batch| estimate(target, batch)).collect();
                let mut tally = tallies[target];
                estimates.iter().for_each(|e| tally.add(e));
                progress.advance(1);
                tally
            })
            .collect();
        for (&target, tally) in active.iter().zip(next) {
            tallies[target] = tally;
        }
        done += round;
        round = (done / 2).clamp(1, MOST).min(last - done);
        match stop {
            Stop::Samples(_) if done < last => {}
            Stop::Samples(_) => active.clear(),
            Stop::RelativeError { error, .. } => {
                let least: Vec<f64> = judged.iter().map(|&c| FLOOR * average(&tallies, c)).collect();
                let good = |t: &Tally<N>| {
                    judged.iter().zip(&least).all(|(&c, &least)| t.error(c) <= error * t.mean(c).max(least))
                };
                active.retain(|&target| !good(&tallies[target]));
            }
        }
    }
    (tallies, active.len())
}

fn batches(stop: Stop, size: u32) -> u32 {
    match stop {
        Stop::Samples(samples) => samples.max(2).div_ceil(size),
        Stop::RelativeError { max_samples, .. } => max_samples.max(2).div_ceil(size),
    }
}

/// Mean of a channel over everything.
pub fn average<const N: usize>(tallies: &[Tally<N>], channel: usize) -> f64 {
    tallies.iter().fold(0.0, |sum, t| sum + t.mean(channel)) / tallies.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use radfile::Quiet;

    use super::*;

    /// One of two equally likely values about 1, by a hash.
    fn coin(target: usize, batch: u32, spread: f64) -> [f64; 1] {
        [if scene::hash(target as u32, batch) & 1 == 1 { 1.0 + spread } else { 1.0 - spread }]
    }

    #[test]
    fn a_fixed_number_of_paths_is_taken() {
        let stop = Stop::Samples(1000);
        let size = stop.batch(64);
        assert_eq!(size, 16);
        let (tallies, missed) = converge(3, size, stop, &[0], &Quiet, |t, b| coin(t, b, 0.5));
        assert!(tallies.iter().all(|t| t.estimates() * size == 1008) && missed == 0);
    }

    #[test]
    fn each_thing_is_sampled_until_its_own_error_is_small_enough() {
        let stop = Stop::RelativeError { error: 0.02, max_samples: 1 << 20 };
        let spread = [0.01, 0.5, 1.0];
        let (tallies, missed) = converge(3, 64, stop, &[0], &Quiet, |t, b| coin(t, b, spread[t]));
        let n = tallies.iter().map(|t| t.estimates()).collect::<Vec<_>>();
        assert_eq!((n[0], missed), (32, 0), "{n:?}");
        // Variance s² / n is at most (2 %)² from n = (s / 2 %)² on; rounds overshoot by up to a half.
        for (n, least) in [(n[1], 625.0), (n[2], 2500.0)] {
            assert!((0.9 * least..1.6 * least).contains(&f64::from(n)), "{n} for {least}");
        }
        assert!(tallies.iter().all(|t| t.error(0) <= 0.02 * t.mean(0)));
    }

    #[test]
    fn what_is_dark_beside_the_rest_is_not_chased() {
        let stop = Stop::RelativeError { error: 0.01, max_samples: 1 << 16 };
        let value = [1.0, 1e-4];
        let (tallies, missed) = converge(2, 64, stop, &[0], &Quiet, |t, b| coin(t, b, 0.05).map(|x| x * value[t]));
        assert_eq!(missed, 0);
        assert_eq!(tallies[1].estimates(), 32, "its error is far below 1 % of 5 % of the mean");
    }

    #[test]
    fn the_largest_number_of_paths_ends_it_and_is_told() {
        let stop = Stop::RelativeError { error: 1e-6, max_samples: 5000 };
        let (tallies, missed) = converge(2, 64, stop, &[0], &Quiet, |t, b| coin(t, b, 0.5));
        assert!(tallies.iter().all(|t| t.estimates() == 79) && missed == 2);
    }
}
