//! Entries one by one: codes of their square roots, and the few large ones apart.
//!
//! An entry is top · (code / largest code)². Square roots spread the codes as the entries are spread, which loses
//! less light than even steps or logarithms; without what exceeds three times the root mean square, the steps of
//! the others are finer.

use half::f16;

use crate::{
    Result,
    bits::{Reader, Writer},
};

/// Bits that a code may have.
pub const BITS: [u32; 5] = [2, 3, 4, 6, 8];
/// Entries of a tile, so that 16 bits number them.
pub const MOST: usize = 1 << 16;
/// Entries above so many root mean squares stand apart.
const LARGE: f32 = 3.0;

/// Non-negative entries, coded. Values are in units of the operator.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    pub bits: u32,
    /// Value of the largest code.
    pub top: f16,
    pub codes: Vec<u8>,
    /// Number and value of entries that stand apart; their codes are 0.
    pub apart: Vec<(u16, f16)>,
}

/// Largest code.
fn steps(bits: u32) -> f32 {
    ((1 << bits) - 1) as f32
}

impl Tile {
    /// Codes `entries`; there are no more than [`MOST`].
    pub fn new(entries: &[f32], unit: f32, bits: u32) -> Tile {
        let square: f64 = entries.iter().map(|&v| f64::from(v) * f64::from(v)).sum();
        let cut = LARGE * (square / entries.len() as f64).sqrt() as f32;
        let top = entries.iter().filter(|v| **v <= cut).fold(0.0f32, |top, &v| top.max(v));
        let top = f16::from_f32(top / unit);
        let scale = unit * top.to_f32();
        let code = |v: f32| ((v / scale).sqrt() * steps(bits)).round().min(steps(bits)) as u8;
        let codes = entries.iter().map(|&v| if v > cut || scale == 0.0 { 0 } else { code(v) }).collect();
        let apart = entries.iter().enumerate().filter(|(_, v)| **v > cut);
        let apart = apart.map(|(at, &v)| (at as u16, f16::from_f32(v / unit))).collect();
        Tile { bits, top, codes, apart }
    }

    /// Factor of the squared codes.
    pub fn scale(&self, unit: f32) -> f32 {
        unit * self.top.to_f32() / (steps(self.bits) * steps(self.bits))
    }

    /// What the codes stand for.
    pub fn entries(&self, unit: f32) -> Vec<f32> {
        let scale = self.scale(unit);
        let mut entries: Vec<f32> = self.codes.iter().map(|&c| scale * f32::from(c) * f32::from(c)).collect();
        self.apart.iter().for_each(|&(at, v)| entries[usize::from(at)] = unit * v.to_f32());
        entries
    }

    /// Bytes of the codes without those that say what a block is.
    pub fn bytes(&self) -> usize {
        4 + 4 * self.apart.len() + (self.codes.len() * self.bits as usize).div_ceil(8)
    }

    pub fn write(&self, out: &mut Writer) {
        out.put(self.top.to_bits().into(), 16);
        out.put(self.apart.len() as u32, 16);
        for &(at, value) in &self.apart {
            out.put(at.into(), 16);
            out.put(value.to_bits().into(), 16);
        }
        self.codes.iter().for_each(|&code| out.put(code.into(), self.bits));
        out.align();
    }

    /// Reads `count` entries.
    pub fn read(input: &mut Reader, count: usize, bits: u32) -> Result<Tile> {
        let top = positive(input)?;
        let large = input.get(16)? as usize;
        input.need(large, 32)?;
        let mut apart: Vec<(u16, f16)> = Vec::with_capacity(large);
        for _ in 0..large {
            let at = input.get(16)?;
            if at as usize >= count || apart.last().is_some_and(|last| u32::from(last.0) >= at) {
                return input.damaged(format!("entry {at}"), "an entry of the tile after the one before");
            }
            apart.push((at as u16, positive(input)?));
        }
        input.need(count, bits)?;
        let codes = (0..count).map(|_| Ok(input.get(bits)? as u8)).collect::<Result<_>>()?;
        input.align();
        Ok(Tile { bits, top, codes, apart })
    }
}

fn positive(input: &mut Reader) -> Result<f16> {
    let value = f16::from_bits(input.get(16)? as u16);
    if value.is_finite() && value >= f16::ZERO {
        return Ok(value);
    }
    input.damaged(value.to_string(), "a finite number ≥ 0")
}
