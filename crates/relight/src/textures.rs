//! The product with an operator that is packed as a texture, three colours at a time.
//!
//! Blocks are unpacked once to codes of 16 bits, in which every code of BC1 and BC4 is a whole number: 255 · 35 steps
//! hold sevenths and fifths of 8 bits, 31 · 6 and 63 · 6 steps halves and thirds of 5 and 6. A frame makes values of the
//! codes on the way, by squaring or by a table, so it reads half the bytes of single precision. Where half of the
//! matrix is stored, every value serves its row and, mirrored, its column.
//!
//! The loops are written so that the compiler makes vector instructions of them; no multiplication is fused with
//! an addition. Rows are cut in the same parts whatever the number of threads and parts are added in their order, so
//! every processor gives the same bits.

use pulp::{Arch, Simd, WithSimd};
use radfile::{BlockFormat, ColourBlock, Outliers, PackedOperator, ValueMap};
use rayon::prelude::*;

/// Columns that are handled side by side.
const LANES: usize = 8;
/// Parts that rows are cut into.
const PARTS: usize = 16;
/// Patches of a component whose colour is gathered by one task.
const GATHERED: usize = 512;
/// Steps of a BC4 code.
const BC4_STEPS: usize = 255 * 35;
/// Steps of the codes of BC1, of red and blue and of green.
const BC1_STEPS: [usize; 3] = [31 * 6, 63 * 6, 31 * 6];

/// Three colours at each of some places.
type Planar = [Vec<f32>; 3];
/// A number for each of [`LANES`] columns.
type Lanes = [f32; LANES];

/// An operator, ready for products.
pub struct TextureProduct<'a> {
    packed: PackedOperator<'a>,
    /// Codes by channel; four rows of each block row, [`TextureProduct::width`] columns each.
    codes: Vec<Vec<u16>>,
    /// First code of each block row.
    start: Vec<usize>,
    /// Texels on and below the diagonal of the diagonal blocks, where half is stored; others are 0.
    diagonal: Vec<[f32; 16]>,
    /// How codes become values in each channel.
    decode: Vec<Decode>,
    /// Block rows of each part.
    parts: Vec<std::ops::Range<usize>>,
    outliers: Outliers<'static>,
    colour: Vec<ColourBlock>,
    /// Component and some of its members.
    gathers: Vec<(usize, std::ops::Range<usize>)>,
}

enum Decode {
    /// factor · code².
    Square(f32),
    /// The value of each code.
    Table(Vec<f32>),
}

/// Memory of a product, kept from frame to frame.
pub struct Workspace {
    /// Light that is sent, with zeros up to whole lanes.
    sent: Planar,
    /// What the rows of each part receive, and what their mirror images do.
    parts: Vec<(Planar, Planar)>,
    /// Uᵀ x of each task, colour after colour.
    gathered: Vec<Vec<f32>>,
    /// C Uᵀ x of each component.
    carried: Vec<Vec<f32>>,
}

impl<'a> TextureProduct<'a> {
    /// Unpacks an operator, to 2 bytes for each texel that is stored.
    pub fn new(packed: PackedOperator<'a>) -> TextureProduct<'a> {
        let rows = packed.packing.n.div_ceil(4) as usize;
        let planes = if packed.half.is_some() { 1 } else { packed.packing.channels as usize };
        let outliers = packed.outliers();
        let outliers = Outliers {
            start: outliers.start.into_owned().into(),
            column: outliers.column.into_owned().into(),
            value: outliers.value.into_owned().into(),
            channels: outliers.channels,
        };
        let colour = packed.colour();
        let gathers = colour.iter().enumerate().flat_map(|(component, block)| {
            let tasks = (0..block.patches.len()).step_by(GATHERED);
            tasks.map(move |first| (component, first..block.patches.len().min(first + GATHERED)))
        });
        let mut product = TextureProduct {
            codes: Vec::new(),
            start: Vec::with_capacity(rows + 1),
            diagonal: Vec::new(),
            decode: (0..planes).map(|channel| decode(&packed, channel)).collect(),
            parts: parts(rows, packed.half.is_some()),
            outliers,
            gathers: gathers.collect(),
            colour,
            packed,
        };
        let mut end = 0;
        for row in 0..=rows {
            product.start.push(end);
            end += 4 * product.width(row);
        }
        product.codes = (0..planes).map(|channel| product.unpack(channel, rows)).collect();
        if product.packed.half.is_some() {
            let lower = |row: usize| {
                let texels = product.packed.texels(0, 4 * row, 4 * row);
                std::array::from_fn(|t| if t % 4 <= t / 4 { texels[t] } else { 0.0 })
            };
            product.diagonal = (0..rows).map(lower).collect();
        }
        product
    }

    /// The operator as it is packed.
    pub fn packed(&self) -> &PackedOperator<'a> {
        &self.packed
    }

    /// Columns of a block row that codes are kept of: left of the diagonal block where half is stored.
    fn width(&self, row: usize) -> usize {
        let columns = if self.packed.half.is_some() { 4 * row } else { self.packed.packing.n as usize };
        columns.next_multiple_of(LANES)
    }

    /// The codes of a channel.
    fn unpack(&self, channel: usize, rows: usize) -> Vec<u16> {
        let n = self.packed.packing.n as usize;
        let half = self.packed.half.is_some();
        let mut codes = vec![0; self.start[rows]];
        let mut rest = &mut codes[..];
        let mut of_rows = Vec::with_capacity(rows);
        for row in 0..rows {
            let (own, others) = rest.split_at_mut(4 * self.width(row));
            of_rows.push(own);
            rest = others;
        }
        of_rows.into_par_iter().enumerate().for_each(|(row, codes)| {
            let width = self.width(row);
            for column in 0..if half { row } else { rows } {
                let block = codes_of(&self.packed, channel, row, column);
                for (t, code) in block.into_iter().enumerate() {
                    if 4 * column + t % 4 < n && 4 * row + t / 4 < n {
                        codes[t / 4 * width + 4 * column + t % 4] = code;
                    }
                }
            }
        });
        codes
    }

    /// Memory for [`TextureProduct::multiply`].
    pub fn workspace(&self) -> Workspace {
        let n = self.packed.packing.n as usize;
        let planar = |length: usize| [vec![0.0; length], vec![0.0; length], vec![0.0; length]];
        let of_part = |part: &std::ops::Range<usize>| {
            let mirrored = if self.packed.half.is_some() { (4 * part.end).next_multiple_of(LANES) } else { 0 };
            (planar(4 * part.len()), planar(mirrored))
        };
        Workspace {
            sent: planar(n.next_multiple_of(4).next_multiple_of(LANES)),
            parts: self.parts.iter().map(of_part).collect(),
            gathered: self.gathers.iter().map(|(component, _)| vec![0.0; 3 * self.colour[*component].rank]).collect(),
            carried: self.colour.iter().map(|block| vec![0.0; 3 * block.rank]).collect(),
        }
    }

    /// y = K x, in the order of patches; `x` and `y` are red, green and blue. Grey operators treat all three alike.
    /// Takes no memory, and gives the same bits on any number of threads.
    ///
    /// # Panics
    ///
    /// If `x`, `y` or the workspace are of another size: a bug in the caller.
    pub fn multiply(&self, x: &[[f32; 3]], y: &mut [[f32; 3]], workspace: &mut Workspace) {
        let n = self.packed.packing.n as usize;
        assert_eq!((x.len(), y.len()), (n, n), "one value a patch");
        let Workspace { sent, parts, gathered, carried } = workspace;
        assert_eq!(
            (parts.len(), carried.len()),
            (self.parts.len(), self.colour.len()),
            "the workspace of this operator"
        );
        for (c, sent) in sent.iter_mut().enumerate() {
            sent.iter_mut().zip(x).for_each(|(sent, x)| *sent = x[c]);
        }
        let (sent, arch) = (&*sent, Arch::new());
        parts.par_iter_mut().zip(&self.parts).for_each(|((own, mirrored), rows)| {
            arch.dispatch(Part { product: self, rows: rows.clone(), sent, own, mirrored });
        });
        gathered.par_iter_mut().zip(&self.gathers).for_each(|(to, (component, members))| {
            arch.dispatch(Gather { block: &self.colour[*component], members: members.clone(), x, to });
        });
        self.carry(gathered, carried);
        let (parts, carried) = (&*parts, &*carried);
        y.par_iter_mut().with_min_len(64).enumerate().for_each(|(i, y)| *y = self.received(i, x, parts));
        self.colour.iter().zip(carried).for_each(|(block, carried)| scatter(arch, block, carried, y));
    }

    /// What textures and outliers bring to a patch.
    fn received(&self, i: usize, x: &[[f32; 3]], parts: &[(Planar, Planar)]) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for (rows, (own, mirrored)) in self.parts.iter().zip(parts) {
            for (c, sum) in sum.iter_mut().enumerate() {
                if rows.contains(&(i / 4)) {
                    *sum += own[c][i - 4 * rows.start];
                }
                *sum += mirrored[c].get(i).copied().unwrap_or(0.0);
            }
        }
        let Outliers { start, column, value, channels } = &self.outliers;
        for entry in start[i] as usize..start[i + 1] as usize {
            let x = x[column[entry] as usize];
            (0..3).for_each(|c| sum[c] += value[entry * channels + c.min(channels - 1)] * x[c]);
        }
        sum
    }

    /// What every component gathered, times its core.
    fn carry(&self, gathered: &mut [Vec<f32>], carried: &mut [Vec<f32>]) {
        let mut first = 0;
        for (component, (block, carried)) in self.colour.iter().zip(carried).enumerate() {
            let tasks = self.gathers[first..].iter().take_while(|task| task.0 == component).count();
            let (sum, others) = gathered[first..first + tasks].split_first_mut().expect("a component has members");
            for other in others {
                sum.iter_mut().zip(other).for_each(|(sum, other)| *sum += *other);
            }
            for (c, core) in block.core.iter().enumerate() {
                let gathered = &sum[c * block.rank..][..block.rank];
                let rows = carried[c * block.rank..].iter_mut().zip(core.chunks_exact(block.rank));
                rows.for_each(|(to, row)| *to = row.iter().zip(gathered).map(|(a, b)| a * b).sum());
            }
            first += tasks;
        }
    }
}

/// Block rows with about as many texels each.
fn parts(rows: usize, half: bool) -> Vec<std::ops::Range<usize>> {
    let end = |part: usize| {
        let share = part as f64 / PARTS as f64;
        (rows as f64 * if half { share.sqrt() } else { share }).round() as usize
    };
    (0..PARTS).map(|part| end(part)..end(part + 1)).collect()
}

/// How codes of a channel become values.
fn decode(packed: &PackedOperator, channel: usize) -> Decode {
    let p = &packed.packing;
    let steps = match p.format {
        BlockFormat::Bc4 => BC4_STEPS,
        BlockFormat::Bc1 => BC1_STEPS[channel],
    };
    match p.map {
        ValueMap::Sqrt => Decode::Square(p.scale[channel] / (steps * steps) as f32),
        ValueMap::Log { .. } => {
            Decode::Table((0..=steps).map(|code| p.map.decode(code as f32 / steps as f32, p.scale[channel])).collect())
        }
    }
}

/// The codes of a block in whole steps.
fn codes_of(packed: &PackedOperator, channel: usize, row: usize, column: usize) -> [u16; 16] {
    let steps = match packed.packing.format {
        BlockFormat::Bc4 => BC4_STEPS,
        BlockFormat::Bc1 => BC1_STEPS[channel],
    };
    packed.codes(channel, 4 * row, 4 * column).map(|u| (u * steps as f32).round() as u16)
}

/// Some block rows. A structure, as closures are not inlined into the function that may have vector instructions.
struct Part<'a> {
    product: &'a TextureProduct<'a>,
    rows: std::ops::Range<usize>,
    sent: &'a Planar,
    own: &'a mut Planar,
    mirrored: &'a mut Planar,
}

impl WithSimd for Part<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Part { product, rows, sent, own, mirrored } = self;
        mirrored.iter_mut().for_each(|plane| plane.fill(0.0));
        for row in rows.clone() {
            let width = product.width(row);
            let at = 4 * (row - rows.start);
            if product.packed.half.is_some() {
                let codes = &product.codes[0][product.start[row]..][..4 * width];
                let receivers = sent.each_ref().map(|x| std::array::from_fn(|r| x[4 * row + r]));
                let mut sums = match &product.decode[0] {
                    Decode::Square(factor) => {
                        let scaled = receivers.map(|x: [f32; 4]| x.map(|x| factor * x));
                        let sums = both_ways(codes, width, square, sent, &scaled, mirrored);
                        sums.map(|sums| sums.map(|sum| factor * sum))
                    }
                    Decode::Table(values) => {
                        both_ways(codes, width, |code| values[usize::from(code)], sent, &receivers, mirrored)
                    }
                };
                on_diagonal(&product.diagonal[row], &receivers, &mut sums);
                (0..3).for_each(|c| own[c][at..at + 4].copy_from_slice(&sums[c]));
            } else {
                for c in 0..3 {
                    let channel = c.min(product.codes.len() - 1);
                    let codes = &product.codes[channel][product.start[row]..][..4 * width];
                    for (r, codes) in codes.chunks_exact(width).enumerate() {
                        own[c][at + r] = match &product.decode[channel] {
                            Decode::Square(factor) => factor * one_way(codes, square, &sent[c]),
                            Decode::Table(values) => one_way(codes, |code| values[usize::from(code)], &sent[c]),
                        };
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn square(code: u16) -> f32 {
    f32::from(code) * f32::from(code)
}

/// Four rows times light, and light of the four rows' patches to the patches of all columns.
#[inline(always)]
fn both_ways(
    codes: &[u16],
    width: usize,
    value: impl Fn(u16) -> f32,
    sent: &Planar,
    receivers: &[[f32; 4]; 3],
    mirrored: &mut Planar,
) -> [[f32; 4]; 3] {
    let mut sums = [[[0.0; LANES]; 4]; 3];
    let rows: [&[[u16; LANES]]; 4] = std::array::from_fn(|r| codes[r * width..][..width].as_chunks().0);
    let sent = sent.each_ref().map(|x| &x.as_chunks::<LANES>().0[..width / LANES]);
    let mirrored = mirrored.each_mut().map(|y| &mut y.as_chunks_mut::<LANES>().0[..width / LANES]);
    for k in 0..width / LANES {
        let values: [Lanes; 4] = std::array::from_fn(|r| rows[r][k].map(&value));
        for c in 0..3 {
            let x = sent[c][k];
            let mut y = mirrored[c][k];
            for r in 0..4 {
                for lane in 0..LANES {
                    sums[c][r][lane] += values[r][lane] * x[lane];
                    y[lane] += values[r][lane] * receivers[c][r];
                }
            }
            mirrored[c][k] = y;
        }
    }
    sums.map(|rows| rows.map(across))
}

/// The texels of a diagonal block on and below the diagonal, and their mirror images.
#[inline(always)]
fn on_diagonal(texels: &[f32; 16], receivers: &[[f32; 4]; 3], sums: &mut [[f32; 4]; 3]) {
    for (sums, x) in sums.iter_mut().zip(receivers) {
        for (row, column) in (0..4).flat_map(|row| (0..=row).map(move |column| (row, column))) {
            sums[row] += texels[4 * row + column] * x[column];
            if row != column {
                sums[column] += texels[4 * row + column] * x[row];
            }
        }
    }
}

/// A row times light.
#[inline(always)]
fn one_way(codes: &[u16], value: impl Fn(u16) -> f32, sent: &[f32]) -> f32 {
    let mut sum = [0.0; LANES];
    for (codes, x) in codes.as_chunks::<LANES>().0.iter().zip(sent.as_chunks::<LANES>().0) {
        let values = codes.map(&value);
        for lane in 0..LANES {
            sum[lane] += values[lane] * x[lane];
        }
    }
    across(sum)
}

/// The sum across lanes, by halves.
#[inline(always)]
fn across(lanes: Lanes) -> f32 {
    let four: [f32; 4] = std::array::from_fn(|i| lanes[i] + lanes[i + 4]);
    (four[0] + four[2]) + (four[1] + four[3])
}

/// Uᵀ x of some members of a component.
struct Gather<'a> {
    block: &'a ColourBlock,
    members: std::ops::Range<usize>,
    x: &'a [[f32; 3]],
    to: &'a mut [f32],
}

impl WithSimd for Gather<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Gather { block, members, x, to } = self;
        to.fill(0.0);
        for member in members {
            let row = &block.basis[member * block.rank..][..block.rank];
            for (to, x) in to.chunks_exact_mut(block.rank).zip(x[block.patches[member] as usize]) {
                to.iter_mut().zip(row).for_each(|(to, u)| *to += u * x);
            }
        }
    }
}

/// Adds U times what a component carries to its members.
fn scatter(arch: Arch, block: &ColourBlock, carried: &[f32], y: &mut [[f32; 3]]) {
    // Members increase, so each run of patches has its own run of members.
    y.par_chunks_mut(GATHERED).enumerate().for_each(|(run, y)| {
        let first = block.patches.partition_point(|&p| (p as usize) < run * GATHERED);
        let end = block.patches.partition_point(|&p| (p as usize) < (run + 1) * GATHERED);
        arch.dispatch(Scatter { block, members: first..end, first: run * GATHERED, carried, y });
    });
}

struct Scatter<'a> {
    block: &'a ColourBlock,
    members: std::ops::Range<usize>,
    first: usize,
    carried: &'a [f32],
    y: &'a mut [[f32; 3]],
}

impl WithSimd for Scatter<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Scatter { block, members, first, carried, y } = self;
        for member in members {
            let row = &block.basis[member * block.rank..][..block.rank];
            let y = &mut y[block.patches[member] as usize - first];
            for (y, carried) in y.iter_mut().zip(carried.chunks_exact(block.rank)) {
                *y += dot(row, carried);
            }
        }
    }
}

#[inline(always)]
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    let mut sum = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sum[lane] += a[lane] * b[lane];
        }
    }
    across(sum) + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f32>()
}
