//! Packs the rows of receivers: as `compress.rs` does an operator, chunk by chunk.
//!
//! Receivers may be many times as many as senders. They are cut into chunks of about as many as there are senders, each with
//! a tree as deep as that of the senders, so that blocks are about square and no more than a few chunks are dense at a
//! time. All chunks have one price of a byte. It is found with some chunks, whose candidates are kept, and corrected with
//! all if it has to be.
//!
//! What is stored is relative to the weight √A of the column, as in a symmetric operator: weights of senders grow with
//! their areas. Errors that neighbours share count more than others, in rows as in columns, though the error that steers
//! does not ask for the former: without it there are a tenth fewer bytes, but four times the bias, and edges of blocks to be
//! seen.

use probes::{Errors, Row, summarise};
use radfile::{Patches, Progress};
use rayon::prelude::*;
use serde::Serialize;

use crate::{
    HMatrix, Params, Rectangle, Result,
    block::Block,
    cluster::{Tree, order},
    compress::{FIRST_AIM, ROUNDS, weights},
    pairs::{Id, Pairs},
    plan::{Matrix, Plan, Side, unit},
    report::Sizes,
    rows::{Receivers, RowSource, Scan, Senders, Sent, read_row},
    search::{Round, Search, price},
    stream::{Axis, HEAVIEST, Parts, Plane},
};

/// Chunks whose candidates are kept while the price is looked for.
const KEPT: usize = 3;
/// How often all chunks are packed at most.
const PASSES: usize = 3;
/// By how much leaves are smaller than those of an operator: what a point sees has sharper edges than what patches exchange
/// after all bounces. Measured on the last gather of 25755 receivers from 2638 patches at 1 %, with 2048 rays: 1 takes 100
/// bytes a receiver, 2 takes 87; twice as many receivers a leaf take 108.
const SMALLER_LEAVES: usize = 2;

/// Numbers about packed rows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RowsReport {
    /// Number of receivers.
    pub receivers: usize,
    /// Receivers without any weight.
    pub dark: usize,
    /// Number of senders.
    pub senders: usize,
    /// Parts that the receivers were packed in.
    pub chunks: usize,
    /// Error that was wanted.
    pub error_wanted: f64,
    /// The same error under the probe lights that steered.
    pub error_steered: f64,
    /// Number of other probe lights, that certify. Errors under them are of what receivers with any weight receive; each
    /// counts the same.
    pub probes: usize,
    /// L2 norm of the error relative to that of what is received, mean over probes.
    pub l2_mean: f64,
    /// The same, worst probe.
    pub l2_max: f64,
    /// 99th percentile of |error| relative to the mean of what is received, mean over probes.
    pub p99: f64,
    /// 99th percentile of |error| relative to what is received there plus a tenth of the mean, mean over probes.
    pub vis99: f64,
    /// Light gained or, if negative, lost relative to all that is received, mean over probes.
    pub energy_bias: f64,
    /// Mean of what packing changes the sum of a row by, relative to the mean sum.
    pub furnace: f64,
    /// Bytes of the packed rows.
    pub bytes: usize,
    /// Bytes per receiver.
    pub bytes_per_receiver: f64,
    /// Bytes per entry of the receivers × senders matrix.
    pub bytes_per_entry: f64,
    /// What the bytes are spent on.
    pub sizes: Sizes,
    /// Multiplications of a product with one channel relative to those of a dense matrix.
    pub multiplications: f64,
    /// How often the price of a byte was tried, with some chunks or with all.
    pub rounds: usize,
}

/// Packs the weights of all senders at all receivers, which need not be symmetric; a row sums to at most 1.
///
/// Of `params` everything counts that is not said of operators: `kernel` and `keep_dense` do not. The error is that of
/// what receivers get of senders that are lit by probe lights. Receivers without a weight get nothing, and
/// receivers and senders that no row connects, even over others, exchange exactly nothing. `row` is called two to four times for
/// each receiver.
///
/// # Errors
///
/// [`Error::Option`], [`Error::NoSenders`], [`Error::SenderCount`], [`Error::NoReceivers`], [`Error::ReceiverCount`],
/// [`Error::Sender`], [`Error::Weight`], [`Error::RowSum`].
pub fn compress_rows(
    receivers: &Receivers,
    senders: &Senders,
    row: &RowSource,
    params: &Params,
    progress: &dyn Progress,
) -> Result<(Rectangle, RowsReport)> {
    params.check()?;
    receivers.check()?;
    senders.check()?;
    let (m, n) = (receivers.position.len(), senders.area.len());
    let [steering, certifying] = [0, 1].map(|k| Sent::new(senders, params.probes, params.seed.wrapping_add(k)));
    let numbers: Vec<u32> = (0..n as u32).collect();
    let factor: Vec<f32> = weights(senders.area, &numbers).iter().map(|&w| HEAVIEST / f32::from(w)).collect();
    let scan = Scan::new(row, m, &factor, [&steering, &certifying], progress)?;
    let packer = Packer::new(receivers, senders, row, factor, &scan, &steering, params, progress);
    let (chunks, rounds) = packer.search(params.error);
    let error_steered = error(&chunks);
    let count = chunks.len();
    let blocks = chunks.into_iter().flat_map(|chunk| chunk.blocks).collect();
    let parts = packer.parts(packer.rows.clone(), blocks);
    let (bytes, sizes) = parts.write();
    let packed = Rectangle(HMatrix::new(&parts, bytes));
    let errors = certify(&packed, &scan, &certifying);
    let (bytes, entries) = (packed.to_bytes().len(), m as f64 * n as f64);
    let report = RowsReport {
        receivers: m,
        dark: m - scan.lit,
        senders: n,
        chunks: count,
        error_wanted: params.error,
        error_steered,
        probes: certifying.count,
        l2_mean: errors.l2_mean,
        l2_max: errors.l2_max,
        p99: errors.p99,
        vis99: errors.vis99,
        energy_bias: errors.energy_bias,
        furnace: furnace(&packed, &scan),
        bytes,
        bytes_per_receiver: bytes as f64 / m as f64,
        bytes_per_entry: bytes as f64 / entries,
        sizes,
        multiplications: packed.0.multiplications() as f64 / entries,
        rounds,
    };
    Ok((packed, report))
}

/// Bytes that [`compress_rows`] takes besides its inputs, its result included.
pub fn rows_memory_needed(receivers: usize, senders: usize, params: &Params) -> u64 {
    let (m, n) = (receivers as u64, senders as u64);
    let trees = Trees::new(receivers, senders, params.leaf);
    let chunk = (trees.rows.largest(0) as u64) * n;
    let kept = (KEPT as u64 + 1).min(trees.rows.roots as u64);
    // Light of both sets of probes, and of each receiver; then what the blocks of a chunk could be.
    let probes = u64::from(params.probes) * 8;
    m * (6 * probes + 256) + n * (2 * probes + 256) + kept * chunk * 24 + (1 << 20)
}

/// Trees of receivers and of senders.
struct Trees {
    rows: Tree,
    columns: Tree,
}

impl Trees {
    /// For receivers that have any weight.
    fn new(receivers: usize, senders: usize, leaf: usize) -> Trees {
        let chunk = senders.max(leaf);
        // None for none, and chunks of two thirds to one and a half of that.
        let roots = ((receivers + chunk / 2) / chunk).max(usize::from(receivers > 0));
        let fewest = receivers / roots.max(1);
        // Blocks of leaves are about square, and every leaf has a receiver.
        let side = ((fewest as f64 * senders as f64).sqrt().ceil() as usize).max(1);
        let most = fewest.min(senders).max(1).ilog2();
        let depth = Tree::new(side, leaf.div_ceil(SMALLER_LEAVES)).depth.min(most);
        Trees { rows: Tree { n: receivers, roots, depth }, columns: Tree { n: senders, roots: 1, depth } }
    }
}

/// Blocks of a chunk at some price.
struct Chunk {
    blocks: Vec<(Id, Block)>,
    bytes: usize,
    /// Squares of the error and of the light under each probe.
    squares: Vec<[f64; 2]>,
}

/// Error of light, mean over probes.
fn error(chunks: &[Chunk]) -> f64 {
    let probes = chunks.first().map_or(0, |chunk| chunk.squares.len());
    let sum = |probe: usize, k: usize| chunks.iter().map(|chunk| chunk.squares[probe][k]).sum::<f64>();
    let share = |probe: usize| if sum(probe, 1) > 0.0 { (sum(probe, 0) / sum(probe, 1)).sqrt() } else { 0.0 };
    (0..probes).map(share).sum::<f64>() / probes.max(1) as f64
}

/// All that packing a chunk takes.
struct Packer<'a> {
    row: &'a RowSource<'a>,
    pairs: Pairs,
    rows: Axis,
    columns: Axis,
    /// Groups of the receiver at each place.
    groups: Vec<u32>,
    column_side: Side,
    /// By what the weights of each sender are multiplied.
    factor: Vec<f32>,
    /// Where each sender stands.
    place: Vec<u32>,
    unit: f32,
    scan: &'a Scan,
    sent: &'a Sent,
    seed: u64,
    progress: &'a dyn Progress,
}

impl<'a> Packer<'a> {
    #[expect(clippy::too_many_arguments)]
    fn new(
        receivers: &Receivers,
        senders: &Senders,
        row: &'a RowSource<'a>,
        factor: Vec<f32>,
        scan: &'a Scan,
        sent: &'a Sent,
        params: &Params,
        progress: &'a dyn Progress,
    ) -> Packer<'a> {
        let trees = Trees::new(scan.lit, senders.area.len(), params.leaf);
        let order_of_senders = order(senders.position, senders.normal, &scan.sender_group, trees.columns);
        let mut place = vec![0; order_of_senders.len()];
        order_of_senders.iter().zip(0..).for_each(|(&sender, at)| place[sender as usize] = at);
        let (lit, dark) = scan.order.split_at(scan.lit);
        let of_lit = |all: &[[f32; 3]]| -> Vec<[f32; 3]> { lit.iter().map(|&r| all[r as usize]).collect() };
        let groups: Vec<u32> = lit.iter().map(|&r| scan.receiver_group[r as usize]).collect();
        let places = order(&of_lit(receivers.position), &of_lit(receivers.normal), &groups, trees.rows);
        let order_of_receivers = places.iter().map(|&at| lit[at as usize]).chain(dark.iter().copied()).collect();
        let weights = weights(senders.area, &order_of_senders);
        let side = Side {
            weights: weights.clone(),
            groups: order_of_senders.iter().map(|&sender| scan.sender_group[sender as usize]).collect(),
        };
        Packer {
            row,
            pairs: Pairs::rectangular(trees.rows, trees.columns),
            rows: Axis::receivers(trees.rows, order_of_receivers),
            groups: places.iter().map(|&at| groups[at as usize]).collect(),
            column_side: side,
            factor,
            place,
            columns: Axis { tree: trees.columns, order: order_of_senders, weights },
            unit: unit(scan.largest),
            scan,
            sent,
            seed: params.seed,
            progress,
        }
    }

    /// The blocks of every chunk at one price, and how often it was tried.
    fn search(&self, wanted: f64) -> (Vec<Chunk>, usize) {
        let count = self.rows.tree.roots;
        let kept: Vec<usize> = (0..count.min(KEPT)).map(|k| (2 * k + 1) * count / (2 * count.min(KEPT))).collect();
        let plans: Vec<Plan> = kept.iter().map(|&chunk| self.plan(chunk)).collect();
        let expected = |price: f64| plans.iter().map(|plan| plan.decide(price).error()).sum::<f64>();
        let round = |aim: f64, chunks: &[usize]| {
            let price = price(aim, expected);
            let pack = |&chunk: &usize| match kept.iter().position(|&k| k == chunk) {
                Some(at) => self.pack(chunk, &plans[at], price),
                None => self.pack(chunk, &self.plan(chunk), price),
            };
            let packed: Vec<Chunk> = chunks.iter().map(pack).collect();
            let bytes = packed.iter().map(|chunk| chunk.bytes).sum();
            Round { error: error(&packed), bytes, matrix: expected(price), packed }
        };
        let of_some = Search { wanted, most: ROUNDS, ..Search::default() };
        let energy: f64 = plans.iter().map(Plan::energy).sum();
        let (best, rounds) = of_some.run((FIRST_AIM * wanted).powi(2) * energy, |aim| round(aim, &kept));
        if kept.len() == count {
            return (best.packed, rounds);
        }
        // A pass takes long, so it need not come as close.
        let of_all = Search { wanted, close: 0.9, target: 0.95, least: 1, most: PASSES };
        let all: Vec<usize> = (0..count).collect();
        let (best, passes) = of_all.run(of_all.next(best.matrix, best.error), |aim| round(aim, &all));
        (best.packed, rounds + passes)
    }

    /// What the blocks of a chunk could be.
    fn plan(&self, chunk: usize) -> Plan {
        let (places, n) = (self.rows.tree.range(0, chunk), self.factor.len());
        let mut values = vec![0.0; places.len() * n];
        let rows = values.par_chunks_mut(n).zip(&self.rows.order[places.clone()]);
        rows.for_each_init(Vec::new, |row, (to, &receiver)| {
            read_row(self.row, receiver as usize, row);
            for &(sender, weight) in row.iter() {
                let sender = sender as usize;
                to[self.place[sender] as usize] = self.factor[sender] * weight;
            }
        });
        let weights = self.rows.weights[places.clone()].to_vec();
        let rows = Side { weights, groups: self.groups[places].to_vec() };
        let matrix = Matrix { values, unit: self.unit, rows, columns: self.column_side.clone() };
        Plan::new(matrix, self.pairs.chunk(chunk), true, self.seed, self.progress)
    }

    /// A chunk at a price of a byte.
    fn pack(&self, chunk: usize, plan: &Plan, price: f64) -> Chunk {
        let decisions = plan.decide(price);
        let places = self.rows.tree.range(0, chunk);
        let tree = self.pairs.chunk(chunk).rows;
        let parts = self.parts(Axis::receivers(tree, (0..places.len() as u32).collect()), plan.blocks(&decisions));
        let found = received(&HMatrix::new(&parts, Vec::new()), places.len(), self.sent);
        let count = self.sent.count;
        let mut squares = vec![[0.0; 2]; count];
        for (found, &receiver) in found.chunks(count).zip(&self.rows.order[places]) {
            let exact = &self.scan.received[0][receiver as usize * count..][..count];
            for ((square, found), exact) in squares.iter_mut().zip(found).zip(exact) {
                *square = [square[0] + (found - exact).powi(2), square[1] + exact * exact];
            }
        }
        let of_all = |(id, block): (Id, Block)| (Id { a: id.a + (chunk << id.level), ..id }, block);
        let [plane] = <[Plane; 1]>::try_from(parts.planes).unwrap_or_else(|_| unreachable!("parts have one plane"));
        Chunk { blocks: plane.blocks.into_iter().map(of_all).collect(), bytes: decisions.bytes() as usize, squares }
    }

    fn parts(&self, rows: Axis, blocks: Vec<(Id, Block)>) -> Parts {
        let plane = Plane { unit: self.unit, colour: [1.0; 3], blocks };
        Parts { channels: 1, columns: self.columns.clone(), receivers: Some(rows), planes: vec![plane] }
    }
}

/// What receivers get of lights: receivers × lights.
fn received(matrix: &HMatrix, receivers: usize, sent: &Sent) -> Vec<f64> {
    let (count, mut workspace) = (sent.count, matrix.workspace());
    let mut all = vec![0.0; receivers * count];
    let mut y = vec![[0.0; 3]; receivers];
    for first in (0..count).step_by(3) {
        // Three lights are the three colours of one.
        let light = |sent: &[f32]| std::array::from_fn(|c| sent.get(first + c).copied().unwrap_or(0.0));
        let x: Vec<[f32; 3]> = sent.values.chunks(count).map(light).collect();
        matrix.multiply(&x, &mut y, &mut workspace);
        for (all, y) in all.chunks_mut(count).zip(&y) {
            all[first..].iter_mut().zip(y).for_each(|(all, y)| *all = f64::from(*y));
        }
    }
    all
}

/// Errors under lights that did not steer.
fn certify(packed: &Rectangle, scan: &Scan, sent: &Sent) -> Errors {
    let lit = &scan.order[..scan.lit];
    if lit.is_empty() {
        return Errors::default();
    }
    let (found, exact) = (received(&packed.0, packed.receivers(), sent), &scan.received[1]);
    let row = |&receiver: &u32| {
        let own = receiver as usize * sent.count..(receiver as usize + 1) * sent.count;
        let error = found[own.clone()].iter().zip(&exact[own.clone()]).map(|(f, e)| f - e).collect();
        Row { light: exact[own].to_vec(), error, matrix: [0.0; 2] }
    };
    let rows: Vec<Row> = lit.iter().map(row).collect();
    // Receivers of one size that no light reaches directly.
    let alike = Patches { area: vec![1.0; lit.len()], ..Patches::default() };
    summarise(&[rows], &alike, &vec![vec![0.0; lit.len()]; sent.count])
}

fn furnace(packed: &Rectangle, scan: &Scan) -> f64 {
    let mut y = vec![[0.0; 3]; packed.receivers()];
    packed.multiply(&vec![[1.0; 3]; packed.senders()], &mut y, &mut packed.workspace());
    let total: f64 = scan.sums.iter().sum();
    let error = y.iter().zip(&scan.sums).map(|(y, sum)| (f64::from(y[0]) - sum).abs()).sum::<f64>();
    if total > 0.0 { error / total } else { 0.0 }
}
