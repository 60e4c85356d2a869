//! The operator as it is multiplied with.
//!
//! All triples that touch a cluster stand side by side as one matrix C of codes, patches × triples. So the product
//! is three steps: t = Cᵀ x in every cluster; every triple's two ends exchange what they gathered, times its scale;
//! y = C t in every cluster, and tiles. Triples of blocks above and below the diagonal are the same two ends, so
//! the operator is symmetric to the last bit of its codes. Triples of luma and of colour differ in their scales
//! only, which are three numbers. The first lane of every cluster is its weights, whose means go to many others.
//!
//! Every number is summed by one task in a fixed order: more threads change who computes it, never how.
//!
//! A rectangle is the same with panels that only take, those of clusters of receivers, and panels that only gather, those
//! of clusters of senders.

use std::{collections::BTreeMap, ops::Range};

use half::f16;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use crate::{
    Result,
    block::{Block, Shape},
    cluster::Tree,
    kernels::{LANES, Lanes, ROWS, across, gather, near, scatter},
    pairs::{Id, Pairs},
    stream::{Axis, HEAVIEST, Parts, Plane},
    tile::Tile,
    triple::Coded,
};

/// Panels that a task handles.
const PANELS: usize = 16;
/// Receivers that a task handles at least where there is little to do for each.
const RECEIVERS: usize = 4096;

/// A symmetric operator K of one channel or three, compressed; within a [`crate::Rectangle`] a rectangular one.
pub struct HMatrix {
    bytes: Vec<u8>,
    channels: usize,
    pairs: Pairs,
    /// Patch at each place.
    order: Vec<u32>,
    /// What its light is multiplied by first.
    scale: Vec<f32>,
    /// Where in the padded result each receiver stands; beyond it what receives nothing.
    slot: Vec<u32>,
    /// [`LANES`] triples at one patch each; patches of a panel stand together, panels of a cluster follow each other.
    codes: Vec<[i8; LANES]>,
    /// What is gathered in the first step.
    panels: Vec<Panel>,
    /// The other end of every lane of each panel of receivers, which in a symmetric operator are all.
    partner: Vec<[u32; LANES]>,
    /// The scale of its triple in each colour.
    factor: Vec<Lanes>,
    /// Where each panel's means start in `means`, one more at the end; only first panels of clusters have any.
    mean_start: Vec<u32>,
    /// First panel of the other cluster, and the mean of the block in each colour.
    means: Vec<(u32, [f32; 3])>,
    /// Clusters of receivers of each level from the first on.
    clusters: Vec<Vec<Cluster>>,
    /// Tiles of each leaf of receivers.
    near: Vec<Near>,
}

/// Codes of [`LANES`] triples at some patches.
#[derive(Clone, Copy)]
pub struct Panel {
    /// Where its codes start.
    pub codes: usize,
    /// First place.
    pub place: usize,
    /// Number of places.
    pub len: usize,
}

/// Panels of a cluster.
#[derive(Clone, Copy, Default)]
pub struct Cluster {
    /// First panel.
    pub first: usize,
    /// Number of panels.
    pub count: usize,
    /// Where the codes of the first panel start; each panel has `len`.
    pub codes: usize,
    /// First place.
    pub place: usize,
    /// Number of places.
    pub len: usize,
}

/// Tiles whose rows are a leaf, mirror images included. An entry is the square of its code times its column's scale.
#[derive(Default)]
pub struct Near {
    /// Place and scale of each column.
    pub senders: Vec<(u32, f32)>,
    /// [`ROWS`] rows of every column, then the next rows.
    pub codes: Vec<[u8; ROWS]>,
    /// Row, place of the sender and value of entries that stand apart.
    pub apart: Vec<(u32, u32, f32)>,
}

/// The arrays of [`HMatrix::multiply`], for a product elsewhere. Clusters and tiles count places, not patches.
pub struct Layout<'a> {
    /// Patch or sender at each place.
    pub order: &'a [u32],
    /// What the light of each place is multiplied by before anything else; 1 in symmetric operators.
    pub scale: &'a [f32],
    /// The patch or receiver of each row, those of the leaves first; behind them the ones that receive nothing.
    pub receivers: Vec<u32>,
    /// Codes of [`LANES`] triples at one place each.
    pub codes: &'a [[i8; LANES]],
    /// What is gathered: t = Cᵀ x.
    pub panels: &'a [Panel],
    /// The lane whose t each lane of a panel takes, counted through all panels.
    pub partner: &'a [[u32; LANES]],
    /// What that is multiplied by, in red, green and blue; 0 for lanes that are not used.
    pub factor: &'a [Lanes],
    /// Where the means of each panel start, one more at the end.
    pub mean_start: &'a [u32],
    /// First lanes that the first lane of a panel takes as well: their panel and factors.
    pub means: &'a [(u32, [f32; 3])],
    /// The rows of the result.
    pub leaves: Vec<Leaf<'a>>,
}

/// What adds up to a leaf's rows.
pub struct Leaf<'a> {
    /// Places, of which the first leaf has most.
    pub rows: Range<usize>,
    /// The clusters that it lies in, from the largest to itself.
    pub above: Vec<Cluster>,
    /// Its tiles.
    pub near: &'a Near,
}

/// Memory of a product, kept from frame to frame.
pub struct Workspace {
    x: Vec<[f32; 3]>,
    gathered: Vec<Lanes>,
    exchanged: Vec<Lanes>,
    out: Vec<[f32; 3]>,
}

impl HMatrix {
    /// Reads what [`HMatrix::to_bytes`] wrote.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Short`], [`crate::Error::Damaged`]. Memory stays within about a hundred times the bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<HMatrix> {
        Ok(HMatrix::new(&Parts::read(bytes, false)?, bytes.to_vec()))
    }

    /// The packed operator.
    pub fn to_bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Number of patches.
    pub fn patches(&self) -> usize {
        self.order.len()
    }

    /// Number of rows: patches, unless it is a rectangle.
    pub(crate) fn receivers(&self) -> usize {
        self.slot.len()
    }

    /// 1 or 3.
    pub fn channels(&self) -> usize {
        self.channels
    }

    pub(crate) fn new(parts: &Parts, bytes: Vec<u8>) -> HMatrix {
        let (pairs, rows) = (parts.pairs(), parts.rows());
        let width = row_width(rows.tree);
        let mut slot = vec![u32::MAX; rows.order.len()];
        for leaf in 0..rows.tree.count(rows.tree.depth) {
            for (row, place) in rows.tree.range(rows.tree.depth, leaf).enumerate() {
                slot[rows.order[place] as usize] = (leaf * width + row) as u32;
            }
        }
        // Rectangles store what is sent by a patch of the largest weight; symmetric operators are sent √A B.
        let scale = |&weight: &i8| if parts.receivers.is_some() { f32::from(weight) / HEAVIEST } else { 1.0 };
        let mut made = HMatrix {
            bytes,
            channels: parts.channels,
            pairs,
            order: parts.columns.order.clone(),
            scale: parts.columns.weights.iter().map(scale).collect(),
            slot,
            codes: Vec::new(),
            panels: Vec::new(),
            partner: Vec::new(),
            clusters: Vec::new(),
            factor: Vec::new(),
            mean_start: Vec::new(),
            means: Vec::new(),
            near: near_of_leaves(parts),
        };
        let mut ends = made.lay_out_clusters(parts);
        made.fill_triples(parts, &mut ends);
        made.fill_means(parts, &ends);
        made.clusters = ends.swap_remove(0).clusters;
        made
    }

    /// Room for the triples of every cluster, of senders and, if these are others, of receivers before them.
    fn lay_out_clusters(&mut self, parts: &Parts) -> Vec<Ends> {
        let axes: Vec<&Axis> = parts.receivers.iter().chain([&parts.columns]).collect();
        let zero = |axis: &&Axis| {
            let levels = self.pairs.first..=axis.tree.depth;
            levels.map(|level| vec![1; axis.tree.count(level)]).collect::<Vec<Vec<usize>>>()
        };
        let mut counts: Vec<Vec<Vec<usize>>> = axes.iter().map(zero).collect();
        for (id, triples) in parts.planes.iter().flat_map(low_rank) {
            let level = (id.level - self.pairs.first) as usize;
            counts[0][level][id.a] += triples.len();
            if !self.pairs.is_diagonal(*id) {
                counts[axes.len() - 1][level][id.b] += triples.len();
            }
        }
        let mut ends = Vec::new();
        for (axis, counts) in axes.into_iter().zip(counts) {
            // Panels of senders are counted anew, as those of receivers gather nothing.
            self.panels.clear();
            let mut clusters = Vec::new();
            for (level, counts) in (self.pairs.first..).zip(&counts) {
                let of_cluster = |(index, count): (usize, &usize)| {
                    self.add_cluster(axis, axis.tree.range(level, index), count.div_ceil(LANES))
                };
                clusters.push(counts.iter().enumerate().map(of_cluster).collect::<Vec<_>>());
            }
            if ends.is_empty() {
                self.partner = vec![[0; LANES]; self.panels.len()];
                self.factor = vec![[[0.0; LANES]; 3]; self.panels.len()];
            }
            let used = counts.iter().map(|level| vec![1; level.len()]).collect();
            ends.push(Ends { clusters, used });
        }
        ends
    }

    /// Panels of a cluster; the first lane of the first is its weights.
    fn add_cluster(&mut self, axis: &Axis, places: Range<usize>, count: usize) -> Cluster {
        let (place, len) = (places.start, places.len());
        let cluster = Cluster { first: self.panels.len(), count, codes: self.codes.len(), place, len };
        self.panels.extend((0..count).map(|k| Panel { codes: cluster.codes + k * len, place, len }));
        self.codes.resize(cluster.codes + count * len, [0; LANES]);
        self.codes[cluster.codes..].iter_mut().zip(&axis.weights[places]).for_each(|(to, &weight)| to[0] = weight);
        cluster
    }

    fn fill_triples(&mut self, parts: &Parts, ends: &mut [Ends]) {
        let senders = ends.len() - 1;
        for plane in &parts.planes {
            for (id, triples) in low_rank(plane) {
                let level = (id.level - self.pairs.first) as usize;
                for triple in triples {
                    let scale = plane.colour.map(|c| c * triple.factor(plane.unit));
                    let (a, rest) = ends[0].put(level, id.a, &mut self.codes, &triple.codes);
                    let diagonal = self.pairs.is_diagonal(*id);
                    let b = if diagonal { a } else { ends[senders].put(level, id.b, &mut self.codes, rest).0 };
                    let both_ways = if self.pairs.is_mirrored(*id) { 2 } else { 1 };
                    for (own, other) in [(a, b), (b, a)].into_iter().take(both_ways) {
                        let (panel, lane) = (own / LANES, own % LANES);
                        self.partner[panel][lane] = other as u32;
                        (0..3).for_each(|c| self.factor[panel][c][lane] = scale[c]);
                    }
                }
            }
        }
    }

    /// What the first lanes of clusters exchange.
    fn fill_means(&mut self, parts: &Parts, ends: &[Ends]) {
        let senders = &ends[ends.len() - 1];
        let mut found = vec![BTreeMap::<u32, [f32; 3]>::new(); self.factor.len()];
        for plane in &parts.planes {
            for (id, block) in &plane.blocks {
                let Block::LowRank { mean, .. } = block else { continue };
                if *mean == f16::ZERO {
                    continue;
                }
                let scale = plane.unit * mean.to_f32() / (HEAVIEST * HEAVIEST);
                let level = (id.level - self.pairs.first) as usize;
                let (a, b) = (ends[0].clusters[level][id.a].first, senders.clusters[level][id.b].first);
                let both_ways = if self.pairs.is_mirrored(*id) { 2 } else { 1 };
                for (own, other) in [(a, b), (b, a)].into_iter().take(both_ways) {
                    let sum = found[own].entry(other as u32).or_default();
                    *sum = std::array::from_fn(|c| sum[c] + plane.colour[c] * scale);
                }
            }
        }
        self.mean_start.push(0);
        for means in found {
            self.means.extend(means);
            self.mean_start.push(self.means.len() as u32);
        }
    }

    /// Multiplications of a product with one channel.
    pub(crate) fn multiplications(&self) -> usize {
        let near: usize = self.near.iter().map(|near| near.codes.len() * ROWS + near.apart.len()).sum();
        let gathered: usize = self.panels.iter().map(|panel| panel.len).sum();
        let scattered: usize = self.clusters.iter().flatten().map(|c| c.count * c.len).sum();
        (gathered + scattered) * LANES + self.means.len() + near
    }

    /// Memory for [`HMatrix::multiply`].
    pub fn workspace(&self) -> Workspace {
        let zero = [[0.0; LANES]; 3];
        Workspace {
            x: vec![[0.0; 3]; self.order.len()],
            gathered: vec![zero; self.panels.len()],
            exchanged: vec![zero; self.factor.len()],
            out: vec![[0.0; 3]; row_width(self.pairs.rows) * self.near.len()],
        }
    }

    /// y = K x, in the order of patches; `x` and `y` are red, green and blue. Grey operators
    /// treat all three alike. Takes no memory, and gives the same bits on any number of threads.
    ///
    /// # Panics
    ///
    /// If `x`, `y` or the workspace are of another size: a bug in the caller.
    pub fn multiply(&self, x: &[[f32; 3]], y: &mut [[f32; 3]], workspace: &mut Workspace) {
        let Workspace { x: ordered, gathered, exchanged, out } = workspace;
        let n = self.order.len();
        assert_eq!((x.len(), y.len(), ordered.len()), (n, self.slot.len(), n), "one value a patch");
        let panels = (gathered.len(), exchanged.len());
        assert_eq!(panels, (self.panels.len(), self.factor.len()), "the workspace of this operator");
        let sent = self.order.iter().zip(&self.scale);
        ordered.iter_mut().zip(sent).for_each(|(to, (&patch, scale))| *to = x[patch as usize].map(|x| scale * x));
        let (x, arch) = (&ordered[..], Arch::new());
        gathered.par_chunks_mut(PANELS).zip(self.panels.par_chunks(PANELS)).for_each(|(sums, panels)| {
            arch.dispatch(Gathering { codes: &self.codes, panels, x, sums });
        });
        self.exchange(gathered, exchanged);
        let exchanged = &exchanged[..];
        out.par_chunks_mut(row_width(self.pairs.rows)).enumerate().for_each(|(leaf, out)| {
            arch.dispatch(Scattering { matrix: self, leaf, x, exchanged, out });
        });
        let received = |slot: u32| out.get(slot as usize).copied().unwrap_or([0.0; 3]);
        y.par_iter_mut().zip(&self.slot).with_min_len(RECEIVERS).for_each(|(y, &slot)| *y = received(slot));
    }

    /// Every lane takes what the other end of its triple gathered.
    fn exchange(&self, gathered: &[Lanes], exchanged: &mut [Lanes]) {
        exchanged.par_iter_mut().with_min_len(4 * PANELS).enumerate().for_each(|(own, to)| {
            let factor = &self.factor[own];
            for (lane, &from) in self.partner[own].iter().enumerate() {
                let (panel, other) = (from as usize / LANES, from as usize % LANES);
                (0..3).for_each(|c| to[c][lane] = factor[c][lane] * gathered[panel][c][other]);
            }
            let means = &self.means[self.mean_start[own] as usize..self.mean_start[own + 1] as usize];
            for &(other, mean) in means {
                (0..3).for_each(|c| to[c][0] += mean[c] * gathered[other as usize][c][0]);
            }
        });
    }

    /// The rows of a leaf.
    #[inline(always)]
    fn leaf(&self, leaf: usize, x: &[[f32; 3]], exchanged: &[Lanes], out: &mut [[f32; 3]]) {
        let rows = self.rows_of(leaf);
        let depth = self.clusters.len() - 1;
        for (place, out) in rows.clone().zip(out.iter_mut()) {
            let mut sum = [[0.0; LANES]; 3];
            let above = self.clusters.iter().enumerate().map(|(level, all)| &all[leaf >> (depth - level)]);
            for c in above {
                let codes = &self.codes[c.codes + place - c.place..c.codes + c.count * c.len];
                scatter(&mut sum, codes, c.len, &exchanged[c.first..][..c.count]);
            }
            *out = across(&sum);
        }
        let tiles = &self.near[leaf];
        let columns = tiles.senders.len();
        for (k, out) in out.chunks_mut(ROWS).enumerate() {
            let Some(codes) = tiles.codes.get(k * columns..(k + 1) * columns) else { break };
            let sum = near(codes, &tiles.senders, x);
            for (row, out) in out.iter_mut().enumerate() {
                (0..3).for_each(|c| out[c] += sum[c][row]);
            }
        }
        for &(row, sender, value) in &tiles.apart {
            (0..3).for_each(|c| out[row as usize][c] += value * x[sender as usize][c]);
        }
    }

    fn rows_of(&self, leaf: usize) -> Range<usize> {
        self.pairs.rows.range(self.pairs.rows.depth, leaf)
    }

    /// The patch or receiver of each row, then those that are in no leaf.
    fn receiver_of_rows(&self) -> Vec<u32> {
        let (tree, width) = (self.pairs.rows, row_width(self.pairs.rows));
        let mut padded = vec![u32::MAX; width * tree.count(tree.depth)];
        let mut others = Vec::new();
        for (receiver, &slot) in (0..).zip(&self.slot) {
            match padded.get_mut(slot as usize) {
                Some(own) => *own = receiver,
                None => others.push(receiver),
            }
        }
        padded.into_iter().filter(|receiver| *receiver != u32::MAX).chain(others).collect()
    }

    /// What the product reads.
    pub fn layout(&self) -> Layout<'_> {
        let depth = self.clusters.len() - 1;
        let leaf = |(leaf, near)| Leaf {
            rows: self.rows_of(leaf),
            above: self.clusters.iter().enumerate().map(|(level, all)| all[leaf >> (depth - level)]).collect(),
            near,
        };
        Layout {
            order: &self.order,
            scale: &self.scale,
            receivers: self.receiver_of_rows(),
            codes: &self.codes,
            panels: &self.panels,
            partner: &self.partner,
            factor: &self.factor,
            mean_start: &self.mean_start,
            means: &self.means,
            leaves: self.near.iter().enumerate().map(leaf).collect(),
        }
    }

    /// K of a channel as a dense matrix in the order of patches, row-major, from the packed bytes: what judges
    /// [`HMatrix::multiply`]. Takes 8 n² bytes.
    ///
    /// # Errors
    ///
    /// None for bytes that were read once.
    pub fn decode(&self, channel: usize) -> Result<Vec<f64>> {
        Ok(dense(&Parts::read(&self.bytes, false)?, channel))
    }
}

/// Where the triples of one axis stand.
struct Ends {
    /// Those of each level from the first on.
    clusters: Vec<Vec<Cluster>>,
    /// Lanes of each that are taken.
    used: Vec<Vec<usize>>,
}

impl Ends {
    /// Puts codes into the next lane of a cluster: the lane's number, and the codes that are left.
    fn put<'a>(&mut self, level: usize, index: usize, all: &mut [[i8; LANES]], codes: &'a [i8]) -> (usize, &'a [i8]) {
        let (cluster, used) = (self.clusters[level][index], &mut self.used[level][index]);
        let (panel, lane) = (*used / LANES, *used % LANES);
        *used += 1;
        let (own, rest) = codes.split_at(cluster.len);
        let to = &mut all[cluster.codes + panel * cluster.len..][..cluster.len];
        to.iter_mut().zip(own).for_each(|(to, &code)| to[lane] = code);
        ((cluster.first + panel) * LANES + lane, rest)
    }
}

/// The first step for some panels. A structure, as closures are not inlined into the function that may have
/// vector instructions.
struct Gathering<'a> {
    codes: &'a [[i8; LANES]],
    panels: &'a [Panel],
    x: &'a [[f32; 3]],
    sums: &'a mut [Lanes],
}

impl WithSimd for Gathering<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (sum, p) in self.sums.iter_mut().zip(self.panels) {
            *sum = gather(&self.codes[p.codes..][..p.len], &self.x[p.place..][..p.len]);
        }
    }
}

/// The last step for a leaf.
struct Scattering<'a> {
    matrix: &'a HMatrix,
    leaf: usize,
    x: &'a [[f32; 3]],
    exchanged: &'a [Lanes],
    out: &'a mut [[f32; 3]],
}

impl WithSimd for Scattering<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.matrix.leaf(self.leaf, self.x, self.exchanged, self.out);
    }
}

/// Rows of the padded result that a leaf takes.
fn row_width(tree: Tree) -> usize {
    tree.largest(tree.depth).next_multiple_of(ROWS).max(ROWS)
}

fn low_rank(plane: &Plane) -> impl Iterator<Item = (&Id, &Vec<Coded>)> {
    plane.blocks.iter().filter_map(|(id, block)| match block {
        Block::LowRank { triples, .. } => Some((id, triples)),
        _ => None,
    })
}

/// A channel of a matrix in the order of receivers and patches, row-major.
pub(crate) fn dense(parts: &Parts, channel: usize) -> Vec<f64> {
    let (pairs, rows, columns) = (parts.pairs(), parts.rows(), &parts.columns);
    let width = columns.order.len();
    let mut dense = vec![0.0; rows.order.len() * width];
    let share = |axis: &Axis, place: usize| f64::from(axis.weights[place]) / f64::from(HEAVIEST);
    let mut add = |i: usize, j: usize, value: f64| {
        let scale = if parts.receivers.is_some() { share(columns, j) } else { 1.0 };
        dense[rows.order[i] as usize * width + columns.order[j] as usize] += scale * value;
    };
    for plane in &parts.planes {
        let colour = f64::from(plane.colour[channel]);
        for (id, block) in &plane.blocks {
            let [receivers, senders] = pairs.ranges(*id);
            let values = dense_block(block, plane.unit, pairs.shape(*id));
            let mean = match block {
                Block::LowRank { mean, .. } => f64::from(plane.unit) * mean.to_f64(),
                _ => 0.0,
            };
            for (at, value) in values.into_iter().enumerate() {
                let (i, j) = (receivers.start + at / senders.len(), senders.start + at % senders.len());
                let value = colour * (value + mean * share(rows, i) * share(columns, j));
                add(i, j, value);
                if pairs.is_mirrored(*id) {
                    add(j, i, value);
                }
            }
        }
    }
    dense
}

/// Entries of a block, row by row.
fn dense_block(block: &Block, unit: f32, shape: Shape) -> Vec<f64> {
    let (rows, columns, symmetric) = match shape {
        Shape::Full { rows, columns } => (rows, columns, false),
        Shape::Symmetric { size } => (size, size, true),
    };
    let mut dense = vec![0.0; rows * columns];
    match block {
        Block::Split => {}
        Block::LowRank { triples, .. } => {
            for t in triples {
                let factor = f64::from(t.factor(unit));
                let other = if symmetric { &t.codes[..] } else { &t.codes[rows..] };
                for (at, value) in dense.iter_mut().enumerate() {
                    *value += factor * f64::from(t.codes[at / columns]) * f64::from(other[at % columns]);
                }
            }
        }
        Block::Tile(tile) => {
            let entries = tile.entries(unit);
            for (at, value) in dense.iter_mut().enumerate() {
                *value = f64::from(entries[shape.entry(at / columns, at % columns)]);
            }
        }
    }
    dense
}

/// Tiles by the leaf of their rows. Only luma has tiles, and it is the same in all colours.
fn near_of_leaves(parts: &Parts) -> Vec<Near> {
    let (pairs, rows, plane) = (parts.pairs(), parts.rows().tree, &parts.planes[0]);
    let mut tiles: Vec<Vec<(&Tile, Id, bool)>> = vec![Vec::new(); rows.count(rows.depth)];
    for (id, block) in &plane.blocks {
        if let Block::Tile(tile) = block {
            tiles[id.a].push((tile, *id, false));
            if pairs.is_mirrored(*id) {
                tiles[id.b].push((tile, *id, true));
            }
        }
    }
    let of_leaf = |(leaf, tiles): (usize, Vec<(&Tile, Id, bool)>)| {
        let rows = rows.range(rows.depth, leaf).len();
        let mut near = Near::default();
        let mut columns: Vec<Vec<u8>> = Vec::new();
        for (tile, id, mirrored) in tiles {
            let [first, second] = pairs.ranges(id);
            let senders = if mirrored { first } else { second };
            let shape = pairs.shape(id);
            let number = |row: usize, column: usize| {
                let (i, j) = if mirrored { (column, row) } else { (row, column) };
                shape.entry(i, j)
            };
            let apart: BTreeMap<u16, f32> = tile.apart.iter().map(|&(at, v)| (at, plane.unit * v.to_f32())).collect();
            for (column, sender) in senders.enumerate() {
                near.senders.push((sender as u32, tile.scale(plane.unit)));
                let code = |row: usize| {
                    let at = number(row, column);
                    // An entry that stands apart replaces its code.
                    match apart.get(&(at as u16)) {
                        Some(&value) => {
                            near.apart.push((row as u32, sender as u32, value));
                            0
                        }
                        None => tile.codes[at],
                    }
                };
                columns.push((0..rows).map(code).collect());
            }
        }
        for first in (0..rows).step_by(ROWS) {
            let padded = |c: &Vec<u8>| std::array::from_fn(|row| c.get(first + row).copied().unwrap_or(0));
            near.codes.extend(columns.iter().map(padded));
        }
        near
    };
    tiles.into_iter().enumerate().map(of_leaf).collect()
}
