//! The operator as it is multiplied with.
//!
//! All triples that touch a cluster stand side by side as one matrix C of codes, patches × triples. So the product
//! is three steps: t = Cᵀ x in every cluster; every triple's two ends exchange what they gathered, times its scale;
//! y = C t in every cluster, and tiles. Triples of blocks above and below the diagonal are the same two ends, so
//! the operator is symmetric to the last bit of its codes. Triples of luma and of colour differ in their scales
//! only, which are three numbers. The first lane of every cluster is its weights, whose means go to many others.
//!
//! Every number is summed by one task in a fixed order: more threads change who computes it, never how.

use std::{collections::BTreeMap, ops::Range};

use half::f16;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use crate::{
    Result,
    block::{Block, Shape},
    cluster::Tree,
    kernels::{LANES, Lanes, ROWS, across, gather, near, scatter},
    plan::{Id, first_level},
    stream::{HEAVIEST, Parts, Plane},
    tile::Tile,
    triple::Coded,
};

/// Panels that a task handles.
const PANELS: usize = 16;

/// A symmetric operator K of one channel or three, compressed.
pub struct HMatrix {
    bytes: Vec<u8>,
    n: usize,
    channels: usize,
    tree: Tree,
    /// Patch at each place.
    order: Vec<u32>,
    /// Where in the padded result each patch stands.
    slot: Vec<u32>,
    /// [`LANES`] triples at one patch each; patches of a panel stand together, panels of a cluster follow each other.
    codes: Vec<[i8; LANES]>,
    /// What is gathered in the first step.
    panels: Vec<Panel>,
    /// The other end of every lane of each panel.
    partner: Vec<[u32; LANES]>,
    /// The scale of its triple in each colour.
    factor: Vec<Lanes>,
    /// Where each panel's means start in `means`, one more at the end; only first panels of clusters have any.
    mean_start: Vec<u32>,
    /// First panel of the other cluster, and the mean of the block in each colour.
    means: Vec<(u32, [f32; 3])>,
    /// Clusters of each level from the first on.
    clusters: Vec<Vec<Cluster>>,
    /// Tiles of each leaf.
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
    /// Patch at each place.
    pub order: &'a [u32],
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
        Ok(HMatrix::new(&Parts::read(bytes)?, bytes.to_vec()))
    }

    /// The packed operator.
    pub fn to_bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Number of patches.
    pub fn patches(&self) -> usize {
        self.n
    }

    /// 1 or 3.
    pub fn channels(&self) -> usize {
        self.channels
    }

    pub(crate) fn new(parts: &Parts, bytes: Vec<u8>) -> HMatrix {
        let tree = parts.tree;
        let width = row_width(tree);
        let mut slot = vec![0; tree.n];
        for leaf in 0..1usize << tree.depth {
            for (row, place) in tree.range(tree.depth, leaf).enumerate() {
                slot[parts.order[place] as usize] = (leaf * width + row) as u32;
            }
        }
        let mut made = HMatrix {
            bytes,
            n: tree.n,
            channels: parts.channels,
            tree,
            order: parts.order.clone(),
            slot,
            codes: Vec::new(),
            panels: Vec::new(),
            partner: Vec::new(),
            clusters: Vec::new(),
            factor: Vec::new(),
            mean_start: Vec::new(),
            means: Vec::new(),
            near: Vec::new(),
        };
        made.lay_out_clusters(parts);
        made.fill_clusters(parts);
        made.fill_means(parts);
        made.near = near_of_leaves(parts);
        made
    }

    /// Room for the triples of every cluster.
    fn lay_out_clusters(&mut self, parts: &Parts) {
        let first = first_level(self.tree);
        let mut ends: Vec<Vec<usize>> = (first..=self.tree.depth).map(|level| vec![1; 1 << level]).collect();
        for (id, triples) in parts.planes.iter().flat_map(low_rank) {
            let level = &mut ends[(id.level - first) as usize];
            level[id.a] += triples.len();
            if id.a != id.b {
                level[id.b] += triples.len();
            }
        }
        for (level, ends) in (first..).zip(ends) {
            let clusters = ends.iter().enumerate().map(|(index, ends)| {
                let range = self.tree.range(level, index);
                self.add_panels(ends.div_ceil(LANES), range.start, range.len())
            });
            let clusters = clusters.collect();
            self.clusters.push(clusters);
        }
        self.partner = vec![[0; LANES]; self.panels.len()];
        self.factor = vec![[[0.0; LANES]; 3]; self.panels.len()];
    }

    fn add_panels(&mut self, count: usize, place: usize, len: usize) -> Cluster {
        let cluster = Cluster { first: self.panels.len(), count, codes: self.codes.len(), place, len };
        self.panels.extend((0..count).map(|k| Panel { codes: cluster.codes + k * len, place, len }));
        self.codes.resize(cluster.codes + count * len, [0; LANES]);
        cluster
    }

    fn fill_clusters(&mut self, parts: &Parts) {
        let first = first_level(self.tree);
        let mut used: Vec<Vec<usize>> = self.clusters.iter().map(|level| vec![1; level.len()]).collect();
        for plane in &parts.planes {
            for (id, triples) in low_rank(plane) {
                let level = (id.level - first) as usize;
                for triple in triples {
                    let scale = plane.colour.map(|c| c * triple.factor(plane.unit));
                    let (a, rest) = self.put_end(level, id.a, &mut used[level][id.a], &triple.codes);
                    let b = if id.a == id.b { a } else { self.put_end(level, id.b, &mut used[level][id.b], rest).0 };
                    for (own, other) in [(a, b), (b, a)] {
                        let (panel, lane) = (own / LANES, own % LANES);
                        self.partner[panel][lane] = other as u32;
                        (0..3).for_each(|c| self.factor[panel][c][lane] = scale[c]);
                    }
                }
            }
        }
    }

    /// Puts codes into the next lane of a cluster: the lane's number, and the codes that are left.
    fn put_end<'a>(&mut self, level: usize, index: usize, used: &mut usize, codes: &'a [i8]) -> (usize, &'a [i8]) {
        let cluster = self.clusters[level][index];
        let (panel, lane) = (*used / LANES, *used % LANES);
        *used += 1;
        let (own, rest) = codes.split_at(cluster.len);
        let to = &mut self.codes[cluster.codes + panel * cluster.len..][..cluster.len];
        to.iter_mut().zip(own).for_each(|(to, &code)| to[lane] = code);
        ((cluster.first + panel) * LANES + lane, rest)
    }

    /// The first lane of every cluster, and what it exchanges.
    fn fill_means(&mut self, parts: &Parts) {
        let first = first_level(self.tree);
        for c in self.clusters.iter().flatten() {
            let own = &parts.weights[c.place..][..c.len];
            self.codes[c.codes..][..c.len].iter_mut().zip(own).for_each(|(to, &weight)| to[0] = weight);
        }
        let mut found = vec![BTreeMap::<u32, [f32; 3]>::new(); self.panels.len()];
        for plane in &parts.planes {
            for (id, block) in &plane.blocks {
                let Block::LowRank { mean, .. } = block else { continue };
                if *mean == f16::ZERO {
                    continue;
                }
                let scale = plane.unit * mean.to_f32() / (HEAVIEST * HEAVIEST);
                let [a, b] = [id.a, id.b].map(|index| self.clusters[(id.level - first) as usize][index].first);
                for (own, other) in [(a, b), (b, a)].into_iter().take(if a == b { 1 } else { 2 }) {
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
        2 * self.codes.len() * LANES + self.means.len() + near
    }

    /// Memory for [`HMatrix::multiply`].
    pub fn workspace(&self) -> Workspace {
        let zero = [[0.0; LANES]; 3];
        Workspace {
            x: vec![[0.0; 3]; self.n],
            gathered: vec![zero; self.panels.len()],
            exchanged: vec![zero; self.panels.len()],
            out: vec![[0.0; 3]; row_width(self.tree) << self.tree.depth],
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
        assert_eq!((x.len(), y.len(), ordered.len()), (self.n, self.n, self.n), "one value a patch");
        assert_eq!(gathered.len(), self.panels.len(), "the workspace of this operator");
        ordered.iter_mut().zip(&self.order).for_each(|(to, &patch)| *to = x[patch as usize]);
        let (x, arch) = (&ordered[..], Arch::new());
        gathered.par_chunks_mut(PANELS).zip(self.panels.par_chunks(PANELS)).for_each(|(sums, panels)| {
            arch.dispatch(Gathering { codes: &self.codes, panels, x, sums });
        });
        self.exchange(gathered, exchanged);
        let exchanged = &exchanged[..];
        out.par_chunks_mut(row_width(self.tree)).enumerate().for_each(|(leaf, out)| {
            arch.dispatch(Scattering { matrix: self, leaf, x, exchanged, out });
        });
        y.iter_mut().zip(&self.slot).for_each(|(y, &slot)| *y = out[slot as usize]);
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
        let rows = self.tree.range(self.tree.depth, leaf);
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

    /// What the product reads.
    pub fn layout(&self) -> Layout<'_> {
        let depth = self.clusters.len() - 1;
        let leaf = |(leaf, near)| Leaf {
            rows: self.tree.range(self.tree.depth, leaf),
            above: self.clusters.iter().enumerate().map(|(level, all)| all[leaf >> (depth - level)]).collect(),
            near,
        };
        Layout {
            order: &self.order,
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
        let parts = Parts::read(&self.bytes)?;
        let mut dense = vec![0.0; self.n * self.n];
        let mut add = |i: usize, j: usize, value: f64| {
            dense[parts.order[i] as usize * self.n + parts.order[j] as usize] += value;
        };
        for plane in &parts.planes {
            let share = f64::from(plane.colour[channel]);
            for (id, block) in &plane.blocks {
                let (rows, columns) = (self.tree.range(id.level, id.a), self.tree.range(id.level, id.b));
                let mut values = dense_block(block, plane.unit, id.shape(self.tree));
                if let Block::LowRank { mean, .. } = block {
                    let weight = |place: usize| f64::from(parts.weights[place]) / f64::from(HEAVIEST);
                    let mean = f64::from(plane.unit) * mean.to_f64();
                    values.iter_mut().enumerate().for_each(|(at, value)| {
                        let (i, j) = (rows.start + at / columns.len(), columns.start + at % columns.len());
                        *value += mean * weight(i) * weight(j);
                    });
                }
                for (at, value) in values.into_iter().enumerate() {
                    let (i, j) = (rows.start + at / columns.len(), columns.start + at % columns.len());
                    add(i, j, share * value);
                    if id.a != id.b {
                        add(j, i, share * value);
                    }
                }
            }
        }
        Ok(dense)
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
    tree.range(tree.depth, 0).len().next_multiple_of(ROWS)
}

fn low_rank(plane: &Plane) -> impl Iterator<Item = (&Id, &Vec<Coded>)> {
    plane.blocks.iter().filter_map(|(id, block)| match block {
        Block::LowRank { triples, .. } => Some((id, triples)),
        _ => None,
    })
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
    let (tree, plane) = (parts.tree, &parts.planes[0]);
    let mut tiles: Vec<Vec<(&Tile, Id, bool)>> = vec![Vec::new(); 1 << tree.depth];
    for (id, block) in &plane.blocks {
        if let Block::Tile(tile) = block {
            tiles[id.a].push((tile, *id, false));
            if id.a != id.b {
                tiles[id.b].push((tile, *id, true));
            }
        }
    }
    let of_leaf = |(leaf, tiles): (usize, Vec<(&Tile, Id, bool)>)| {
        let rows = tree.range(tree.depth, leaf).len();
        let mut near = Near::default();
        let mut columns: Vec<Vec<u8>> = Vec::new();
        for (tile, id, mirrored) in tiles {
            let senders = tree.range(tree.depth, if mirrored { id.a } else { id.b });
            let shape = id.shape(tree);
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
