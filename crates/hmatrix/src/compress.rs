//! Packs an operator: the cheapest blocks whose light is as good as was asked for.

use radfile::{Kernel, Operator, Patches, Progress};
use rayon::prelude::*;

use crate::{
    Error, HMatrix, Params, Report, Result,
    cluster::{Tree, order},
    colour::{Colour, colours, plane},
    plan::{Decisions, Matrix, Plan},
    report::Sizes,
    stream::{HEAVIEST, Parts, Plane},
    trial::Trial,
};

/// How often the price of a byte is corrected at most.
const ROUNDS: usize = 6;
/// Error of the matrix over that of light, both relative, to begin with: blocks are measured where they are
/// largest, in even light.
const FIRST_AIM: f64 = 0.03;
/// An error is as wanted if it is no larger, and no smaller than this share of it.
const CLOSE: f64 = 0.96;

/// Packs `operator`, which is symmetric: only one of each pair of entries is looked at.
///
/// What a byte may cost is found by trial: choices are made at a price, probe lights go through the
/// result, the price is corrected. Other probe lights certify it.
///
/// # Errors
///
/// [`Error::Option`], [`Error::Empty`], [`Error::Shape`], [`Error::Coloured`], [`Error::PatchCount`], [`Error::Value`].
pub fn compress(
    operator: &Operator,
    patches: &Patches,
    params: &Params,
    progress: &dyn Progress,
) -> Result<(HMatrix, Report)> {
    params.check()?;
    check(operator, patches)?;
    if params.kernel == Kernel::OneBounce && operator.channels != 1 {
        return Err(Error::Coloured);
    }
    let tree = Tree::new(operator.n, params.leaf);
    let groups = groups(operator);
    let order = order(patches, &groups, tree);
    let weights = weights(patches, &order);
    let groups: Vec<u32> = order.iter().map(|&patch| groups[patch as usize]).collect();
    let planes = colours(operator).into_iter().enumerate().map(|(number, colour)| {
        let matrix = Matrix { groups: groups.clone(), ..plane(operator, &order, &weights, number, colour) };
        Stored { colour, plan: Plan::new(matrix, tree, number == 0, params.seed, progress) }
    });
    let candidates = Candidates { planes: planes.collect(), order, weights, tree, channels: operator.channels };
    let trial = Trial::new(operator, patches, params, params.seed, progress);
    progress.begin("choosing blocks", ROUNDS as u64);
    let (best, rounds) = candidates.search(&trial, params.error, progress);
    let held_out = Trial::new(operator, patches, params, params.seed.wrapping_add(1), progress);
    let errors = held_out.errors(&best.matrix);
    let entries = (operator.n as f64).powi(2);
    let bytes = best.matrix.to_bytes().len();
    let report = Report {
        patches: operator.n,
        channels: operator.channels,
        kernel: params.kernel,
        error_wanted: params.error,
        error_steered: best.error,
        probes: errors.probes,
        l2_mean: errors.l2_mean,
        l2_max: errors.l2_max,
        p99: errors.p99,
        vis99: errors.vis99,
        energy_bias: errors.energy_bias,
        bytes,
        bytes_per_entry: bytes as f64 / entries,
        smaller_than_form_factors: 4.0 * entries / bytes as f64,
        sizes: best.sizes,
        products: held_out.products(),
        multiplications: best.matrix.multiplications() as f64 / entries,
        rounds,
    };
    Ok((best.matrix, report))
}

/// Bytes that [`compress`] takes besides its inputs, its result included.
pub fn memory_needed(n: usize, channels: usize) -> u64 {
    // What the blocks of a plane could be, 12 bytes an entry, besides luma and the plane at work. Measured: 34 bytes an
    // entry for three planes of 5272 patches, where these are 44. Probes grow with n.
    let (n, planes) = (n as u64, channels as u64);
    n * n * (8 + 12 * planes) + n * (1 << 14) + (1 << 20)
}

fn check(operator: &Operator, patches: &Patches) -> Result<()> {
    let (n, channels) = (operator.n, operator.channels);
    let values = operator.values.len();
    if !matches!(channels, 1 | 3) || n.checked_mul(n).and_then(|size| size.checked_mul(channels)) != Some(values) {
        return Err(Error::Shape { values, channels, n });
    }
    if n == 0 {
        return Err(Error::Empty);
    }
    if patches.len() != n {
        return Err(Error::PatchCount { operator: n, patches: patches.len() });
    }
    match operator.values.par_iter().position_first(|v| !(v.is_finite() && *v >= 0.0)) {
        Some(at) => Err(Error::Value {
            channel: at / (n * n),
            receiver: at / n % n,
            sender: at % n,
            value: operator.values[at],
        }),
        None => Ok(()),
    }
}

/// For each patch, which of the groups that exchange nothing it is of; the largest group is 0.
fn groups(operator: &Operator) -> Vec<u32> {
    let mut components = operator.components();
    components.sort_by_key(|patches| std::cmp::Reverse(patches.len()));
    let mut groups = vec![0; operator.n];
    for (number, patches) in components.iter().enumerate() {
        patches.iter().for_each(|&patch| groups[patch as usize] = number as u32);
    }
    groups
}

/// √A of every place in codes; 1 at least, so that no block is without weight.
fn weights(patches: &Patches, order: &[u32]) -> Vec<i8> {
    let largest = patches.area.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
    let weight =
        |&patch: &u32| (HEAVIEST * (patches.area[patch as usize] / largest).sqrt()).round().clamp(1.0, HEAVIEST);
    order.iter().map(|patch| weight(patch) as i8).collect()
}

/// A plane, and what its blocks could be.
struct Stored {
    colour: Colour,
    plan: Plan,
}

/// All that could be stored.
struct Candidates {
    tree: Tree,
    order: Vec<u32>,
    weights: Vec<i8>,
    channels: usize,
    planes: Vec<Stored>,
}

/// What was stored at some price.
struct Packed {
    matrix: HMatrix,
    sizes: Sizes,
    error: f64,
}

/// Squares of the errors of all channels.
struct Expected {
    luma: f64,
    colour: f64,
}

impl Candidates {
    /// The fewest bytes whose error is no larger than wanted, or the smallest error; and how many were tried.
    fn search(&self, trial: &Trial, wanted: f64, progress: &dyn Progress) -> (Packed, usize) {
        let size = self.channels as f64 * self.planes[0].plan.energy();
        // Square of the matrix error to aim at, and how much more of it reaches the light if it is colour's.
        let (mut aim, mut weight) = ((FIRST_AIM * wanted).powi(2) * size, 2.0);
        let mut best: Option<Packed> = None;
        for round in 1..=ROUNDS {
            let price = self.price(aim, weight);
            let (packed, luma, expected) = self.pack(price, weight, trial);
            progress.advance(1);
            let found = packed.error;
            let squares = trial.squares(&packed.matrix, &luma);
            let ratio = squares.colour / expected.colour / (squares.luma / expected.luma);
            if ratio.is_finite() && ratio > 0.0 {
                weight = ratio.clamp(0.01, 100.0);
            }
            let better = |old: &Packed| match (found <= wanted, old.error <= wanted) {
                (true, true) => packed.matrix.to_bytes().len() < old.matrix.to_bytes().len(),
                (false, false) => found < old.error,
                (fits, _) => fits,
            };
            if best.as_ref().is_none_or(better) {
                best = Some(packed);
            }
            if found == 0.0 || (CLOSE * wanted..=wanted).contains(&found) && round > 1 {
                return (best.expect("a round was made"), round);
            }
            // A little below what is wanted, so that rounds end.
            aim = (expected.luma + weight * expected.colour) * (0.985 * wanted / found).powi(2);
        }
        (best.expect("a round was made"), ROUNDS)
    }

    /// The choices of every plane. Errors of luma are in all channels; those of colour count by their weight.
    fn decide(&self, price: f64, weight: f64) -> (Vec<Decisions>, Expected) {
        let times = self.channels as f64;
        let price = |number: usize| if number == 0 { price / times } else { price / weight };
        let planes = self.planes.iter().enumerate();
        let decisions: Vec<Decisions> = planes.map(|(number, plane)| plane.plan.decide(price(number))).collect();
        let colour = decisions[1..].iter().map(Decisions::error).sum();
        let expected = Expected { luma: times * decisions[0].error(), colour };
        (decisions, expected)
    }

    /// The price of a byte at which the square of the matrix error is `aim`, colour weighted.
    fn price(&self, aim: f64, weight: f64) -> f64 {
        let (mut low, mut high) = (aim * 1e-12, aim);
        for _ in 0..30 {
            let middle = (low * high).sqrt();
            let expected = self.decide(middle, weight).1;
            if expected.luma + weight * expected.colour > aim { high = middle } else { low = middle }
        }
        low
    }

    /// The operator at a price, and the same without colour.
    fn pack(&self, price: f64, weight: f64, trial: &Trial) -> (Packed, HMatrix, Expected) {
        let (decisions, expected) = self.decide(price, weight);
        let plane = |(stored, decisions): (&Stored, &Decisions)| Plane {
            unit: stored.plan.unit(),
            colour: stored.colour,
            blocks: stored.plan.blocks(decisions),
        };
        let mut parts = Parts {
            tree: self.tree,
            channels: self.channels,
            order: self.order.clone(),
            weights: self.weights.clone(),
            planes: self.planes.iter().zip(&decisions).map(plane).collect(),
        };
        let (bytes, sizes) = parts.write();
        let matrix = HMatrix::new(&parts, bytes);
        parts.planes.truncate(1);
        let luma = HMatrix::new(&parts, Vec::new());
        let error = trial.errors(&matrix).l2_mean;
        (Packed { matrix, sizes, error }, luma, expected)
    }
}
