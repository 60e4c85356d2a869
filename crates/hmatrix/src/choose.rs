//! What rows are cut into at a known price of a byte.
//!
//! As in `plan.rs` a block is what costs least error² + λ · bytes. There all that a block could be is kept, to be asked at
//! any price; here the price is known, so that most of it need not be looked at: what cannot win by its energy, or against
//! the blocks that it splits into. Rows are sparse, and stay it.

use half::f16;

use crate::{
    block::{Block, MEAN_BYTES, TRIPLE_BYTES},
    cluster::Tree,
    pairs::{Id, Pairs},
    plan::Side,
    residual::{Residual, Sparse},
    small::dot,
    stream::HEAVIEST,
    stretch::Stretch,
    tile::{self, Tile},
    triple::{self, Coded},
};

/// Most triples of a block.
const RANK: usize = 16;
/// Bytes of a block that is nothing, and of the one that splits into others.
const BARE: f64 = 1.0;
/// Bytes of a tile besides its codes and what stands apart.
const TILE_BYTES: f64 = 5.0;

/// A cluster of rows or of columns.
struct Cluster {
    stretch: Stretch,
    /// Its group, if it has one alone.
    group: Option<u32>,
}

/// Rows or columns, and the clusters of all levels of blocks.
pub struct Clusters {
    side: Side,
    first: u32,
    levels: Vec<Vec<Cluster>>,
}

impl Clusters {
    /// Of the levels of `tree` from `first` on.
    pub fn new(side: Side, tree: Tree, first: u32) -> Clusters {
        let cluster = |level: u32, index: usize| {
            let places = tree.range(level, index);
            let groups = &side.groups[places.clone()];
            let group = groups.iter().all(|group| *group == groups[0]).then(|| groups[0]);
            Cluster { stretch: Stretch::new(&side.weights[places]), group }
        };
        let of_level = |level| (0..tree.count(level)).map(|index| cluster(level, index)).collect();
        let levels = (first..=tree.depth).map(of_level).collect();
        Clusters { side, first, levels }
    }

    fn cluster(&self, level: u32, index: usize) -> &Cluster {
        &self.levels[(level - self.first) as usize][index]
    }
}

/// What a block is, and all below it.
#[derive(Default)]
pub struct Choice {
    /// Error².
    error: f64,
    pub bytes: f64,
    /// A split block before those that it splits into.
    pub blocks: Vec<(Id, Block)>,
}

impl Choice {
    fn cost(&self, price: f64) -> f64 {
        self.error + price * self.bytes
    }
}

/// What triples leave, with the mean.
struct Ended {
    error: f64,
    bytes: f64,
    mean: f16,
}

impl Ended {
    fn choice(self, id: Id, triples: Vec<Coded>) -> Choice {
        let Ended { error, bytes, mean } = self;
        Choice { error, bytes, blocks: vec![(id, Block::LowRank { mean, triples })] }
    }
}

/// Chooses at a price.
pub struct Chooser<'a> {
    pub pairs: Pairs,
    pub rows: &'a Clusters,
    pub columns: &'a Clusters,
    pub unit: f32,
    /// Of a byte.
    pub price: f64,
}

/// A block with the norm of its errors.
#[derive(Clone, Copy)]
struct Normed<'a> {
    id: Id,
    block: Sparse<'a>,
    sides: [&'a Stretch; 2],
    /// Whether all is of one group; else a mean would be light from one group to another.
    has_mean: bool,
}

/// What can be said of a block before any search.
struct Sums {
    /// Square of the stretched block.
    energy: f64,
    /// wᵀ B w.
    mean: f64,
    /// B w.
    widened: Vec<f64>,
}

impl Normed<'_> {
    fn sums(&self) -> Sums {
        let [left, right] = self.sides;
        let mut widened = vec![0.0; left.along.len()];
        self.block.times(&right.along, &mut widened);
        let mut high = vec![0.0; right.along.len()];
        self.block.transposed(&left.along, &mut high);
        let square: f64 = (0..widened.len()).flat_map(|row| self.block.row(row)).map(|(_, v)| v * v).sum();
        let mean = dot(&widened, &left.along);
        let [l, r] = [left, right].map(|side| side.factor().powi(2) - 1.0);
        let energy = square + r * dot(&widened, &widened) + l * dot(&high, &high) + l * r * mean * mean;
        Sums { energy, mean, widened }
    }
}

impl Chooser<'_> {
    /// The cheapest that a block can be, alone or split.
    pub fn choose(&self, id: Id, block: Sparse) -> Choice {
        if block.is_empty() {
            return Ended { error: 0.0, bytes: BARE, mean: f16::ZERO }.choice(id, Vec::new());
        }
        let [rows, columns] = [self.rows.cluster(id.level, id.a), self.columns.cluster(id.level, id.b)];
        let has_mean = rows.group.is_some() && rows.group == columns.group;
        let flat;
        let sides = match has_mean {
            true => [&rows.stretch, &columns.stretch],
            false => {
                flat = [rows.stretch.flat(), columns.stretch.flat()];
                [&flat[0], &flat[1]]
            }
        };
        let normed = Normed { id, block, sides, has_mean };
        let sums = normed.sums();
        let mut best = self.ended(&normed, sums.energy, BARE, sums.mean).choice(id, Vec::new());
        // What is worth less than the bytes of a mean is worth nothing else.
        if sums.energy > self.price * MEAN_BYTES {
            for alternative in [Self::split, Self::low_rank, Self::tile] {
                if let Some(cheaper) = alternative(self, &normed, &sums, best.cost(self.price)) {
                    best = cheaper;
                }
            }
        }
        best
    }

    /// The blocks that a block splits into, if they cost less than `most`.
    fn split(&self, normed: &Normed, _: &Sums, most: f64) -> Option<Choice> {
        let Normed { id, block, .. } = *normed;
        if self.pairs.is_leaf(id) || most <= self.price * 5.0 * BARE {
            return None;
        }
        let middle = self.pairs.ranges(Id { level: id.level + 1, a: 2 * id.a, b: 2 * id.b });
        let quarters = block.quarters(middle[0].len(), middle[1].end as u32);
        let mut split = Choice { error: 0.0, bytes: BARE, blocks: vec![(id, Block::Split)] };
        for child in self.pairs.children(id) {
            let below = self.choose(child, quarters.block(block, child.a % 2, child.b % 2));
            split.error += below.error;
            split.bytes += below.bytes;
            split.blocks.extend(below.blocks);
            if split.cost(self.price) >= most {
                return None;
            }
        }
        Some(split)
    }

    /// Triples as long as they are worth their bytes, if they cost less than `most`.
    fn low_rank(&self, normed: &Normed, sums: &Sums, most: f64) -> Option<Choice> {
        let price = self.price;
        let codes = self.pairs.shape(normed.id).codes() as f64;
        let size = triple::BITS.map(|bits| codes * f64::from(bits) / 8.0 + TRIPLE_BYTES);
        if most <= price * (BARE + size[0]) || sums.energy <= price * size[0] {
            return None;
        }
        let mut residual = Residual::new(normed.block, normed.sides, &sums.widened, self.unit);
        let (mut error, mut bytes, mut mean) = (sums.energy, BARE, sums.mean);
        let (mut triples, mut best, mut least) = (Vec::new(), None, most);
        for _ in 0..RANK {
            let Some(found) = residual.take(price, size) else { break };
            error = (error - found.gain).max(0.0);
            bytes += size[found.coded.bits];
            mean -= found.mean;
            triples.push(found.coded);
            let ended = self.ended(normed, error, bytes, mean);
            if ended.error + price * ended.bytes < least {
                least = ended.error + price * ended.bytes;
                best = Some((triples.len(), ended));
            }
            // No later triple does more than this one, so what is left takes at least so many of them.
            if price * bytes + error * (price * size[0] / found.most).min(1.0) >= least {
                break;
            }
        }
        let (length, ended) = best?;
        triples.truncate(length);
        Some(ended.choice(normed.id, triples))
    }

    /// Triples with the mean that they leave, if that is worth its bytes.
    fn ended(&self, normed: &Normed, error: f64, bytes: f64, mean: f64) -> Ended {
        let [left, right] = normed.sides;
        let square = (left.factor() * right.factor() * mean).powi(2);
        let mean = mean * f64::from(HEAVIEST).powi(2) / (left.length * right.length * f64::from(self.unit));
        let mean = f16::from_f64(mean);
        if normed.has_mean && square > self.price * MEAN_BYTES && mean.is_finite() {
            return Ended { error: (error - square).max(0.0), bytes: bytes + MEAN_BYTES, mean };
        }
        Ended { error, bytes, mean: f16::ZERO }
    }

    /// The cheapest tile, if it costs less than `most`.
    fn tile(&self, normed: &Normed, _: &Sums, most: f64) -> Option<Choice> {
        let (price, shape) = (self.price, self.pairs.shape(normed.id));
        let least = |bits: u32| price * (TILE_BYTES + (shape.entries() as f64 * f64::from(bits) / 8.0));
        let fits = self.pairs.is_leaf(normed.id) && shape.entries() <= tile::MOST;
        if !fits || most <= least(tile::BITS[0]) {
            return None;
        }
        let [left, right] = normed.sides;
        let columns = right.along.len();
        let mut entries = vec![0.0; shape.entries()];
        for row in 0..left.along.len() {
            normed.block.row(row).for_each(|(column, value)| entries[row * columns + column] = value as f32);
        }
        let (mut cost, mut best) = (most, None);
        for bits in tile::BITS {
            if cost <= least(bits) {
                break;
            }
            let tile = Tile::new(&entries, self.unit, bits);
            let decoded = tile.entries(self.unit);
            let mut error: Vec<f64> =
                entries.iter().zip(&decoded).map(|(e, d)| f64::from(*e) - f64::from(*d)).collect();
            left.both(right, &mut error);
            let (error, bytes) = (dot(&error, &error), BARE + tile.bytes() as f64);
            if error + price * bytes < cost {
                cost = error + price * bytes;
                best = Some(Choice { error, bytes, blocks: vec![(normed.id, Block::Tile(tile))] });
            }
        }
        best
    }

    /// Adds what chosen blocks make of light: `sent` is that of all columns, `lights` of each, to `received`, that of the rows
    /// from place `first` on.
    pub fn add_light(&self, blocks: &[(Id, Block)], sent: &[f32], lights: usize, first: usize, received: &mut [f64]) {
        let unit = f64::from(self.unit);
        let mut carried = vec![0.0; lights];
        for (id, block) in blocks {
            let [rows, columns] = self.pairs.ranges(*id);
            let received = &mut received[(rows.start - first) * lights..][..rows.len() * lights];
            let sent = &sent[columns.start * lights..columns.end * lights];
            let mut term = |factor: f64, u: &[i8], v: &[i8]| {
                carried.fill(0.0);
                for (sent, &code) in sent.chunks_exact(lights).zip(v).filter(|(_, code)| **code != 0) {
                    let code = factor * f64::from(code);
                    carried.iter_mut().zip(sent).for_each(|(carried, &x)| *carried += code * f64::from(x));
                }
                for (received, &code) in received.chunks_exact_mut(lights).zip(u).filter(|(_, code)| **code != 0) {
                    received.iter_mut().zip(&carried).for_each(|(y, carried)| *y += f64::from(code) * carried);
                }
            };
            match block {
                Block::Split => {}
                Block::LowRank { mean, triples } => {
                    for t in triples {
                        let (u, v) = t.codes.split_at(rows.len());
                        term(f64::from(t.factor(self.unit)), u, v);
                    }
                    if *mean != f16::ZERO {
                        let factor = unit * mean.to_f64() / f64::from(HEAVIEST).powi(2);
                        term(factor, &self.rows.side.weights[rows], &self.columns.side.weights[columns]);
                    }
                }
                Block::Tile(tile) => {
                    let entries = tile.entries(self.unit);
                    let of_rows = received.chunks_exact_mut(lights).zip(entries.chunks_exact(columns.len()));
                    for (received, entries) in of_rows {
                        for (sent, &entry) in sent.chunks_exact(lights).zip(entries).filter(|(_, entry)| **entry != 0.0)
                        {
                            received.iter_mut().zip(sent).for_each(|(y, &x)| *y += f64::from(entry) * f64::from(x));
                        }
                    }
                }
            }
        }
    }
}
