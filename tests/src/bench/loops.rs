//! The inner loops of the dense rivals, with the vector instructions that the processor has (AVX2 on x86).
//!
//! Matrices of thousands of rows come from memory, not from a cache, so a loop is good if it asks for every entry
//! once and for several rows at a time: [`four_rows`] serves three colours with each entry that it loads.

use pulp::{Arch, Simd, WithSimd};

/// Rows that [`four_rows`] takes side by side: with three colours they fill the sixteen registers of AVX2.
pub const ROWS: usize = 4;
/// Independent sums of [`decoded`].
const LANES: usize = 32;

/// Four rows times light in three colours.
pub fn four_rows(arch: Arch, rows: [&[f32]; ROWS], x: [&[f32]; 3]) -> [[f32; 3]; ROWS] {
    arch.dispatch(FourRows { rows, x })
}

struct FourRows<'a> {
    rows: [&'a [f32]; ROWS],
    x: [&'a [f32]; 3],
}

impl WithSimd for FourRows<'_> {
    type Output = [[f32; 3]; ROWS];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [[f32; 3]; ROWS] {
        let rows = self.rows.map(S::as_simd_f32s);
        let x = self.x.map(S::as_simd_f32s);
        let count = x[0].0.len();
        let (row, light) = (rows.map(|r| &r.0[..count]), x.map(|x| &x.0[..count]));
        let mut sum = [[simd.splat_f32s(0.0); 3]; ROWS];
        for k in 0..count {
            let light = light.map(|x| x[k]);
            for (sum, row) in sum.iter_mut().zip(&row) {
                for (sum, light) in sum.iter_mut().zip(light) {
                    *sum = simd.mul_add_f32s(row[k], light, *sum);
                }
            }
        }
        let rest = |r: usize, c: usize| rows[r].1.iter().zip(x[c].1).map(|(f, x)| f * x).sum::<f32>();
        std::array::from_fn(|r| std::array::from_fn(|c| simd.reduce_sum_f32s(sum[r][c]) + rest(r, c)))
    }
}

/// One row of codes times light in one colour.
pub fn one_row<T: Code>(arch: Arch, row: &[T], x: &[f32]) -> f32 {
    arch.dispatch(OneRow { row, x })
}

/// What an entry of a matrix is stored as.
pub trait Code: Copy + Send + Sync {
    /// The entry in units of its matrix. A few operations without branches, so that they become vector instructions.
    fn decode(self) -> f32;
}

struct OneRow<'a, T> {
    row: &'a [T],
    x: &'a [f32],
}

impl<T: Code> WithSimd for OneRow<'_, T> {
    type Output = f32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f32 {
        let mut sum = [0.0f32; LANES];
        let ((row, row_rest), (x, x_rest)) = (self.row.as_chunks::<LANES>(), self.x.as_chunks::<LANES>());
        for (row, x) in row.iter().zip(x) {
            for lane in 0..LANES {
                sum[lane] += row[lane].decode() * x[lane];
            }
        }
        across(&sum) + row_rest.iter().zip(x_rest).map(|(k, x)| k.decode() * x).sum::<f32>()
    }
}

/// Apart, for the compiler else arranges the lanes of the loop for this sum, which is slow.
#[inline(never)]
fn across(lanes: &[f32; LANES]) -> f32 {
    lanes.iter().sum()
}
