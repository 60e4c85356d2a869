//! The rows of receivers in parts, packed at a price of a byte that follows the error.
//!
//! Receivers may be many times as many as senders. They are cut into chunks of about as many as there are senders, each with
//! a tree as deep as that of the senders, so that blocks are about square. A part is a cluster of the first level that has
//! blocks. The price is found with a few parts, spread over all; the others are packed once, some at a time, while the
//! price follows what the error of all would be, so that it is as wanted when the last one is done.
//!
//! What is stored is relative to the weight √A of the column, as in a symmetric operator: weights of senders grow with
//! their areas. Errors that neighbours share count more than others, in rows as in columns, though the error that steers
//! does not ask for the former: without it there are a tenth fewer bytes, but four times the bias, and edges of blocks to be
//! seen.

use std::ops::Range;

use radfile::Progress;
use rayon::prelude::*;

use crate::{
    Params,
    block::Block,
    choose::{Choice, Chooser, Clusters},
    cluster::{Tree, order},
    compress::{FIRST_AIM, ROUNDS, weights},
    pairs::{Id, Pairs},
    plan::{Side, unit},
    residual::{Entries, Sparse},
    rows::{Receivers, Row, RowSource, Scan, Senders, Sent, read_row},
    search::{Round, Search},
    stream::{Axis, Parts, Plane},
};

/// Parts that the price is looked for with.
const SAMPLE: usize = 12;
/// How often the price changes while the others are packed.
const BATCHES: usize = 8;
/// What is aimed at, as a share of the error that is wanted.
const TARGET: f64 = 0.985;
/// Bytes that a row may take: for the first price that is tried.
const FIRST_BYTES: f64 = 50.0;
/// Entries of dense rows that are read at once at most, if a part has no more.
pub const ENTRIES: usize = 1 << 24;
/// Multiples of it are spread evenly between whole numbers.
const GOLDEN: f64 = 0.618_033_988_749_895;
/// By how much leaves are smaller than those of an operator: what a point sees has sharper edges than what patches exchange
/// after all bounces. Measured on the last gather of 57821 receivers from 2638 patches at 1 %, with 2048 rays: 1 takes 72
/// bytes a receiver and 2.7 ms for a product on one thread, 2 takes 68 and 3.8, 4 takes 66 and 5.5.
const SMALLER_LEAVES: usize = 2;

/// Trees of receivers and of senders.
pub struct Trees {
    pub rows: Tree,
    pub columns: Tree,
}

impl Trees {
    /// For receivers that have any weight.
    pub fn new(receivers: usize, senders: usize, leaf: usize) -> Trees {
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

/// The blocks of some rows, a cluster of the first level, at some price.
struct Part {
    price: f64,
    blocks: Vec<(Id, Block)>,
    bytes: f64,
    /// Squares of the errors under each probe.
    squares: Vec<f64>,
}

/// What is packed of all.
struct Made {
    parts: Vec<Option<Part>>,
    /// Parts that were packed, those that were packed again counted again.
    packed: usize,
}

impl Made {
    fn put(&mut self, numbers: &[usize], packed: Vec<Part>) {
        self.packed += numbers.len();
        numbers.iter().zip(packed).for_each(|(&number, part)| self.parts[number] = Some(part));
    }
}

/// All that packing rows takes.
pub struct Packer<'a> {
    row: &'a RowSource<'a>,
    pairs: Pairs,
    rows: Axis,
    columns: Axis,
    row_clusters: Clusters,
    column_clusters: Clusters,
    /// By what the weights of each sender are multiplied.
    factor: Vec<f32>,
    /// Where each sender stands.
    place: Vec<u32>,
    /// What the sender at each place sends as rows are stored, places × lights.
    sent: Vec<f32>,
    lights: usize,
    unit: f32,
    scan: &'a Scan,
    /// Squares of what all receive of each probe.
    light: Vec<f64>,
    progress: &'a dyn Progress,
}

impl<'a> Packer<'a> {
    #[expect(clippy::too_many_arguments)]
    pub fn new(
        receivers: &Receivers,
        senders: &Senders,
        row: &'a RowSource<'a>,
        factor: Vec<f32>,
        scan: &'a Scan,
        sent: &Sent,
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
        let rows = Axis::receivers(trees.rows, order_of_receivers);
        let weights = weights(senders.area, &order_of_senders);
        let columns = Axis { tree: trees.columns, order: order_of_senders, weights };
        let pairs = Pairs::rectangular(trees.rows, trees.columns);
        let groups = places.iter().map(|&at| groups[at as usize]).collect();
        let row_side = Side { weights: rows.weights.clone(), groups };
        let groups = columns.order.iter().map(|&sender| scan.sender_group[sender as usize]).collect();
        let column_side = Side { weights: columns.weights.clone(), groups };
        let of_place = |&sender: &u32| {
            let (sent, factor) = (&sent.values[sender as usize * sent.count..][..sent.count], factor[sender as usize]);
            sent.iter().map(move |sent| sent / factor)
        };
        let mut light = vec![0.0; sent.count];
        for received in scan.received[0].chunks(sent.count) {
            light.iter_mut().zip(received).for_each(|(light, y)| *light += y * y);
        }
        Packer {
            row,
            pairs,
            row_clusters: Clusters::new(row_side, trees.rows, pairs.first),
            column_clusters: Clusters::new(column_side, trees.columns, pairs.first),
            sent: columns.order.iter().flat_map(of_place).collect(),
            rows,
            columns,
            factor,
            place,
            lights: sent.count,
            unit: unit(scan.largest),
            scan,
            light,
            progress,
        }
    }

    /// Number of parts.
    fn count(&self) -> usize {
        self.rows.tree.count(self.pairs.first)
    }

    fn places(&self, part: usize) -> Range<usize> {
        self.rows.tree.range(self.pairs.first, part)
    }

    /// Error of light, mean over probes, if all rows are like those of `parts`.
    fn error<'p>(&self, parts: impl Iterator<Item = (usize, &'p Part)>) -> f64 {
        let (mut rows, mut squares) = (0, vec![0.0; self.lights]);
        for (number, part) in parts {
            rows += self.places(number).len();
            squares.iter_mut().zip(&part.squares).for_each(|(sum, own)| *sum += own);
        }
        let times = self.rows.tree.n as f64 / rows.max(1) as f64;
        let shares = squares.iter().zip(&self.light).filter(|(_, light)| **light > 0.0);
        shares.map(|(square, light)| (times * square / light).sqrt()).sum::<f64>() / self.lights as f64
    }

    /// The rows, so that light is as good as wanted; the error of that; how often a part was packed, on average.
    pub fn run(&self, wanted: f64) -> (Parts, f64, f64) {
        let count = self.count();
        let mut made = Made { parts: (0..count).map(|_| None).collect(), packed: 0 };
        if count > 0 {
            // Any number of the first of them is spread evenly over all.
            let mut turns: Vec<usize> = (0..count).collect();
            let turn = |&part: &usize| (part as f64 * GOLDEN).fract();
            turns.sort_by(|a, b| turn(a).total_cmp(&turn(b)));
            let (sample, others) = turns.split_at(count.min(SAMPLE));
            self.find_price(&mut made, sample, wanted);
            let (batch, target) = (count.div_ceil(BATCHES), TARGET * wanted);
            others.chunks(batch).for_each(|batch| self.pack_next(&mut made, batch, target));
            for batch in turns.chunks(batch).cycle().take(2 * BATCHES) {
                if self.state(&made).1 <= wanted {
                    break;
                }
                self.pack_better(&mut made, batch, target);
            }
        }
        let error = self.state(&made).1;
        let blocks = made.parts.into_iter().flatten().flat_map(|part| part.blocks).collect();
        let plane = Plane { unit: self.unit, colour: [1.0; 3], blocks };
        let columns = self.columns.clone();
        let parts = Parts { channels: 1, columns, receivers: Some(self.rows.clone()), planes: vec![plane] };
        (parts, error, made.packed as f64 / count.max(1) as f64)
    }

    /// Packs some parts until their light is as good as wanted.
    fn find_price(&self, made: &mut Made, sample: &[usize], wanted: f64) {
        let energy = self.scan.energy * (FIRST_AIM * wanted).powi(2);
        let first = (energy / (FIRST_BYTES * self.rows.tree.n as f64)).max(f64::MIN_POSITIVE);
        let search = Search { wanted, most: ROUNDS, ..Search::default() };
        let (round, rounds) = search.run(first, |price| {
            let packed = self.pack(sample, price);
            let error = self.error(sample.iter().copied().zip(&packed));
            let bytes = packed.iter().map(|part| part.bytes).sum::<f64>() as usize;
            Round { error, bytes, matrix: price, packed }
        });
        made.put(sample, round.packed);
        made.packed += (rounds - 1) * sample.len();
    }

    /// Packs parts for the first time: as good as all that are left have to be for the error that is aimed at.
    fn pack_next(&self, made: &mut Made, batch: &[usize], target: f64) {
        let (price, error) = self.state(made);
        let share = made.parts.iter().flatten().count() as f64 / self.count() as f64;
        let left = (target * target - share * error * error) / (1.0 - share);
        let factor = if error > 0.0 { (left / (error * error)).clamp(0.5, 2.0) } else { 1.0 };
        made.put(batch, self.pack(batch, factor * price));
    }

    /// Packs parts again, so much better that the error of all is what is aimed at.
    fn pack_better(&self, made: &mut Made, batch: &[usize], target: f64) {
        let (price, error) = self.state(made);
        let share = batch.len() as f64 / self.count() as f64;
        let excess = (1.0 - (target / error).powi(2)) / share;
        made.put(batch, self.pack(batch, (1.0 - excess).clamp(0.25, 1.0) * price));
    }

    /// The mean price of all parts that are packed, and the error if all rows were like theirs.
    fn state(&self, made: &Made) -> (f64, f64) {
        let packed = || made.parts.iter().enumerate().filter_map(|(number, part)| Some((number, part.as_ref()?)));
        let price = packed().map(|(_, part)| part.price).sum::<f64>() / packed().count().max(1) as f64;
        (price, self.error(packed()))
    }

    /// Parts at a price of a byte.
    fn pack(&self, parts: &[usize], price: f64) -> Vec<Part> {
        let (pairs, rows, columns) = (self.pairs, &self.row_clusters, &self.column_clusters);
        let chooser = Chooser { pairs, rows, columns, unit: self.unit, price };
        let largest = self.rows.tree.largest(pairs.first).max(1);
        let at_once = (ENTRIES / (largest * self.factor.len())).max(1);
        let blocks = pairs.columns.count(pairs.first);
        let mut packed = Vec::new();
        for parts in parts.chunks(at_once) {
            let read: Vec<_> = parts.par_iter().map(|&part| self.read(self.places(part))).collect();
            let tasks: Vec<(usize, usize)> =
                (0..parts.len()).flat_map(|at| (0..blocks).map(move |b| (at, b))).collect();
            let choose = |&(at, b): &(usize, usize)| {
                let id = Id { level: pairs.first, a: parts[at], b };
                let [places, columns] = pairs.ranges(id);
                let (entries, rows) = &read[at];
                let rows = Sparse { entries, rows, first: 0 }.within(columns.clone());
                let choice = chooser.choose(id, Sparse { entries, rows: &rows, first: columns.start as u32 });
                let mut received = vec![0.0; places.len() * self.lights];
                chooser.add_light(&choice.blocks, &self.sent, self.lights, places.start, &mut received);
                (choice, received)
            };
            let chosen: Vec<(Choice, Vec<f64>)> = tasks.par_iter().map(choose).collect();
            let mut chosen = chosen.into_iter();
            for &part in parts {
                packed.push(self.part(part, price, chosen.by_ref().take(blocks)));
                self.progress.advance(1);
            }
        }
        packed
    }

    /// A part of its blocks, and what its rows receive from each.
    fn part(&self, part: usize, price: f64, chosen: impl Iterator<Item = (Choice, Vec<f64>)>) -> Part {
        let places = self.places(part);
        let mut found = vec![0.0; places.len() * self.lights];
        let mut part = Part { price, blocks: Vec::new(), bytes: 0.0, squares: vec![0.0; self.lights] };
        for (choice, received) in chosen {
            part.bytes += choice.bytes;
            part.blocks.extend(choice.blocks);
            found.iter_mut().zip(received).for_each(|(sum, y)| *sum += y);
        }
        for (found, &receiver) in found.chunks(self.lights).zip(&self.rows.order[places]) {
            let exact = &self.scan.received[0][receiver as usize * self.lights..][..self.lights];
            for ((square, found), exact) in part.squares.iter_mut().zip(found).zip(exact) {
                *square += (found - exact).powi(2);
            }
        }
        part
    }

    /// The rows at some places as they are stored, and where each starts and ends.
    fn read(&self, places: Range<usize>) -> (Entries, Vec<[u32; 2]>) {
        let (mut entries, mut rows) = (Entries::default(), Vec::with_capacity(places.len()));
        let mut row = Row::new();
        for &receiver in &self.rows.order[places] {
            read_row(self.row, receiver as usize, &mut row);
            row.retain(|entry| entry.1 > 0.0);
            for (sender, weight) in &mut row {
                (*sender, *weight) = (self.place[*sender as usize], self.factor[*sender as usize] * *weight);
            }
            row.sort_unstable_by_key(|entry| entry.0);
            let start = entries.column.len() as u32;
            entries.column.extend(row.iter().map(|entry| entry.0));
            entries.value.extend(row.iter().map(|entry| entry.1));
            rows.push([start, entries.column.len() as u32]);
        }
        (entries, rows)
    }
}
