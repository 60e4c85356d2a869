//! A sparse block in the norm of errors, and the triples that leave least of it.
//!
//! Triples are found one by one: power iterations on what the triples before have left, *as they are stored*. So a triple
//! also mends what the codes of those before it have spoilt, no more are found than are worth their bytes, and what is left
//! is known exactly. All of it takes time in proportion to the entries there are.
//!
//! A search starts from a row, and what no row connects stays exactly 0 in it: triples never join groups that exchange
//! nothing.

use std::ops::Range;

use half::f16;

use crate::{
    small::dot,
    stretch::Stretch,
    triple::{BITS, Coded, quantise, top},
};

/// Power iterations, each with the block and its transpose. Measured as in `packer.rs`: 2 take 5 % more bytes, 4 take 1 %
/// fewer.
const ITERATIONS: usize = 3;
/// Adding and subtracting it rounds a small number to the nearest whole one.
const ROUNDER: f64 = 1.5 * (1u64 << 52) as f64;

/// Entries of some rows, those of each by increasing column.
#[derive(Default)]
pub struct Entries {
    pub column: Vec<u32>,
    pub value: Vec<f32>,
}

/// Entries of a block: where those of each of its rows start and end.
#[derive(Clone, Copy)]
pub struct Sparse<'a> {
    pub entries: &'a Entries,
    pub rows: &'a [[u32; 2]],
    /// Its first column.
    pub first: u32,
}

/// Where the entries of the four quarters of a block start and end.
pub struct Quarters {
    /// Of the left columns, and of the right ones.
    halves: [Vec<[u32; 2]>; 2],
    /// Rows of the upper quarters.
    upper: usize,
    /// First column of the right ones.
    middle: u32,
}

impl Quarters {
    /// The quarter of `block` in rows `a` and columns `b`: 0 or 1.
    pub fn block<'a>(&'a self, block: Sparse<'a>, a: usize, b: usize) -> Sparse<'a> {
        let (upper, lower) = self.halves[b].split_at(self.upper);
        Sparse { rows: [upper, lower][a], first: [block.first, self.middle][b], ..block }
    }
}

impl<'a> Sparse<'a> {
    pub fn is_empty(&self) -> bool {
        self.rows.iter().all(|[start, end]| start == end)
    }

    /// Where the entries in `columns` of each row start and end.
    pub fn within(&self, columns: Range<usize>) -> Vec<[u32; 2]> {
        let cut = |&[start, end]: &[u32; 2]| {
            let own = &self.entries.column[start as usize..end as usize];
            [columns.start, columns.end].map(|column| start + own.partition_point(|&j| (j as usize) < column) as u32)
        };
        self.rows.iter().map(cut).collect()
    }

    /// Cuts the block after `upper` rows and before column `middle`, counted as those of entries are.
    pub fn quarters(&self, upper: usize, middle: u32) -> Quarters {
        let cut = |&[start, end]: &[u32; 2]| {
            start + self.entries.column[start as usize..end as usize].partition_point(|&j| j < middle) as u32
        };
        let cuts = self.rows.iter().map(|row| (row, cut(row)));
        let halves = cuts.map(|(&[start, end], cut)| ([start, cut], [cut, end])).unzip();
        Quarters { halves: halves.into(), upper, middle }
    }

    /// Columns, counted from the first of the block, and values of a row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> + use<'a> {
        let (first, [start, end]) = (self.first, self.rows[row]);
        let own = start as usize..end as usize;
        let columns = self.entries.column[own.clone()].iter();
        columns.zip(&self.entries.value[own]).map(move |(&j, &v)| ((j - first) as usize, f64::from(v)))
    }

    /// B x.
    pub fn times(&self, x: &[f64], y: &mut [f64]) {
        for (i, y) in y.iter_mut().enumerate() {
            *y = self.row(i).map(|(j, v)| v * x[j]).sum();
        }
    }

    /// Bᵀ y.
    pub fn transposed(&self, y: &[f64], x: &mut [f64]) {
        x.fill(0.0);
        for (i, &y) in y.iter().enumerate().filter(|(_, y)| **y != 0.0) {
            self.row(i).for_each(|(j, v)| x[j] += v * y);
        }
    }
}

/// A triple as it is stored, and what that does.
pub struct Found {
    pub coded: Coded,
    /// By how much it lessens the error².
    pub gain: f64,
    /// Its part of the mean.
    pub mean: f64,
    /// The most that any one triple could do.
    pub most: f64,
}

/// What is left of S B S, whose sides are stretched.
pub struct Residual<'a> {
    block: Sparse<'a>,
    sides: [&'a Stretch; 2],
    unit: f64,
    /// Triples that were taken: their scale and both stretched sides.
    taken: Vec<(f64, Vec<f64>, Vec<f64>)>,
    /// About what is left of each row; exact in blocks that are not stretched.
    left: Vec<f64>,
    u: Vec<f64>,
    v: Vec<f64>,
    stretched: [Vec<f64>; 2],
}

impl<'a> Residual<'a> {
    /// `widened` is B w, w the weights of the columns.
    pub fn new(block: Sparse<'a>, sides: [&'a Stretch; 2], widened: &[f64], unit: f32) -> Residual<'a> {
        let more = sides[1].factor().powi(2) - 1.0;
        let square = |row: usize| block.row(row).map(|(_, v)| v * v).sum::<f64>();
        let left = widened.iter().enumerate().map(|(row, y)| square(row) + more * y * y).collect();
        let zeros = |side: usize| vec![0.0; sides[side].along.len()];
        let (u, v) = (zeros(0), zeros(1));
        let stretched = [u.clone(), v.clone()];
        Residual { block, sides, unit: f64::from(unit), taken: Vec::new(), left, u, v, stretched }
    }

    /// u becomes R v.
    fn forward(&mut self) {
        let Residual { block, sides, taken, u, v, stretched: [_, x], .. } = self;
        x.copy_from_slice(v);
        sides[1].apply(x);
        block.times(x, u);
        sides[0].apply(u);
        for (scale, a, b) in taken {
            add(u, -*scale * dot(b, v), a);
        }
    }

    /// v becomes Rᵀ u.
    fn backward(&mut self) {
        let Residual { block, sides, taken, u, v, stretched: [y, _], .. } = self;
        y.copy_from_slice(u);
        sides[0].apply(y);
        block.transposed(y, v);
        sides[1].apply(v);
        for (scale, a, b) in taken {
            add(v, -*scale * dot(a, u), b);
        }
    }

    /// Takes the triple that is worth most at a price of a byte; `bytes` are those of a triple in each number of bits. None
    /// if none is worth its bytes.
    pub fn take(&mut self, price: f64, bytes: [f64; BITS.len()]) -> Option<Found> {
        let square = self.dominant()?;
        let [shares_u, shares_v] = [shares(&self.u, self.sides[0]), shares(&self.v, self.sides[1])];
        let net = |bits: usize| square * shares_u[bits] * shares_v[bits] - price * bytes[bits];
        let bits = (0..BITS.len()).max_by(|&a, &b| net(a).total_cmp(&net(b))).filter(|&bits| net(bits) > 0.0)?;
        let (codes_v, b) = codes(&self.v, self.sides[1], bits);
        // What is best beside the codes of the other side.
        self.v.copy_from_slice(&b);
        self.forward();
        let (codes_u, a) = codes(&self.u, self.sides[0], bits);
        let (along, squares) = (dot(&a, &self.u), dot(&a, &a) * dot(&b, &b));
        let scale = f16::from_f64(along / squares / self.unit);
        let s = self.unit * scale.to_f64();
        let gain = 2.0 * s * along - s * s * squares;
        if !scale.is_finite() || gain <= price * bytes[bits] {
            return None;
        }
        let length = dot(&b, &b);
        for ((left, a), u) in self.left.iter_mut().zip(&a).zip(&self.u) {
            *left += s * a * (s * a * length - 2.0 * u);
        }
        // w is stretched by a factor: without it, the mean of what is stored.
        let along_w = |x: &[f64], side: usize| dot(x, &self.sides[side].along) / self.sides[side].factor();
        let mean = s * along_w(&a, 0) * along_w(&b, 1);
        self.taken.push((s, a, b));
        let codes = codes_u.into_iter().chain(codes_v).collect();
        Some(Found { coded: Coded { bits, scale, codes }, gain, mean, most: square })
    }

    /// u and v become those of about the largest triple; its square.
    fn dominant(&mut self) -> Option<f64> {
        let row = (0..self.left.len()).max_by(|&a, &b| self.left[a].total_cmp(&self.left[b]))?;
        self.u.fill(0.0);
        self.u[row] = 1.0;
        let mut square = 0.0;
        for _ in 0..ITERATIONS {
            self.backward();
            let length = dot(&self.v, &self.v).sqrt();
            if length < 1e-150 {
                return None;
            }
            self.v.iter_mut().for_each(|v| *v /= length);
            self.forward();
            square = dot(&self.u, &self.u);
        }
        (square > 0.0).then_some(square)
    }
}

/// Codes of one side of a triple, and what they stand for, stretched.
fn codes(x: &[f64], side: &Stretch, bits: usize) -> (Vec<i8>, Vec<f64>) {
    let mut plain = x.to_vec();
    side.undo(&mut plain);
    let codes = quantise(&plain, BITS[bits]);
    let mut decoded: Vec<f64> = codes.iter().map(|&code| f64::from(code) / f64::from(top(BITS[bits]))).collect();
    side.apply(&mut decoded);
    (codes, decoded)
}

/// The share of x² that its codes in each number of bits can stand for.
fn shares(x: &[f64], side: &Stretch) -> [f64; BITS.len()] {
    let (w, more) = (&side.along[..], side.factor() - 1.0);
    let along_w = dot(x, w);
    let plain = |x: f64, w: f64| x - more / (1.0 + more) * along_w * w;
    let largest = x.iter().zip(w).fold(0.0f64, |largest, (&x, &w)| largest.max(plain(x, w).abs()));
    let steps = BITS.map(|bits| f64::from(top(bits)) / largest);
    // Of codes c in each number of bits: x c, c², c w.
    let mut sums = [[0.0; 3]; BITS.len()];
    for (&x, &w) in x.iter().zip(w) {
        let plain = plain(x, w);
        for (sums, step) in sums.iter_mut().zip(steps) {
            let code = (step * plain + ROUNDER) - ROUNDER;
            *sums = [sums[0] + x * code, sums[1] + code * code, sums[2] + code * w];
        }
    }
    sums.map(|[along, square, mean]| {
        let (along, square) = (along + more * mean * along_w, square + more * (2.0 + more) * mean * mean);
        if square > 0.0 { along * along / (square * dot(x, x)) } else { 0.0 }
    })
}

/// y becomes y + factor · x.
fn add(y: &mut [f64], factor: f64, x: &[f64]) {
    if factor != 0.0 {
        y.iter_mut().zip(x).for_each(|(y, x)| *y += factor * x);
    }
}
