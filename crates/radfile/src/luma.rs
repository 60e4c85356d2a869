//! Luma of colours, and the entries of an operator in all channels.

use crate::Operator;

/// Weights of red, green and blue in luma (ITU-R BT.709).
pub const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Luma of three numbers; equal ones give themselves.
pub fn luma([red, green, blue]: [f32; 3]) -> f32 {
    green + LUMA[0] * (red - green) + LUMA[2] * (blue - green)
}

impl Operator<'_> {
    /// An entry in red, green and blue; those of grey operators are equal.
    pub fn entry(&self, row: usize, column: usize) -> [f32; 3] {
        [0, 1, 2].map(|c| self.channel(c)[row * self.n + column])
    }
}
