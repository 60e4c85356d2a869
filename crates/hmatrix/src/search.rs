//! Finds the price of a byte at which light is as good as was asked for, by trial.
//!
//! Squares of errors of the matrix are known without a trial and grow with the price. What they do to light is tried,
//! and corrected: the two are nearly proportional.

/// What is wanted, and when it is found.
pub struct Search {
    /// The error of light.
    pub wanted: f64,
    /// An error is as wanted if it is no larger, and no smaller than this share of it.
    pub close: f64,
    /// The share of it that is aimed at: a little below, so that rounds end.
    pub target: f64,
    /// Rounds before an error counts as found.
    pub least: usize,
    /// Rounds at most.
    pub most: usize,
}

impl Default for Search {
    fn default() -> Search {
        Search { wanted: 0.0, close: 0.96, target: 0.985, least: 1, most: 1 }
    }
}

/// What came of an aim.
pub struct Round<P> {
    pub packed: P,
    /// Error of light.
    pub error: f64,
    pub bytes: usize,
    /// Square of the error of the matrix, as aims are counted.
    pub matrix: f64,
}

/// A round that was made.
#[derive(Clone, Copy)]
struct Tried {
    matrix: f64,
    found: f64,
}

impl Search {
    /// The fewest bytes whose error is no larger than wanted, or the smallest error; and how many rounds were made. The
    /// first round aims at a square of `aim`.
    pub fn run<P>(&self, mut aim: f64, mut pack: impl FnMut(f64) -> Round<P>) -> (Round<P>, usize) {
        let mut best: Option<Round<P>> = None;
        let mut rounds = 0;
        // The largest matrix error that was good enough, and the smallest that was not, with what came of them.
        let (mut below, mut above): (Option<Tried>, Option<Tried>) = (None, None);
        loop {
            let round = pack(aim);
            rounds += 1;
            let (found, matrix) = (round.error, round.matrix);
            let better = |old: &Round<P>| match (found <= self.wanted, old.error <= self.wanted) {
                (true, true) => round.bytes < old.bytes,
                (false, false) => found < old.error,
                (fits, _) => fits,
            };
            let kept = match best {
                Some(old) if !better(&old) => old,
                _ => round,
            };
            let is_close = (self.close * self.wanted..=self.wanted).contains(&found) && rounds >= self.least;
            if found == 0.0 || is_close || rounds >= self.most {
                return (kept, rounds);
            }
            best = Some(kept);
            let tried = Tried { matrix, found };
            if found <= self.wanted {
                below = below.filter(|old| old.matrix >= matrix).or(Some(tried));
            } else {
                above = above.filter(|old| old.matrix <= matrix).or(Some(tried));
            }
            aim = match (below, above) {
                (Some(below), Some(above)) if below.matrix < above.matrix => self.between(below, above),
                _ => self.next(matrix, found),
            };
        }
    }

    /// What to aim at between two errors, one good enough and one not: a straight line through their logarithms. Light
    /// of few patches makes the error rise more steeply than that of the matrix.
    fn between(&self, below: Tried, above: Tried) -> f64 {
        let share = (self.target * self.wanted / below.found).ln() / (above.found / below.found).ln();
        below.matrix * (above.matrix / below.matrix).powf(share.clamp(0.1, 0.9))
    }

    /// What to aim at when a square of `matrix` gave the error `found`.
    pub fn next(&self, matrix: f64, found: f64) -> f64 {
        matrix * (self.target * self.wanted / found).powi(2)
    }
}

/// The price of a byte at which the square of the matrix error, which grows with the price, is `aim`.
pub fn price(aim: f64, error: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (aim * 1e-12, aim);
    for _ in 0..30 {
        let middle = (low * high).sqrt();
        if error(middle) > aim { high = middle } else { low = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors that rise with the matrix error as few lights' do: much more steeply than its root.
    #[test]
    fn a_steep_error_is_found_from_both_sides() {
        let search = Search { wanted: 0.01, most: 6, ..Search::default() };
        for start in [1e-3, 0.1, 10.0] {
            let steep = |aim: f64| {
                let error = 0.01 * (aim / 0.3).powf(1.4);
                Round { packed: (), error, bytes: (1e6 / aim.sqrt()) as usize, matrix: aim }
            };
            let (round, rounds) = search.run(start, steep);
            assert!((0.0096..=0.01).contains(&round.error), "from {start}: {} after {rounds} rounds", round.error);
        }
    }
}
