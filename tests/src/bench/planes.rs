//! K itself, one plane a channel, in three kinds of numbers: what storing the solution of all bounces costs.
//!
//! `u8-log` is the paper's map without its block compression: v = s exp(6 (u − 1)) with u in 255 steps, 0 for
//! what is smaller, and the largest 1 % of each channel apart (for all channels if for one), as column, three f16.

use half::f16;
use pulp::Arch;
use radfile::Operator;
use rayon::prelude::*;

use super::{
    Product,
    loops::{Code, one_row},
};

/// Rows that a task handles.
const TASK: usize = 16;
/// Span of the logarithm, and the share of entries that are apart: those of the paper's format.
const SHIFT: f32 = 6.0;
const APART: f64 = 0.01;

/// K in codes.
pub struct Planes<'a, T: Clone> {
    n: usize,
    /// A matrix a channel.
    codes: Vec<std::borrow::Cow<'a, [T]>>,
    /// Value of code 1.
    unit: Vec<f32>,
    apart: Apart,
    x: [Vec<f32>; 3],
    arch: Arch,
}

/// Entries that are stored apart, row after row.
#[derive(Default)]
struct Apart {
    start: Vec<u32>,
    column: Vec<u16>,
    /// In units of the channel, 1024th parts of f16's range.
    value: Vec<[f16; 3]>,
}

impl Code for f32 {
    #[inline(always)]
    fn decode(self) -> f32 {
        self
    }
}

/// A number of half precision that is not negative, as its bits.
#[derive(Clone, Copy)]
pub struct Half(u16);

impl Code for Half {
    /// Shifted to the place of f32, its exponent is 112 too small; so are numbers below the normal ones.
    #[inline(always)]
    fn decode(self) -> f32 {
        const UP: f32 = f32::from_bits((127 + 112) << 23);
        f32::from_bits(u32::from(self.0) << 13) * UP
    }
}

/// A step of the logarithm.
#[derive(Clone, Copy)]
pub struct Logarithm(u8);

impl Logarithm {
    fn encode(value: f32) -> Logarithm {
        let u = 1.0 + value.ln() / SHIFT;
        Logarithm(if value > 0.0 { (255.0 * u).round().clamp(0.0, 255.0) as u8 } else { 0 })
    }
}

impl Code for Logarithm {
    /// 2^t by a polynomial: a table would be asked for one entry at a time.
    #[inline(always)]
    fn decode(self) -> f32 {
        const STEP: f32 = SHIFT * std::f32::consts::LOG2_E / 255.0;
        // Adding this rounds to whole numbers, which stand in the last bits.
        const WHOLE: f32 = 12_582_912.0;
        let t = STEP * (f32::from(self.0) - 255.0);
        let shifted = t + WHOLE;
        let f = t - (shifted - WHOLE);
        let power = shifted.to_bits() << 23;
        // Taylor series of 2^f for |f| ≤ 1/2, exact to 3e-6.
        let p = 1.0
            + f * (std::f32::consts::LN_2
                + f * (0.240_226_5 + f * (0.055_504_11 + f * (0.009_618_13 + f * 0.001_333_36))));
        let value = f32::from_bits(p.to_bits().wrapping_add(power));
        if self.0 == 0 { 0.0 } else { value }
    }
}

impl<'a> Planes<'a, f32> {
    /// As it is.
    pub fn single(operator: &'a Operator) -> Planes<'a, f32> {
        let codes = (0..operator.channels).map(|c| operator.channel(c).into()).collect();
        Planes::new(operator.n, codes, vec![1.0; operator.channels], Apart::none(operator.n))
    }
}

impl Planes<'_, Half> {
    /// Rounded to half precision, in units of the largest entry of its channel.
    pub fn half(operator: &Operator) -> Planes<'static, Half> {
        let unit: Vec<f32> = (0..operator.channels).map(|c| largest(operator.channel(c))).collect();
        let code = |(c, unit): (usize, &f32)| {
            operator.channel(c).par_iter().map(|k| Half(f16::from_f32(k / unit).to_bits())).collect::<Vec<_>>().into()
        };
        let codes = unit.iter().enumerate().map(code).collect();
        Planes::new(operator.n, codes, unit, Apart::none(operator.n))
    }
}

impl Planes<'_, Logarithm> {
    /// In 255 steps of a logarithm.
    pub fn logarithm(operator: &Operator) -> Planes<'static, Logarithm> {
        let n = operator.n;
        let unit: Vec<f32> = (0..operator.channels).map(|c| quantile(operator.channel(c), APART)).collect();
        let apart = |at: usize| unit.iter().enumerate().any(|(c, unit)| operator.channel(c)[at] > *unit);
        let mut list = Apart { start: vec![0], ..Apart::default() };
        let columns = |i: usize| (0..n).filter(|j| apart(i * n + j)).map(|j| j as u16).collect::<Vec<_>>();
        let rows: Vec<Vec<u16>> = (0..n).into_par_iter().map(columns).collect();
        for (i, columns) in rows.iter().enumerate() {
            list.column.extend(columns);
            list.value.extend(columns.iter().map(|&j| {
                let channel = |c: usize| c.min(operator.channels - 1);
                [0, 1, 2].map(|c| f16::from_f32(operator.channel(c)[i * n + j as usize] / unit[channel(c)]))
            }));
            list.start.push(list.column.len() as u32);
        }
        let code = |(c, unit): (usize, &f32)| {
            let codes = operator.channel(c).par_iter().enumerate();
            codes
                .map(|(at, k)| if apart(at) { Logarithm(0) } else { Logarithm::encode(k / unit) })
                .collect::<Vec<_>>()
                .into()
        };
        let codes = unit.iter().enumerate().map(code).collect();
        Planes::new(n, codes, unit, list)
    }
}

impl<'a, T: Code> Planes<'a, T> {
    fn new(n: usize, codes: Vec<std::borrow::Cow<'a, [T]>>, unit: Vec<f32>, apart: Apart) -> Planes<'a, T> {
        Planes { n, codes, unit, apart, x: std::array::from_fn(|_| vec![0.0; n]), arch: Arch::new() }
    }

    /// Bytes of the codes and of what is apart.
    pub fn bytes(&self) -> usize {
        let apart = match self.apart.column.len() {
            0 => 0,
            _ => 4 * self.apart.start.len() + 2 * self.apart.column.len() + 6 * self.apart.value.len(),
        };
        self.codes.iter().map(|plane| size_of_val(&plane[..])).sum::<usize>() + apart
    }

    fn row(&self, i: usize) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for (c, sum) in sum.iter_mut().enumerate() {
            let plane = &self.codes[c.min(self.codes.len() - 1)];
            *sum = one_row(self.arch, &plane[i * self.n..][..self.n], &self.x[c]);
        }
        for at in self.apart.start[i] as usize..self.apart.start[i + 1] as usize {
            let j = self.apart.column[at] as usize;
            (0..3).for_each(|c| sum[c] += self.apart.value[at][c].to_f32() * self.x[c][j]);
        }
        std::array::from_fn(|c| sum[c] * self.unit[c.min(self.unit.len() - 1)])
    }
}

impl Apart {
    fn none(n: usize) -> Apart {
        Apart { start: vec![0; n + 1], ..Apart::default() }
    }
}

impl<T: Code> Product for Planes<'_, T> {
    fn multiply(&mut self, x: &[[f32; 3]], y: &mut [[f32; 3]]) {
        for (c, plane) in self.x.iter_mut().enumerate() {
            plane.iter_mut().zip(x).for_each(|(plane, x)| *plane = x[c]);
        }
        let rows = &*self;
        y.par_chunks_mut(TASK).enumerate().for_each(|(task, y)| {
            y.iter_mut().enumerate().for_each(|(i, y)| *y = rows.row(task * TASK + i));
        });
    }
}

fn largest(values: &[f32]) -> f32 {
    values.par_iter().copied().reduce(|| f32::MIN_POSITIVE, f32::max)
}

/// The value that a share of all exceed.
fn quantile(values: &[f32], share: f64) -> f32 {
    let mut values = values.to_vec();
    let rank = (((1.0 - share) * values.len() as f64) as usize).min(values.len() - 1);
    *values.select_nth_unstable_by(rank, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_half_and_every_step_of_the_logarithm_means_what_it_says() {
        for bits in 0..=f16::MAX.to_bits() {
            assert_eq!(Half(bits).decode(), f16::from_bits(bits).to_f32(), "{bits:#x}");
        }
        assert_eq!(Logarithm(0).decode(), 0.0);
        for code in 1..=255u8 {
            let exact = (f64::from(SHIFT) * (f64::from(code) / 255.0 - 1.0)).exp();
            let error = f64::from(Logarithm(code).decode()) / exact - 1.0;
            assert!(error.abs() < 1e-5, "code {code} is off by {error}");
            let back = Logarithm::encode(exact as f32).0;
            assert_eq!(back, code, "code {code} is encoded as {back}");
        }
    }

    /// Three of ten thousand entries are as large as 1, so they are apart and the others keep all of their codes.
    #[test]
    fn planes_multiply_as_their_matrix() {
        let n = 100;
        let entry =
            |at: usize| if at.is_multiple_of(4096) { 1.0 } else { 1e-3 * (1.0 + (at * 37 % 101) as f32 / 50.0) };
        let values: Vec<f32> = (0..3 * n * n).map(|at| entry(at % (n * n))).collect();
        let operator = Operator { n, channels: 3, bounces: None, values: values.into() };
        let x: Vec<[f32; 3]> = (0..n).map(|i| [1.0, i as f32, ((i * 7) % 11) as f32]).collect();
        let check = |product: &mut dyn Product, limit: f64| {
            let mut y = vec![[0.0; 3]; n];
            product.multiply(&x, &mut y);
            for (i, y) in y.iter().enumerate() {
                for c in 0..3 {
                    let row = &operator.channel(c)[i * n..][..n];
                    let exact: f64 = row.iter().zip(&x).map(|(k, x)| f64::from(*k) * f64::from(x[c])).sum();
                    let error = (f64::from(y[c]) / exact - 1.0).abs();
                    assert!(error < limit, "row {i}, channel {c}: off by {error}");
                }
            }
        };
        check(&mut Planes::single(&operator), 1e-6);
        check(&mut Planes::half(&operator), 1e-3);
        check(&mut Planes::logarithm(&operator), 1.2e-2);
    }
}
