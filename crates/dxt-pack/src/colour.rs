//! The colour of an operator as a shared basis of low rank.
//!
//! Each plane P of the colour becomes U C Uᵀ, with one U for both. What matters is the error of light, and light
//! leaves patches in proportion to their reflectance: so S P S is approximated, S² the luma of the reflectance, and U
//! is scaled back. Its range is found by subspace iterations on a random sketch (N. Halko, P. Martinsson, J. Tropp,
//! Finding structure with randomness, SIAM Review 53(2), 2011, algorithm 4.4) of (S P_1 S)² + (S P_2 S)², whose first
//! vector is light that is the same everywhere. Columns are sorted by what they hold, so every shorter basis is the
//! start of the longest one. Components of the operator are taken apart, so nothing passes between sealed rooms.

use radfile::{Colour, NO_COMPONENT, Operator, Patches, Progress, luma, rounded, unit_of};
use rayon::prelude::*;

use crate::small::{backward, cholesky, eigen, forward, product, transposed};

/// Columns of the largest basis.
pub const MOST_COLUMNS: usize = 128;
/// Columns that the sketch has more than the basis.
const MORE: usize = 8;
/// Applications of the squared planes to the sketch, the first included.
const ITERATIONS: u64 = 3;
/// Least weight of a patch: a black one may be lit, and what it receives is seen.
const LEAST_REFLECTANCE: f32 = 0.02;
/// Rows that share what they read.
const ROWS: usize = 4;
/// Columns that hold less than this share of the square of luma hold rounding.
const ROUNDING: f64 = 1e-13;

/// The longest basis of every component.
pub struct Basis<'a> {
    operator: &'a Operator<'a>,
    axes: Vec<[f32; 3]>,
    components: Vec<Component>,
}

/// One component. Matrices of patches are row-major.
struct Component {
    patches: Vec<u32>,
    /// S.
    weight: Vec<f64>,
    /// Q, orthonormal, patches × `width`.
    range: Vec<f64>,
    width: usize,
    /// Squares of S P S that the columns hold once Q is turned, relative to the square of luma; largest first.
    held: Vec<f64>,
    /// Turns Q so that its columns hold most first.
    turn: Vec<f64>,
    /// Qᵀ S P S Q of each plane.
    inner: Vec<Vec<f64>>,
}

/// Bytes that [`Basis::new`] takes.
pub fn memory_needed(n: usize) -> u64 {
    // Sketch, its image for each plane, and the range.
    4 * 8 * n as u64 * (MOST_COLUMNS + MORE) as u64
}

impl<'a> Basis<'a> {
    /// The basis of an operator whose colour has these axes.
    pub fn new(operator: &'a Operator, patches: &Patches, axes: Vec<[f32; 3]>, progress: &dyn Progress) -> Basis<'a> {
        let groups = if axes.is_empty() { Vec::new() } else { operator.components() };
        progress.begin("finding the basis of colour", groups.len() as u64 * (2 * ITERATIONS + 1));
        let mut basis = Basis { operator, axes, components: Vec::new() };
        let components = groups.into_iter().map(|group| basis.component(group, patches, progress)).collect();
        basis.components = components;
        basis
    }

    fn component(&self, group: Vec<u32>, patches: &Patches, progress: &dyn Progress) -> Component {
        let width = (MOST_COLUMNS + MORE).min(group.len());
        let weight: Vec<f64> = group
            .iter()
            .map(|&i| f64::from(luma(patches.reflectance[i as usize]).max(LEAST_REFLECTANCE)).sqrt())
            .collect();
        let mut component =
            Component { patches: group, weight, range: Vec::new(), width, held: vec![], turn: vec![], inner: vec![] };
        component.range = component.sketch(&patches.area);
        for _ in 0..ITERATIONS {
            let once = self.apply(&component, &vec![&component.range[..]; self.axes.len()]);
            progress.advance(1);
            let again = self.apply(&component, &once.iter().map(|plane| &plane[..]).collect::<Vec<_>>());
            progress.advance(1);
            component.range = orthonormal(sum(again), width);
        }
        let images = self.apply(&component, &vec![&component.range[..]; self.axes.len()]);
        progress.advance(1);
        let squares = sum(images.iter().map(|image| gram(image, image, width)).collect());
        component.inner = images.iter().map(|image| gram(&component.range, image, width)).collect();
        (component.held, component.turn) = eigen(squares, width);
        let luma = self.square_of_luma(&component);
        component.held.iter_mut().for_each(|h| *h /= luma);
        component
    }

    /// Square of S K_Y S. Small rooms are judged by their own light, so the square of colour is held against it.
    fn square_of_luma(&self, c: &Component) -> f64 {
        let members = || c.patches.iter().zip(&c.weight);
        let of_row = |(&i, s): (&u32, &f64)| -> f64 {
            let entry =
                |(&j, t): (&u32, &f64)| (s * t * f64::from(luma(self.operator.entry(i as usize, j as usize)))).powi(2);
            members().map(entry).sum()
        };
        members().map(of_row).sum::<f64>().max(f64::MIN_POSITIVE)
    }

    /// S P S times a matrix for each plane.
    fn apply(&self, c: &Component, matrices: &[&[f64]]) -> Vec<Vec<f64>> {
        let (width, planes, m) = (c.width, self.axes.len(), c.patches.len());
        let rows: Vec<Vec<f64>> = (0..m.div_ceil(ROWS))
            .into_par_iter()
            .map(|block| {
                let rows = ROWS * block..m.min(ROWS * (block + 1));
                let mut sums = vec![0.0; planes * rows.len() * width];
                for j in 0..m {
                    let mut sums = sums.chunks_exact_mut(width);
                    for i in rows.clone() {
                        let both = c.weight[i] * c.weight[j];
                        let k = self.operator.entry(c.patches[i] as usize, c.patches[j] as usize);
                        let y = luma(k);
                        for (axis, matrix) in self.axes.iter().zip(matrices) {
                            let value: f64 = (0..3).map(|ch| f64::from(axis[ch] * (k[ch] - y))).sum();
                            let (value, row) = (both * value, &matrix[j * width..][..width]);
                            let sum = sums.next().expect("a sum a row and plane");
                            sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += value * x);
                        }
                    }
                }
                sums
            })
            .collect();
        let of_plane = |plane: usize| {
            let sums = rows.iter().flat_map(|sums| sums.chunks_exact(width).skip(plane).step_by(planes));
            sums.flatten().copied().collect()
        };
        (0..planes).map(of_plane).collect()
    }

    /// What the columns of the largest component hold, most first: where a basis may end.
    pub fn held(&self) -> Vec<f64> {
        let coloured = |c: &&Component| c.held.first().is_some_and(|h| *h > ROUNDING);
        let largest = self.components.iter().filter(coloured).max_by_key(|c| c.patches.len());
        let held = largest.map_or(&[][..], |c| &c.held);
        held.iter().copied().take(MOST_COLUMNS).take_while(|h| *h > ROUNDING).collect()
    }

    /// The colour with the columns that hold at least `least`.
    pub fn colour(&self, least: f64) -> Colour<'static> {
        let n = self.operator.n;
        let mut component = vec![NO_COMPONENT; n];
        let (mut scale, mut rank, mut codes) = (vec![0.0; n], Vec::new(), Vec::new());
        let mut cores = vec![Vec::new(); self.axes.len()];
        let mut chosen = Vec::new();
        for c in &self.components {
            let columns = c.held.iter().take(MOST_COLUMNS).filter(|h| **h >= least).count();
            if columns > 0 {
                c.patches.iter().for_each(|&i| component[i as usize] = chosen.len() as u16);
                rank.push(columns as u32);
                let rows = c.unweighted(columns);
                for (&i, row) in c.patches.iter().zip(rows.chunks_exact(columns)) {
                    scale[i as usize] = row.iter().map(|u| u * u).sum::<f64>().sqrt() as f32;
                }
                chosen.push((c, columns, rows));
            }
        }
        if rank.is_empty() {
            return Colour::default();
        }
        let unit = unit_of(&scale);
        scale.iter_mut().for_each(|s| *s = rounded(*s, unit));
        for (c, columns, rows) in &chosen {
            let (of_component, decoded) = quantised(&c.patches, *columns, rows, &scale);
            codes.extend(of_component);
            for (core, inner) in cores.iter_mut().zip(c.cores(&decoded, *columns)) {
                core.extend(inner);
            }
        }
        let mut core: Vec<f32> = cores.concat().into_iter().map(|v| v as f32).collect();
        let unit = unit_of(&core);
        core.iter_mut().for_each(|v| *v = rounded(*v, unit));
        Colour {
            axes: self.axes.clone(),
            component: component.into(),
            rank,
            scale: scale.into(),
            codes: codes.into(),
            core: core.into(),
        }
    }
}

impl Component {
    /// Random signs; the first column is light that is the same everywhere.
    fn sketch(&self, area: &[f32]) -> Vec<f64> {
        let mut state = 0x9e37_79b9_7f4a_7c15u64;
        let mut sign = || {
            // Marsaglia's xorshift64.
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            if state >> 63 == 0 { 1.0 } else { -1.0 }
        };
        let rows = self.patches.iter().zip(&self.weight);
        rows.flat_map(|(&i, s)| {
            let uniform = f64::from(area[i as usize]).sqrt() / s;
            let row: Vec<f64> = (0..self.width).map(|k| if k == 0 { uniform } else { sign() }).collect();
            row
        })
        .collect()
    }

    /// S⁻¹ Q V, the first columns of it.
    fn unweighted(&self, columns: usize) -> Vec<f64> {
        let turn: Vec<f64> = self.turn.chunks_exact(self.width).flat_map(|row| &row[..columns]).copied().collect();
        let mut rows = product(&self.range, &turn, self.width, columns);
        for (row, s) in rows.chunks_exact_mut(columns).zip(&self.weight) {
            row.iter_mut().for_each(|u| *u /= s);
        }
        rows
    }

    /// Lower halves of the cores that serve a decoded basis best: with B = S U, (BᵀB)⁻¹ Bᵀ (S P S) B (BᵀB)⁻¹.
    fn cores(&self, decoded: &[f64], columns: usize) -> Vec<Vec<f64>> {
        let weighted = decoded.chunks_exact(columns).zip(&self.weight);
        let weighted: Vec<f64> = weighted.flat_map(|(row, s)| row.iter().map(move |u| u * s)).collect();
        let l = cholesky(&product(&transposed(&weighted, columns), &weighted, self.patches.len(), columns), columns);
        // (BᵀB)⁻¹ Bᵀ Q, a column at a time.
        let right = product(&transposed(&weighted, columns), &self.range, self.patches.len(), self.width);
        let mut solved = transposed(&right, self.width);
        for column in solved.chunks_exact_mut(columns) {
            forward(&l, column);
            backward(&l, column);
        }
        let left = transposed(&solved, columns);
        let core = |inner: &Vec<f64>| {
            let core = product(&product(&left, inner, self.width, self.width), &solved, self.width, columns);
            let lower = (0..columns).flat_map(|i| (0..=i).map(move |k| (i, k)));
            lower.map(|(i, k)| 0.5 * (core[i * columns + k] + core[k * columns + i])).collect()
        };
        self.inner.iter().map(core).collect()
    }
}

/// Codes of U, column after column, and U as they will be read.
fn quantised(patches: &[u32], columns: usize, rows: &[f64], scale: &[f32]) -> (Vec<u8>, Vec<f64>) {
    let relative = |row: usize, column: usize| match f64::from(scale[patches[row] as usize]) {
        0.0 => 0.0,
        scale => rows[row * columns + column] / scale,
    };
    let mut codes = Vec::with_capacity(rows.len());
    let mut decoded = vec![0.0; rows.len()];
    for column in 0..columns {
        let largest = (0..patches.len()).map(|row| relative(row, column).abs()).fold(f64::MIN_POSITIVE, f64::max);
        for row in 0..patches.len() {
            let code = (127.0 * relative(row, column) / largest).round();
            codes.push((code as i8).cast_unsigned());
            decoded[row * columns + column] = code / 127.0 * f64::from(scale[patches[row] as usize]);
        }
    }
    (codes, decoded)
}

fn sum(matrices: Vec<Vec<f64>>) -> Vec<f64> {
    let add = |mut a: Vec<f64>, b: Vec<f64>| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        a
    };
    matrices.into_iter().reduce(add).expect("a plane")
}

/// aᵀ b of two matrices with `width` columns.
fn gram(a: &[f64], b: &[f64], width: usize) -> Vec<f64> {
    product(&transposed(a, width), b, a.len() / width, width)
}

/// An orthonormal basis of the columns, 0 where they depend on others; twice, as once leaves the square of the
/// condition.
fn orthonormal(mut a: Vec<f64>, width: usize) -> Vec<f64> {
    for _ in 0..2 {
        let l = cholesky(&gram(&a, &a, width), width);
        a.par_chunks_exact_mut(width).for_each(|row| forward(&l, row));
    }
    a
}
