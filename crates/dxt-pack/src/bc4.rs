//! BC4 blocks from floats, by the error of the light that comes out.
//!
//! A block has two 8-bit endpoints and either six codes between them, or four and exact 0 and 1.
//! Crates for this take 8-bit texels and minimise the error of the code. But the operator is finer
//! than 8 bits, and a product adds up errors of *values*, times what each sender sends. Four
//! neighbouring senders send much the same: if their light per root of area is m ± σ, the expected square
//! of the sum Σ e x over a row of a block is m² (Σ e)² + σ² Σ e², with e the error of a value times the root of
//! the sender's area. A block stands for its mirror image too, in which rows are senders. So its error is the sum of
//! Σ e² + (m/σ)² Σ_rows (Σ e)² and of the same over columns.
//!
//! An entry that is exactly 0 stays exactly 0, so no light gets into a sealed room: a block with such
//! an entry has 0 among its values.
//!
//! For each mode: start from the extremes, solve least squares for the endpoints, then walk them
//! downhill by single steps.

use radfile::ValueMap;

/// Steps between the endpoints with six codes between them, and with four.
const STEPS: [usize; 2] = [7, 5];

/// (m/σ)², how alike neighbouring senders are taken to be. Measured on three scenes (a box, a court,
/// four rooms) of 2000 to 3200 patches, against 0: a quarter to a third less error of irradiance in
/// smooth light, a tenth less in light that changes at random from patch to patch. Above 10 the
/// latter grows again.
const LIKENESS: f32 = 3.0;

/// A mode whose start has this many times the error of the other's is not worth the walk.
const FAR_BEHIND: f32 = 4.0;

/// An encoder for one map.
pub struct Encoder {
    /// Relative value of code k / (255 · steps), one table for each mode.
    value: [Vec<f32>; 2],
    map: ValueMap,
}

/// Sixteen texels, row by row: relative values wanted, and how much they matter.
pub struct Texels {
    wanted: [f32; 16],
    /// √A of the column's patch, and of the row's; both 0 for a texel that may decode to anything.
    sent: [[f32; 16]; 2],
    /// Root of the sum of their squares.
    weight: [f32; 16],
    /// Whether some texel must be exactly 0.
    zero: bool,
}

impl Texels {
    /// Relative values, 0..=1 where they matter, which texels do, and √A of the patches of rows and columns.
    pub fn new(wanted: [f32; 16], kept: [bool; 16], rows: [f32; 4], columns: [f32; 4]) -> Texels {
        let sent = |root: &dyn Fn(usize) -> f32| std::array::from_fn(|t| if kept[t] { root(t) } else { 0.0 });
        let sent = [sent(&|t| columns[t % 4]), sent(&|t| rows[t / 4])];
        let weight = std::array::from_fn(|t| sent[0][t].hypot(sent[1][t]));
        let zero = wanted.iter().zip(&kept).any(|(wanted, kept)| *wanted == 0.0 && *kept);
        Texels { wanted, sent, weight, zero }
    }

    /// The values that matter.
    fn kept(&self) -> impl Iterator<Item = f32> + '_ {
        self.wanted.iter().zip(&self.weight).filter(|(_, weight)| **weight > 0.0).map(|(wanted, _)| *wanted)
    }
}

/// Endpoints in units of 1/255 and the error they reach.
#[derive(Clone, Copy)]
struct Trial {
    first: i32,
    second: i32,
    error: f32,
}

impl Trial {
    /// 0 with six codes between the endpoints, 1 with four.
    fn mode(self) -> usize {
        usize::from(self.first <= self.second)
    }
}

impl Encoder {
    /// Prepares the tables of a map.
    pub fn new(map: ValueMap) -> Encoder {
        let table =
            |steps: usize| (0..=255 * steps).map(|k| map.decode(k as f32 / (255 * steps) as f32, 1.0)).collect();
        Encoder { value: STEPS.map(table), map }
    }

    /// The block whose decoded values lose the least light.
    pub fn encode(&self, texels: &Texels) -> [u8; 8] {
        let largest = texels.kept().fold(0.0, f32::max);
        if largest <= 0.0 {
            return [0; 8]; // both endpoints 0: every texel is exactly 0
        }
        let smallest = texels.kept().fold(1.0, f32::min);
        // The second mode gets its endpoints from the values that its exact 0 does not serve.
        let smallest_above_zero = texels.kept().filter(|v| *v > 0.02 * largest).fold(1.0, f32::min);
        let six = self.start(0, texels, largest, smallest);
        let four = self.start(1, texels, smallest_above_zero, largest);
        let (near, far) = if four.error < six.error { (four, six) } else { (six, four) };
        let mut best = self.descend(texels, near);
        if far.error <= FAR_BEHIND * near.error {
            let other = self.descend(texels, far);
            best = if other.error < best.error { other } else { best };
        }
        self.block(texels, best)
    }

    /// Endpoints with the given values, improved by least squares.
    fn start(&self, mode: usize, texels: &Texels, first: f32, second: f32) -> Trial {
        let code = |value: f32| (255.0 * self.map.encode(value, 1.0)).round() as i32;
        let mut best = self.trial(mode, texels, code(first), code(second));
        for _ in 0..2 {
            let Some((first, second)) = self.least_squares(texels, best) else { break };
            let trial = self.trial(mode, texels, first, second);
            if trial.error >= best.error {
                break;
            }
            best = trial;
        }
        best
    }

    /// Moves the endpoints by one step at a time while that helps.
    fn descend(&self, texels: &Texels, mut best: Trial) -> Trial {
        let mode = best.mode();
        const MOVES: [(i32, i32); 8] = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, 1), (-1, 1), (1, -1)];
        for _ in 0..16 {
            let from = best;
            for (a, b) in MOVES {
                let trial = self.trial(mode, texels, from.first + a, from.second + b);
                if trial.error < best.error {
                    best = trial;
                }
            }
            if (best.first, best.second) == (from.first, from.second) {
                break;
            }
        }
        best
    }

    /// Endpoints made legal for the mode, with their error.
    fn trial(&self, mode: usize, texels: &Texels, first: i32, second: i32) -> Trial {
        let (mut first, mut second) = (first.clamp(0, 255), second.clamp(0, 255));
        if (mode == 0) != (first > second) {
            std::mem::swap(&mut first, &mut second);
        }
        if mode == 0 && texels.zero {
            second = 0;
        }
        if mode == 0 && first == second {
            if first < 255 { first += 1 } else { second -= 1 }
        }
        let mut trial = Trial { first, second, error: 0.0 };
        trial.error = error(&self.palette(trial), texels);
        trial
    }

    /// Relative values of the eight indices.
    fn palette(&self, trial: Trial) -> [f32; 8] {
        let mode = trial.mode();
        let (a, b, steps) = (trial.first as usize, trial.second as usize, STEPS[mode]);
        let value = |i: usize| self.value[mode][a * (steps - i) + b * i];
        std::array::from_fn(|index| match index {
            0 => value(0),
            1 => value(steps),
            6 if mode == 1 => 0.0,
            7 if mode == 1 => 1.0,
            _ => value(index - 1),
        })
    }

    /// Endpoints with the least Σ e² if every texel keeps its index, errors of codes times the map's slope.
    fn least_squares(&self, texels: &Texels, trial: Trial) -> Option<(i32, i32)> {
        let mode = trial.mode();
        let palette = self.palette(trial);
        let mut sums = [0f32; 5]; // of w s², w s t, w t², w s u, w t u with t = 1 − s
        for (&wanted, &weight) in texels.wanted.iter().zip(&texels.weight) {
            let index = nearest(&palette, wanted);
            if weight == 0.0 || (mode == 1 && index >= 6) {
                continue;
            }
            let step = [0, STEPS[mode], 1, 2, 3, 4, 5, 6][index];
            let t = step as f32 / STEPS[mode] as f32;
            let (s, u) = (1.0 - t, self.map.encode(wanted, 1.0));
            let w = (weight * self.slope(wanted, u)).powi(2);
            let terms = [w * s * s, w * s * t, w * t * t, w * s * u, w * t * u];
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        let [ss, st, tt, su, tu] = sums;
        let determinant = ss * tt - st * st;
        if determinant <= 1e-6 * ss * tt {
            return None;
        }
        let code = |v: f32| (255.0 * v / determinant).round() as i32;
        Some((code(su * tt - tu * st), code(tu * ss - su * st)))
    }

    /// How fast the value grows with the code.
    fn slope(&self, value: f32, code: f32) -> f32 {
        match self.map {
            ValueMap::Log { shift } => shift * value,
            ValueMap::Sqrt => 2.0 * code,
        }
    }

    fn block(&self, texels: &Texels, best: Trial) -> [u8; 8] {
        let palette = self.palette(best);
        let indices = texels
            .wanted
            .iter()
            .enumerate()
            .fold(0u64, |bits, (texel, &wanted)| bits | (nearest(&palette, wanted) as u64) << (3 * texel));
        (indices << 16 | (best.second as u64) << 8 | best.first as u64).to_le_bytes()
    }
}

/// The index whose value is nearest; the first of equals.
fn nearest(palette: &[f32; 8], wanted: f32) -> usize {
    let distance = |i: usize| (palette[i] - wanted).abs();
    (1..8).fold(0, |best, i| if distance(i) < distance(best) { i } else { best })
}

/// The error of a block whose texels take their nearest values.
fn error(palette: &[f32; 8], texels: &Texels) -> f32 {
    let mut miss = [f32::MAX; 16];
    for value in palette {
        for (miss, wanted) in miss.iter_mut().zip(&texels.wanted) {
            let this = value - wanted;
            *miss = if this.abs() < miss.abs() { this } else { *miss };
        }
    }
    let [along, across] = texels.sent.map(|sent| -> [f32; 16] { std::array::from_fn(|t| miss[t] * sent[t]) });
    let squares = along.iter().chain(&across).map(|e| e * e).sum::<f32>();
    let rows = along.as_chunks::<4>().0.iter().map(|row| row.iter().sum::<f32>());
    let columns = (0..4).map(|c| (0..4).map(|r| across[4 * r + c]).sum::<f32>());
    squares + LIKENESS * rows.chain(columns).map(|sum| sum * sum).sum::<f32>()
}
