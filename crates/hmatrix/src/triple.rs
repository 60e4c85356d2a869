//! Singular triples in a few bits.

use half::f16;

use crate::{
    Result,
    bits::{Reader, Writer},
    sketch::Triple,
    small::dot,
    stretch::Stretch,
};

/// Bits that the codes of a triple may have.
pub const BITS: [u32; 4] = [3, 4, 6, 8];

/// A term scale · c_u c_vᵀ of a block, c in ±1.
#[derive(Clone, Debug, PartialEq)]
pub struct Coded {
    /// Index into [`BITS`].
    pub bits: usize,
    /// In units of the operator; negative only in symmetric blocks.
    pub scale: f16,
    /// Those of the rows, then those of the columns; in symmetric blocks one for both.
    pub codes: Vec<i8>,
}

/// Largest code.
pub fn top(bits: u32) -> f32 {
    ((1i32 << (bits - 1)) - 1) as f32
}

/// Even steps between ± the largest magnitude.
pub fn quantise(x: &[f64], bits: u32) -> Vec<i8> {
    let largest = x.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let factor = if largest > 0.0 { f64::from(top(bits)) / largest } else { 0.0 };
    x.iter().map(|v| (v * factor).round() as i8).collect()
}

/// The triple of a stretched block in codes, and the square of the stretched error. `sides` are rows and columns.
pub fn code(triple: &Triple, unit: f32, bits: usize, sides: &[Stretch; 2]) -> (Coded, f64) {
    let part = |x: &[f32], side: &Stretch| {
        let exact: Vec<f64> = x.iter().map(|&v| f64::from(v)).collect();
        let mut plain = exact.clone();
        side.undo(&mut plain);
        let codes = quantise(&plain, BITS[bits]);
        let mut decoded: Vec<f64> = codes.iter().map(|&c| f64::from(c) / f64::from(top(BITS[bits]))).collect();
        side.apply(&mut decoded);
        (codes, dot(&exact, &decoded), dot(&decoded, &decoded))
    };
    let (mut codes, along_u, size_u) = part(&triple.u, &sides[0]);
    let (along_v, size_v) = if triple.v.is_empty() {
        (along_u, size_u)
    } else {
        let (codes_v, along, size) = part(&triple.v, &sides[1]);
        codes.extend(codes_v);
        (along, size)
    };
    // Least squares for the scale, then what is left: ‖σ u vᵀ − s c_u c_vᵀ‖².
    let best = triple.sigma * along_u * along_v / (size_u * size_v);
    let scale = f16::from_f64(best / f64::from(unit));
    let scale = if scale.is_finite() { scale } else { f16::ZERO };
    let s = f64::from(unit) * f64::from(scale);
    let error = triple.sigma.powi(2) + s * s * size_u * size_v - 2.0 * triple.sigma * s * along_u * along_v;
    (Coded { bits, scale, codes }, error.max(0.0))
}

impl Coded {
    /// Factor of products of two codes.
    pub fn factor(&self, unit: f32) -> f32 {
        unit * self.scale.to_f32() / top(BITS[self.bits]).powi(2)
    }

    pub fn write_codes(&self, out: &mut Writer) {
        self.codes.iter().for_each(|&code| out.put(code as u32, BITS[self.bits]));
    }

    /// Reads `count` codes of a triple whose scale is known.
    pub fn read_codes(input: &mut Reader, bits: usize, scale: f16, count: usize) -> Result<Coded> {
        Ok(Coded { bits, scale, codes: read_codes(input, BITS[bits], count)? })
    }
}

/// Reads signed codes.
pub fn read_codes(input: &mut Reader, bits: u32, count: usize) -> Result<Vec<i8>> {
    input.need(count, bits)?;
    let unused = 8 - bits;
    // The sign stands in the highest of the bits.
    (0..count).map(|_| Ok(((input.get(bits)? << unused) as u8 as i8) >> unused)).collect()
}
