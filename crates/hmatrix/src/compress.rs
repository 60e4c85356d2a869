//! Packs an operator: the cheapest blocks whose light is as good as was asked for.

use radfile::{Groups, Kernel, Operator, Patches, Progress, luma};
use rayon::prelude::*;

use crate::{
    Error, HMatrix, Params, Report, Result,
    cluster::{Tree, order},
    colour::{Colour, colours, plane},
    pairs::Pairs,
    plan::{Decisions, Plan, Side},
    report::Sizes,
    search::{Round, Search, price},
    stream::{Axis, HEAVIEST, Parts, Plane},
    trial::{Squares, Trial},
};

/// How often the price of a byte is corrected at most.
pub const ROUNDS: usize = 6;
/// Patches exchange much if it is more than this share of the most that either exchanges.
const MUCH: f32 = 0.05;
/// Error of the matrix over that of light, both relative, to begin with: blocks are measured where they are
/// largest, in even light.
pub const FIRST_AIM: f64 = 0.03;

/// Packs `operator`, which is symmetric: only one of each pair of entries is looked at.
///
/// What a byte may cost is found by trial: choices are made at a price, probe lights go through the
/// result, the price is corrected. Other probe lights certify it.
///
/// # Errors
///
/// [`Error::Option`], [`Error::Shape`], [`Error::Coloured`], and [`Error::Container`] for what [`Operator::check`] refuses.
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
    let groups = numbers_of_groups(operator.components(), operator.n);
    let regions = numbers_of_groups(regions(operator), operator.n);
    let order = order(&patches.position, &patches.normal, &regions, tree);
    let weights = weights(&patches.area, &order);
    let groups = order.iter().map(|&patch| groups[patch as usize]).collect();
    let side = Side { weights: weights.clone(), groups };
    let planes = colours(operator).into_iter().enumerate().map(|(number, colour)| {
        let matrix = plane(operator, &order, &side, number, colour);
        Stored { colour, plan: Plan::new(matrix, Pairs::symmetric(tree), number == 0, params.seed, progress) }
    });
    let planes = planes.collect();
    let candidates = Candidates { planes, axis: Axis { tree, order, weights }, channels: operator.channels };
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
    Ok(operator.check(patches.len())?)
}

/// For each of `n` patches, which of the groups that exchange nothing it is of; the largest group is 0.
pub fn numbers_of_groups(mut groups: Vec<Vec<u32>>, n: usize) -> Vec<u32> {
    groups.sort_by_key(|patches| std::cmp::Reverse(patches.len()));
    let mut numbers = vec![0; n];
    for (number, patches) in groups.iter().enumerate() {
        patches.iter().for_each(|&patch| numbers[patch as usize] = number as u32);
    }
    numbers
}

/// Groups of patches that exchange much with each other, through any number of others: rooms, and insides of solids that a
/// gap in the mesh joins to a room. Only the order of clusters follows them.
fn regions(operator: &Operator) -> Vec<Vec<u32>> {
    let n = operator.n;
    let luma = |row: usize, column: usize| luma(operator.entry(row, column));
    let most = |row: usize| (0..n).filter(|&column| column != row).map(|column| luma(row, column)).fold(0.0, f32::max);
    let most: Vec<f32> = (0..n).into_par_iter().map(most).collect();
    let mut groups = Groups::new(n);
    for row in 0..n {
        let much = |&column: &usize| luma(row, column) > MUCH * (most[row] * most[column]).sqrt();
        (0..row).filter(much).for_each(|column| groups.join(row as u32, column as u32));
    }
    groups.lists()
}

/// √A of every place in codes; 1 at least, so that no block is without weight.
pub fn weights(area: &[f32], order: &[u32]) -> Vec<i8> {
    let largest = area.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
    let weight = |&patch: &u32| (HEAVIEST * (area[patch as usize] / largest).sqrt()).round().clamp(1.0, HEAVIEST);
    order.iter().map(|patch| weight(patch) as i8).collect()
}

/// A plane, and what its blocks could be.
struct Stored {
    colour: Colour,
    plan: Plan,
}

/// All that could be stored.
struct Candidates {
    axis: Axis,
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
        // How much more of the error of colour reaches the light than of that of luma.
        let (mut weight, mut rounds) = (2.0, 0);
        let search = Search { wanted, least: 2, most: ROUNDS, ..Search::default() };
        let (best, made) = search.run((FIRST_AIM * wanted).powi(2) * size, |aim| {
            let price = price(aim, |price| {
                let expected = self.decide(price, weight).1;
                expected.luma + weight * expected.colour
            });
            let (packed, squares, expected) = self.pack(price, weight, trial);
            progress.advance(1);
            let ratio = squares.map(|s| s.colour / expected.colour / (s.luma / expected.luma));
            // Found twice, then kept: errors of rounds are compared by it.
            rounds += 1;
            if let Some(ratio) = ratio.filter(|r| rounds <= 2 && r.is_finite() && *r > 0.0) {
                weight = ratio.clamp(0.01, 100.0);
            }
            let matrix = expected.luma + weight * expected.colour;
            Round { error: packed.error, bytes: packed.matrix.to_bytes().len(), matrix, packed }
        });
        (best.packed, made)
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

    /// The operator at a price, and where the errors of its light come from if it has colour.
    fn pack(&self, price: f64, weight: f64, trial: &Trial) -> (Packed, Option<Squares>, Expected) {
        let (decisions, expected) = self.decide(price, weight);
        let plane = |(stored, decisions): (&Stored, &Decisions)| Plane {
            unit: stored.plan.unit(),
            colour: stored.colour,
            blocks: stored.plan.blocks(decisions),
        };
        let mut parts = Parts {
            channels: self.channels,
            columns: self.axis.clone(),
            receivers: None,
            planes: self.planes.iter().zip(&decisions).map(plane).collect(),
        };
        let (bytes, sizes) = parts.write();
        let matrix = HMatrix::new(&parts, bytes);
        let coloured = parts.planes.len() > 1;
        parts.planes.truncate(1);
        let luma = coloured.then(|| HMatrix::new(&parts, Vec::new()));
        let (errors, squares) = trial.by_source(&matrix, luma.as_ref());
        (Packed { matrix, sizes, error: errors.l2_mean }, squares, expected)
    }
}
