//! Where a container's bytes live: a mapped file or aligned memory.
//!
//! The one `unsafe` line of this crate is the memory map.

use std::fs::File;

/// Bytes that start at a multiple of eight, so that every element type can be viewed in place.
pub enum Bytes {
    Mapped(memmap2::Mmap),
    Owned { words: Vec<u64>, length: usize },
}

impl Bytes {
    /// Maps a file for reading.
    pub fn map(file: &File) -> std::io::Result<Bytes> {
        if file.metadata()?.len() == 0 {
            return Ok(Bytes::copy(&[])); // an empty file cannot be mapped
        }
        // SAFETY: the map is read-only. Another process that shortens the file while it is
        // mapped can still end this one (SIGBUS); writers of this crate never do that, they
        // write a new file and rename it over the old one.
        Ok(Bytes::Mapped(unsafe { memmap2::Mmap::map(file)? }))
    }

    /// Copies bytes into aligned memory.
    pub fn copy(bytes: &[u8]) -> Bytes {
        Self::filled(bytes.len(), |memory| memory.copy_from_slice(bytes))
    }

    /// Aligned memory of `length` bytes that `fill` writes.
    pub fn filled(length: usize, fill: impl FnOnce(&mut [u8])) -> Bytes {
        let mut words = vec![0u64; length.div_ceil(8)];
        fill(&mut bytemuck::cast_slice_mut(&mut words)[..length]);
        Bytes::Owned { words, length }
    }

    /// The bytes.
    pub fn as_slice(&self) -> &[u8] {
        match self {
            Bytes::Mapped(map) => map,
            Bytes::Owned { words, length } => &bytemuck::cast_slice(words)[..*length],
        }
    }
}
