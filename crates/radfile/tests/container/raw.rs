//! Edits a file behind the back of the checks: any field can be set, checksums are then made right again.
//!
//! Offsets are those of `formats/rad.md` §2 and §3, written out a second time on purpose.

pub const SECTION_COUNT: usize = 12;
pub const TABLE_OFFSET: usize = 16;
pub const FILE_LENGTH: usize = 24;
pub const RESERVED: usize = 40;
pub const HEADER: usize = 64;
pub const ENTRY: usize = 96;

/// Fields of a table entry.
pub const NAME: usize = 0;
pub const ELEMENT: usize = 32;
pub const FLAGS: usize = 36;
pub const RANK: usize = 44;
pub const OFFSET: usize = 48;
pub const LENGTH: usize = 56;
pub const SHAPE: usize = 64;

/// Position of a field of entry `entry`.
pub fn field(entry: usize, field: usize) -> usize {
    HEADER + ENTRY * entry + field
}

pub fn put<const N: usize>(bytes: &mut [u8], at: usize, value: [u8; N]) {
    bytes[at..at + N].copy_from_slice(&value);
}

pub fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}

pub fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"))
}

/// Makes every checksum right that can be: sections that lie in the file, the table, the header.
pub fn seal(bytes: &mut [u8]) {
    let count = u32_at(bytes, SECTION_COUNT) as usize;
    let fits = count.checked_mul(ENTRY).and_then(|t| t.checked_add(HEADER)).filter(|&end| end <= bytes.len());
    if let Some(table_end) = fits {
        for entry in 0..count {
            let (offset, length) = (u64_at(bytes, field(entry, OFFSET)), u64_at(bytes, field(entry, LENGTH)));
            let end = offset.checked_add(length).filter(|&end| end <= bytes.len() as u64);
            if let Some(end) = end {
                let crc = crc32fast::hash(&bytes[offset as usize..end as usize]);
                put(bytes, field(entry, 40), crc.to_le_bytes());
            }
        }
        let crc = crc32fast::hash(&bytes[HEADER..table_end]);
        put(bytes, 32, crc.to_le_bytes());
    }
    let crc = crc32fast::hash(&bytes[..36]);
    put(bytes, 36, crc.to_le_bytes());
}

/// `bytes` after an edit, with right checksums.
pub fn edited(bytes: &[u8], edit: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    edit(&mut bytes);
    seal(&mut bytes);
    bytes
}
