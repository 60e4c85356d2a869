//! Numbers of a few bits each in a string of bytes: the first number stands in the lowest bits.

use crate::{Error, Result};

/// Bytes that grow.
#[derive(Default)]
pub struct Writer {
    pub bytes: Vec<u8>,
    held: u64,
    count: u32,
}

impl Writer {
    /// Appends the lowest `bits` bits of `value`, 32 at most.
    pub fn put(&mut self, value: u32, bits: u32) {
        let value = u64::from(value) & ((1 << bits) - 1);
        self.held |= value << self.count;
        self.count += bits;
        while self.count >= 8 {
            self.bytes.push(self.held as u8);
            self.held >>= 8;
            self.count -= 8;
        }
    }

    pub fn put_f32(&mut self, value: f32) {
        self.put(value.to_bits(), 32);
    }

    /// Fills the last byte with zeros.
    pub fn align(&mut self) {
        if self.count > 0 {
            self.put(0, 8 - self.count);
        }
    }
}

/// Bytes that are read to their end.
pub struct Reader<'a> {
    bytes: &'a [u8],
    /// Bit that is read next.
    next: usize,
    /// What is being read, for errors.
    pub what: &'static str,
}

impl<'a> Reader<'a> {
    pub fn new(bytes: &'a [u8]) -> Reader<'a> {
        Reader { bytes, next: 0, what: "the header" }
    }

    /// Byte that is read next.
    pub fn at(&self) -> usize {
        self.next / 8
    }

    /// Refuses to go on unless so many numbers are there. Ask before memory is taken for them.
    pub fn need(&self, numbers: usize, bits: u32) -> Result<()> {
        let left = self.bytes.len() * 8 - self.next;
        match numbers.checked_mul(bits as usize) {
            Some(wanted) if wanted <= left => Ok(()),
            _ => Err(Error::Short { what: self.what, at: self.bytes.len() }),
        }
    }

    /// The next number of `bits` bits, 32 at most.
    pub fn get(&mut self, bits: u32) -> Result<u32> {
        self.need(1, bits)?;
        let first = self.next / 8;
        let mut word = [0; 8];
        let there = self.bytes.len().min(first + 8) - first;
        word[..there].copy_from_slice(&self.bytes[first..first + there]);
        let value = u64::from_le_bytes(word) >> (self.next % 8) & ((1 << bits) - 1);
        self.next += bits as usize;
        Ok(value as u32)
    }

    /// A finite number no larger than `most` either way.
    pub fn get_f32(&mut self, most: f32) -> Result<f32> {
        let value = f32::from_bits(self.get(32)?);
        if value.abs() <= most { Ok(value) } else { self.damaged(value.to_string(), "a finite number of usual size") }
    }

    /// Goes to the next whole byte.
    pub fn align(&mut self) {
        self.next = self.next.next_multiple_of(8);
    }

    pub fn damaged<T>(&self, found: String, expected: &'static str) -> Result<T> {
        Err(Error::Damaged { what: self.what, found, expected, at: self.at() })
    }

    /// Refuses bytes that nobody reads.
    pub fn finish(self) -> Result<()> {
        if self.at() == self.bytes.len() {
            return Ok(());
        }
        let left = self.bytes.len() - self.at();
        Err(Error::Damaged { what: "the end", found: format!("{left} more bytes"), expected: "none", at: self.at() })
    }
}
