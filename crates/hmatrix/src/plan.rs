//! What every block could be, and which of that is cheapest.
//!
//! Candidates of all blocks of all levels are computed once. At a price λ of a byte a block is what costs least
//! error² + λ · bytes, from the leaves up; as all blocks have the same price, no byte could be moved to where it
//! does more (Shoham and Gersho 1988). Blocks off the diagonal count twice: they stand for their mirror images too.

use half::f16;
use radfile::Progress;
use rayon::prelude::*;

use crate::{
    block::{Block, MEAN_BYTES, MOST_TRIPLES, TRIPLE_BYTES},
    pairs::{Id, Pairs},
    sketch::{Dense, Triple, apart, symmetric_triples, triples},
    small::dot,
    stream::HEAVIEST,
    stretch::Stretch,
    tile::{self, Tile},
    triple::{self, code},
};

/// Most triples that are tried in a block.
const RANK: usize = 16;

/// Rows or columns of a matrix.
#[derive(Clone)]
pub struct Side {
    /// √A of the patch at each place, in codes.
    pub weights: Vec<i8>,
    /// The group of the patch at each place; groups exchange nothing.
    pub groups: Vec<u32>,
}

/// A matrix in the order of clusters, row-major.
pub struct Matrix {
    pub values: Vec<f32>,
    /// What values are stored relative to.
    pub unit: f32,
    pub rows: Side,
    pub columns: Side,
}

impl Matrix {
    fn stretches(&self, pairs: Pairs, id: Id) -> [Stretch; 2] {
        let new = if self.is_of_one_group(pairs, id) { Stretch::new } else { Stretch::none };
        let [rows, columns] = pairs.ranges(id);
        [new(&self.rows.weights[rows]), new(&self.columns.weights[columns])]
    }

    fn groups(&self, pairs: Pairs, id: Id) -> [&[u32]; 2] {
        let [rows, columns] = pairs.ranges(id);
        [&self.rows.groups[rows], &self.columns.groups[columns]]
    }

    /// Whether all patches of rows and columns are of one group.
    fn is_of_one_group(&self, pairs: Pairs, id: Id) -> bool {
        let [rows, columns] = self.groups(pairs, id);
        rows.iter().chain(columns).all(|group| *group == rows[0])
    }

    fn row(&self, pairs: Pairs, id: Id, row: usize) -> &[f32] {
        let [rows, columns] = pairs.ranges(id);
        &self.values[(rows.start + row) * pairs.columns.n..][columns]
    }

    /// What a tile of the block holds.
    fn entries(&self, pairs: Pairs, id: Id) -> Vec<f32> {
        let diagonal = pairs.is_diagonal(id);
        let stored = |i: usize| if diagonal { &self.row(pairs, id, i)[..=i] } else { self.row(pairs, id, i) };
        (0..pairs.ranges(id)[0].len()).flat_map(stored).copied().collect()
    }
}

/// What to store values relative to, of which this is the largest magnitude. Scales are f16: this leaves room above for
/// triples that cancel and nine decimal places below.
pub fn unit(largest: f32) -> f32 {
    if largest > 0.0 { (largest / 1024.0).max(f32::MIN_POSITIVE) } else { 1.0 }
}

/// How often a block stands in the matrix.
fn times(pairs: Pairs, id: Id) -> f64 {
    if pairs.is_mirrored(id) { 2.0 } else { 1.0 }
}

/// What a block could be.
struct Candidate {
    /// Sum of squares of its entries.
    energy: f64,
    /// Its mean: wᵀ B w, w of unit length.
    mean: f64,
    /// By how much a mean grows when it is stretched.
    stretch: f64,
    triples: Vec<(Triple, [Quality; triple::BITS.len()])>,
    /// Error² and bytes of every tile, if the block is of leaves.
    tiles: Vec<(f64, f64)>,
}

/// What a triple does to its block when it is stored in some bits.
#[derive(Clone, Copy)]
struct Quality {
    /// By how much it lessens the error².
    gain: f64,
    /// Its part of the mean.
    mean: f64,
}

/// What a block is.
#[derive(Clone, Debug)]
enum Choice {
    /// Mean, and number and bits of every triple that is kept.
    LowRank(f64, Vec<(usize, usize)>),
    /// Index of the tile's bits.
    Tile(usize),
    Split,
}

struct Decision {
    error: f64,
    bytes: f64,
    choice: Choice,
}

impl Decision {
    fn cost(&self, price: f64) -> f64 {
        self.error + price * self.bytes
    }
}

/// The choice of every block, levels from `first_level` on.
pub struct Decisions(Vec<Vec<Decision>>);

impl Decisions {
    /// Error² of the whole matrix, mirror images included.
    pub fn error(&self) -> f64 {
        self.0[0].iter().map(|d| d.error).sum()
    }
}

/// Candidates of every block.
pub struct Plan {
    pairs: Pairs,
    matrix: Matrix,
    levels: Vec<Vec<Candidate>>,
}

impl Plan {
    /// Computes them; `tiles` need entries that are not negative.
    pub fn new(mut matrix: Matrix, pairs: Pairs, tiles: bool, seed: u64, progress: &dyn Progress) -> Plan {
        let levels = pairs.first..=pairs.columns.depth;
        let blocks: usize = levels.clone().map(|level| pairs.of_level(level).count()).sum();
        progress.begin("approximating blocks", blocks as u64);
        let of_level = |level| {
            let ids: Vec<Id> = pairs.of_level(level).collect();
            let candidate = |id| {
                let candidate = Candidate::new(&matrix, pairs, id, tiles, seed);
                progress.advance(1);
                candidate
            };
            ids.into_par_iter().map(candidate).collect()
        };
        let levels = levels.map(of_level).collect();
        if !tiles {
            // Only tiles look at entries again.
            matrix.values = Vec::new();
        }
        Plan { pairs, matrix, levels }
    }

    /// What values are stored relative to.
    pub fn unit(&self) -> f32 {
        self.matrix.unit
    }

    /// Sum of squares of the matrix.
    pub fn energy(&self) -> f64 {
        let ids = self.pairs.of_level(self.pairs.first);
        ids.zip(&self.levels[0]).map(|(id, candidate)| times(self.pairs, id) * candidate.energy).sum()
    }

    /// The cheapest choice of every block at a price of a byte.
    pub fn decide(&self, price: f64) -> Decisions {
        let pairs = self.pairs;
        let mut decided: Vec<Vec<Decision>> = Vec::new();
        for (above, candidates) in self.levels.iter().enumerate().rev() {
            let below = decided.last();
            let ids: Vec<Id> = pairs.of_level(pairs.first + above as u32).collect();
            let decide = |(id, candidate): (Id, &Candidate)| {
                let own = candidate.cheapest(id, pairs, price);
                let Some(below) = below else { return own };
                let mut split = Decision { error: 0.0, bytes: 1.0, choice: Choice::Split };
                for child in pairs.children(id) {
                    split.error += below[pairs.place(child)].error;
                    split.bytes += below[pairs.place(child)].bytes;
                }
                if split.cost(price) < own.cost(price) { split } else { own }
            };
            decided.push(ids.into_par_iter().zip(candidates).map(decide).collect());
        }
        decided.reverse();
        Decisions(decided)
    }

    /// The chosen blocks as they are written: a split one before those that it splits into.
    pub fn blocks(&self, decisions: &Decisions) -> Vec<(Id, Block)> {
        let pairs = self.pairs;
        let mut blocks = Vec::new();
        let mut open: Vec<Id> = pairs.of_level(pairs.first).collect();
        open.reverse();
        while let Some(id) = open.pop() {
            let (level, place) = ((id.level - pairs.first) as usize, pairs.place(id));
            let candidate = &self.levels[level][place];
            let block = match &decisions.0[level][place].choice {
                Choice::LowRank(mean, kept) => {
                    let sides = self.matrix.stretches(pairs, id);
                    let lengths = sides[0].length * sides[1].length;
                    let mean = mean * f64::from(HEAVIEST).powi(2) / (lengths * f64::from(self.unit()));
                    let mean = f16::from_f64(mean);
                    let mean = if mean.is_finite() { mean } else { f16::ZERO };
                    let coded =
                        kept.iter().map(|&(at, bits)| code(&candidate.triples[at].0, self.unit(), bits, &sides).0);
                    Block::LowRank { mean, triples: coded.collect() }
                }
                Choice::Tile(bits) => {
                    Block::Tile(Tile::new(&self.matrix.entries(pairs, id), self.unit(), tile::BITS[*bits]))
                }
                Choice::Split => {
                    let children: Vec<Id> = pairs.children(id).collect();
                    open.extend(children.into_iter().rev());
                    Block::Split
                }
            };
            blocks.push((id, block));
        }
        blocks
    }
}

impl Candidate {
    fn new(matrix: &Matrix, pairs: Pairs, id: Id, with_tiles: bool, seed: u64) -> Candidate {
        let sides = matrix.stretches(pairs, id);
        let [left, right] = &sides;
        let (rows, columns) = (left.along.len(), right.along.len());
        let exact: Vec<f64> = (0..rows).flat_map(|i| matrix.row(pairs, id, i)).map(|&v| f64::from(v)).collect();
        let mut stretched = exact.clone();
        left.both(right, &mut stretched);
        let block = Dense { values: &stretched, rows, columns };
        let energy = dot(&stretched, &stretched);
        let widened = |w: &f64, i: usize| w * dot(&exact[i * columns..][..columns], &right.along);
        let mean = left.along.iter().enumerate().map(|(i, w)| widened(w, i)).sum();
        let (leaf, diagonal, shape) = (pairs.is_leaf(id), pairs.is_diagonal(id), pairs.shape(id));
        let fits_tile = shape.entries() <= tile::MOST;
        let approximate = |block: Dense| match (leaf, diagonal) {
            // Past a third of the rank a tile is cheaper.
            (true, true) => symmetric_triples(block, RANK),
            (true, false) if fits_tile => triples(block, RANK.min(block.rows.div_ceil(2)), seed),
            (false, true) => Vec::new(),
            (_, false) => triples(block, RANK, seed),
        };
        let one_group = matrix.is_of_one_group(pairs, id);
        let found = match energy == 0.0 {
            true => Vec::new(),
            false if one_group => approximate(block),
            false => apart(block, matrix.groups(pairs, id), RANK, approximate),
        };
        let quality = |t: &Triple, bits: usize| {
            let (coded, error) = code(t, matrix.unit, bits, &sides);
            let along = |codes: &[i8], w: &[f64]| codes.iter().zip(w).map(|(&c, w)| f64::from(c) * w).sum::<f64>();
            let columns = if diagonal { &coded.codes[..] } else { &coded.codes[block.rows..] };
            let mean =
                f64::from(coded.factor(matrix.unit)) * along(&coded.codes, &left.along) * along(columns, &right.along);
            Quality { gain: t.sigma.powi(2) - error, mean }
        };
        let qualities = |t: Triple| {
            let qualities = std::array::from_fn(|bits| quality(&t, bits));
            (t, qualities)
        };
        let triples = found.into_iter().take(MOST_TRIPLES).map(qualities).collect();
        let mut tiles = Vec::new();
        if with_tiles && leaf && fits_tile && energy > 0.0 {
            let entries = matrix.entries(pairs, id);
            tiles.extend(tile::BITS.map(|bits| {
                let tile = Tile::new(&entries, matrix.unit, bits);
                let decoded = tile.entries(matrix.unit);
                let at = |i, j| f64::from(decoded[shape.entry(i, j)]);
                let mut error: Vec<f64> =
                    exact.iter().enumerate().map(|(k, x)| x - at(k / columns, k % columns)).collect();
                left.both(right, &mut error);
                (dot(&error, &error), tile.bytes() as f64)
            }));
        }
        // A mean would be light from one group to another.
        let (mean, stretch) = if one_group { (mean, left.factor() * right.factor()) } else { (0.0, 0.0) };
        Candidate { energy, mean, stretch, triples, tiles }
    }

    /// The cheapest of all that is no split.
    fn cheapest(&self, id: Id, pairs: Pairs, price: f64) -> Decision {
        let times = times(pairs, id);
        let codes = pairs.shape(id).codes() as f64;
        // With the mean that triples leave, if that is worth its bytes.
        let finished = |error: f64, bytes: f64, mean: f64| {
            let square = (self.stretch * mean).powi(2);
            let worth = times * square > price * MEAN_BYTES;
            let (error, bytes, mean) =
                if worth { (error - square, bytes + MEAN_BYTES, mean) } else { (error, bytes, 0.0) };
            (Decision { error: times * error.max(0.0), bytes, choice: Choice::Split }, mean)
        };
        let mut kept = Vec::new();
        // Without triples first; then every one that is worth its bytes, and the best of all lengths.
        let (mut error, mut bytes, mut mean) = (self.energy, 1.0, self.mean);
        let mut best = (finished(error, bytes, mean), 0);
        for (at, (_, qualities)) in self.triples.iter().enumerate() {
            let of_bits = |bits: usize| {
                let size = codes * f64::from(triple::BITS[bits]) / 8.0 + TRIPLE_BYTES;
                (times * qualities[bits].gain - price * size, size, bits)
            };
            let found = (0..triple::BITS.len()).map(of_bits).max_by(|x, y| x.0.total_cmp(&y.0));
            if let Some((_, size, bits)) = found.filter(|found| found.0 > 0.0) {
                error -= qualities[bits].gain;
                bytes += size;
                mean -= qualities[bits].mean;
                kept.push((at, bits));
                let finished = finished(error, bytes, mean);
                if finished.0.cost(price) < best.0.0.cost(price) {
                    best = (finished, kept.len());
                }
            }
        }
        let ((mut best, mean), length) = best;
        kept.truncate(length);
        best.choice = Choice::LowRank(mean, kept);
        for (bits, &(error, bytes)) in self.tiles.iter().enumerate() {
            let tile = Decision { error: times * error, bytes: bytes + 1.0, choice: Choice::Tile(bits) };
            if tile.cost(price) < best.cost(price) {
                best = tile;
            }
        }
        best
    }
}
