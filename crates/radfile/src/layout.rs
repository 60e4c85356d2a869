//! Header and section table, byte for byte as in `formats/rad.md` sections 2 and 3.

use bytemuck::{Pod, Zeroable};

use crate::{
    error::{Error, Result},
    foreign,
};

/// First eight bytes of every file. The first is no text, so the file cannot be taken
/// for a Radiance scene (also `.rad`); CR LF and LF show newline damage; SUB stops `type`.
pub const IDENTIFIER: [u8; 8] = [0x8D, b'R', b'A', b'D', 0x0D, 0x0A, 0x1A, 0x0A];
/// Major and minor version that this crate knows. It writes the lowest minor that has the sections of a file.
pub const VERSION: (u16, u16) = (1, 4);
/// A reader that does not know a section with this flag must refuse the file.
pub const FLAG_REQUIRED: u32 = 1;
/// The section's contents depend on the order of the patches.
pub const FLAG_PATCH_ORDER: u32 = 2;
/// All flags of this major version; the other bits are zero.
pub const KNOWN_FLAGS: u32 = FLAG_REQUIRED | FLAG_PATCH_ORDER;
/// Sections start at multiples of this many bytes.
pub const ALIGNMENT: u64 = 64;
/// Longest section name in bytes.
pub const NAME_LENGTH: usize = 32;
/// Largest number of dimensions of a section.
pub const MAX_RANK: usize = 4;

/// The first 64 bytes.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Header {
    pub identifier: [u8; 8],
    pub major: u16,
    pub minor: u16,
    pub section_count: u32,
    pub table_offset: u64,
    pub file_length: u64,
    pub table_crc: u32,
    /// Checksum of the 36 bytes before it.
    pub header_crc: u32,
    pub reserved: [u8; 24],
}

/// One row of the section table, 96 bytes.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Entry {
    pub name: [u8; NAME_LENGTH],
    pub element: u32,
    pub flags: u32,
    pub crc: u32,
    pub rank: u32,
    pub offset: u64,
    pub length: u64,
    pub shape: [u64; MAX_RANK],
}

/// Length of the header in bytes.
pub const HEADER_LENGTH: u64 = size_of::<Header>() as u64;
/// The header's checksum is that of its bytes up to the checksum itself.
pub const HEADER_CRC_SPAN: usize = std::mem::offset_of!(Header, header_crc);
/// Length of one table entry in bytes.
pub const ENTRY_LENGTH: u64 = size_of::<Entry>() as u64;

/// Whether `name` may name a section: 1 to 32 of a-z 0-9 . _ -
pub fn is_legal_name(name: &[u8]) -> bool {
    let legal = |b: &u8| b.is_ascii_lowercase() || b.is_ascii_digit() || matches!(b, b'.' | b'_' | b'-');
    (1..=NAME_LENGTH).contains(&name.len()) && name.iter().all(legal)
}

/// `bytes`, a length within an existing file, rounded up to the next section boundary.
pub fn aligned(bytes: u64) -> u64 {
    bytes.next_multiple_of(ALIGNMENT)
}

impl Header {
    /// Checks identifier, version, checksum, reserved bytes and length.
    pub fn read(bytes: &[u8]) -> Result<Header> {
        let head = &bytes[..bytes.len().min(8)];
        if head != IDENTIFIER {
            return Err(Error::Identifier { found: hex(head), hint: foreign::hint(bytes) });
        }
        let have = bytes.len() as u64;
        let Some(head) = bytes.get(..HEADER_LENGTH as usize) else {
            return Err(Error::FileLength { need: HEADER_LENGTH, have });
        };
        let header: Header = bytemuck::pod_read_unaligned(head);
        if header.major != VERSION.0 {
            return Err(Error::Version { major: header.major, minor: header.minor });
        }
        let found = crc32fast::hash(&head[..HEADER_CRC_SPAN]);
        if found != header.header_crc {
            return Err(Error::Checksum { what: "header".into(), found, expected: header.header_crc });
        }
        if header.reserved != [0; 24] {
            return Err(Error::Layout { what: "reserved bytes of the header are not zero".into(), rule: "§2" });
        }
        if header.file_length != have {
            return Err(Error::FileLength { need: header.file_length, have });
        }
        Ok(header)
    }
}

fn hex(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "nothing, it is empty".into();
    }
    bytes.iter().map(|b| format!("{b:02X}")).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;

    /// Field, offset and bytes of each row of a table in the specification.
    fn listed(from: &str, to: &str) -> Vec<(String, usize, usize)> {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../formats/rad.md");
        let text = std::fs::read_to_string(path).expect("the specification is there");
        let lines = text.lines().skip_while(|l| !l.starts_with(from)).take_while(|l| !l.starts_with(to));
        let rows =
            lines.filter(|l| l.starts_with('|')).map(|l| l.trim_matches('|').split('|').map(str::trim).collect());
        rows.filter(|r: &Vec<&str>| r.len() == 4 && r[0] != "field" && !r[0].starts_with('-'))
            .map(|r| {
                let (bits, count) = r[2].split_once(" × ").unwrap_or((r[2], "1"));
                let bytes = bits[1..].parse::<usize>().expect("u8 to u64") / 8;
                (r[0].to_string(), r[1].parse().expect("an offset"), bytes * count.parse::<usize>().expect("a count"))
            })
            .collect()
    }

    macro_rules! fields {
        ($type:ident: $($field:ident),*) => {{
            let value = $type::zeroed();
            vec![$((stringify!($field).to_string(), offset_of!($type, $field), size_of_val(&value.$field))),*]
        }};
    }

    #[test]
    fn specification_and_code_have_the_same_header() {
        let fields = fields!(Header: identifier, major, minor, section_count, table_offset, file_length, table_crc,
            header_crc, reserved);
        assert_eq!(listed("## 2", "## 3"), fields);
        assert_eq!(HEADER_LENGTH, 64);
    }

    #[test]
    fn specification_and_code_have_the_same_table_entry() {
        assert_eq!(listed("## 3", "## 4"), fields!(Entry: name, element, flags, crc, rank, offset, length, shape));
        assert_eq!(ENTRY_LENGTH, 96);
    }
}
