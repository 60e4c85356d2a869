//! Means and their standard errors from independent estimates.
//!
//! Source: B. P. Welford, Note on a method for calculating corrected sums of squares and products,
//! Technometrics 4(3), 1962.

/// A linear RGB quantity and the standard error of each channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// The estimate.
    pub value: [f64; 3],
    /// One standard deviation of `value`.
    pub error: [f64; 3],
}

/// Channels of one colour in a [`Tally`]: red, green, blue, luminance.
pub const COLOUR: usize = 4;
/// Place of the luminance among them.
pub const LUMINANCE: usize = 3;

/// Luminance of linear RGB (ITU-R BT.709).
pub fn luminance(rgb: [f64; 3]) -> f64 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

/// A colour with its luminance, as the channels of a [`Tally`].
pub fn channels(rgb: [f64; 3]) -> [f64; COLOUR] {
    [rgb[0], rgb[1], rgb[2], luminance(rgb)]
}

/// Running mean and spread of independent, equally good estimates of `N` quantities.
#[derive(Clone, Copy, Debug)]
pub struct Tally<const N: usize> {
    estimates: u32,
    mean: [f64; N],
    squares: [f64; N],
}

impl<const N: usize> Default for Tally<N> {
    fn default() -> Self {
        Tally { estimates: 0, mean: [0.0; N], squares: [0.0; N] }
    }
}

impl<const N: usize> Tally<N> {
    /// Adds one estimate.
    pub fn add(&mut self, estimate: &[f64; N]) {
        self.estimates += 1;
        for (c, &x) in estimate.iter().enumerate() {
            let step = x - self.mean[c];
            self.mean[c] += step / f64::from(self.estimates);
            self.squares[c] += step * (x - self.mean[c]);
        }
    }

    /// How many estimates were added.
    pub fn estimates(&self) -> u32 {
        self.estimates
    }

    /// Mean of a channel.
    pub fn mean(&self, channel: usize) -> f64 {
        self.mean[channel]
    }

    /// Standard error of the mean of a channel; infinite for fewer than two estimates.
    pub fn error(&self, channel: usize) -> f64 {
        let n = f64::from(self.estimates);
        if self.estimates < 2 { f64::INFINITY } else { (self.squares[channel] / (n * (n - 1.0))).sqrt() }
    }

    /// The colour whose channels start at `first`.
    pub fn colour(&self, first: usize) -> Measured {
        Measured {
            value: std::array::from_fn(|c| self.mean(first + c)),
            error: std::array::from_fn(|c| self.error(first + c)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_standard_error_are_those_of_the_definition() {
        let mut tally = Tally::<1>::default();
        for x in [1e9 + 2.0, 1e9 + 4.0, 1e9 + 4.0, 1e9 + 6.0] {
            tally.add(&[x]);
        }
        assert_eq!(tally.mean(0), 1e9 + 4.0);
        // Variance 8/3 over 4 estimates; the large offset must not swallow it.
        assert!((tally.error(0) - (8.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-7, "{}", tally.error(0));
    }

    #[test]
    fn a_single_estimate_does_not_know_its_error() {
        let mut tally = Tally::<1>::default();
        tally.add(&[1.0]);
        assert_eq!(tally.error(0), f64::INFINITY);
    }
}
