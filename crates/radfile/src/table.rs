//! Reading the section table: every rule of `formats/rad.md` §3 is enforced here, before any section is looked at.
//!
//! All numbers come from a file that may be hostile, so every sum and product is checked, and nothing is
//! allocated that the file itself does not already take up.

use std::collections::HashSet;

use crate::{
    ElementType, Section,
    error::{Error, Result},
    layout::{
        ALIGNMENT, ENTRY_LENGTH, Entry, HEADER_LENGTH, Header, KNOWN_FLAGS, MAX_RANK, NAME_LENGTH, aligned,
        is_legal_name,
    },
};

/// Compares a checksum; `what` names the part of the file.
pub fn check_crc(what: &str, data: &[u8], expected: u32) -> Result<()> {
    match crc32fast::hash(data) {
        found if found == expected => Ok(()),
        found => Err(Error::Checksum { what: what.into(), found, expected }),
    }
}

/// The sections in file order; they tile the file exactly.
pub fn read_table(bytes: &[u8], header: &Header) -> Result<Vec<Section>> {
    if header.table_offset != HEADER_LENGTH {
        return Err(rule(format!("the section table is at byte {}, expected {HEADER_LENGTH}", header.table_offset)));
    }
    let length = bytes.len() as u64;
    let mut end = HEADER_LENGTH + u64::from(header.section_count) * ENTRY_LENGTH;
    if end > length {
        return Err(rule(format!("{} sections do not fit into {length} bytes", header.section_count)));
    }
    let table = &bytes[HEADER_LENGTH as usize..end as usize];
    check_crc("section table", table, header.table_crc)?;

    let mut sections: Vec<Section> = Vec::with_capacity(header.section_count as usize);
    for raw in table.chunks_exact(ENTRY_LENGTH as usize) {
        let section = read_entry(&bytemuck::pod_read_unaligned(raw))?;
        let start = aligned(end);
        if section.offset != start {
            let (name, offset) = (&section.name, section.offset);
            let what =
                format!("section {name} is at byte {offset}, expected {start} (multiples of {ALIGNMENT}, no holes)");
            return Err(rule(what));
        }
        let stop = start.checked_add(section.length).filter(|&stop| stop <= length);
        let Some(stop) = stop else {
            return Err(rule(format!("section {} ends beyond the end of the file", section.name)));
        };
        check_padding(bytes, end, start)?;
        sections.push(section);
        end = stop;
    }
    if length != aligned(end) {
        return Err(rule(format!("the file is {length} bytes long, expected {} after its last section", aligned(end))));
    }
    check_padding(bytes, end, length)?;
    let mut names = HashSet::with_capacity(sections.len());
    match sections.iter().find(|s| !names.insert(s.name.as_str())) {
        Some(twice) => Err(rule(format!("section {} is there twice", twice.name))),
        None => Ok(sections),
    }
}

fn rule(what: String) -> Error {
    Error::Layout { what, rule: "§3" }
}

/// `from` and `to` lie within the file.
fn check_padding(bytes: &[u8], from: u64, to: u64) -> Result<()> {
    if bytes[from as usize..to as usize].iter().all(|&b| b == 0) {
        return Ok(());
    }
    Err(rule(format!("bytes {from} to {to} should be zero padding")))
}

fn read_entry(entry: &Entry) -> Result<Section> {
    let used = entry.name.iter().position(|&b| b == 0).unwrap_or(NAME_LENGTH);
    let (name, rest) = entry.name.split_at(used);
    if !is_legal_name(name) || rest.iter().any(|&b| b != 0) {
        let name = String::from_utf8_lossy(&entry.name);
        return Err(rule(format!("section name {name:?} is not made of a-z 0-9 . _ - and zero padding")));
    }
    let name = String::from_utf8_lossy(name).into_owned();
    let element = ElementType::from_code(entry.element)
        .ok_or_else(|| rule(format!("section {name} has unknown element type {}", entry.element)))?;
    if entry.flags & !KNOWN_FLAGS != 0 {
        return Err(rule(format!("section {name} has unknown flags {:#x}", entry.flags)));
    }
    let rank = entry.rank as usize;
    let rank_fits = if element == ElementType::Meta { rank == 1 } else { rank <= MAX_RANK };
    if !rank_fits || entry.shape[rank..].iter().any(|&extent| extent != 0) {
        return Err(rule(format!(
            "section {name} of element type {} has rank {rank} and extents {:?}",
            element.name(),
            entry.shape
        )));
    }
    let shape = entry.shape[..rank].to_vec();
    if byte_length(element, &shape) != Some(entry.length) {
        return Err(rule(format!(
            "section {name}: {shape:?} elements of {} do not make the {} bytes that the table says",
            element.name(),
            entry.length
        )));
    }
    Ok(Section { name, element, flags: entry.flags, shape, crc: entry.crc, offset: entry.offset, length: entry.length })
}

/// Bytes of an array, `None` beyond 64 bits. Extents of an empty array must multiply to something as well
/// once its zeros are left out, so that arithmetic on shapes is safe in every reader.
fn byte_length(element: ElementType, shape: &[u64]) -> Option<u64> {
    let mut extents = shape.iter().filter(|&&extent| extent != 0);
    let product = extents.try_fold(element.size(), |bytes, &extent| bytes.checked_mul(extent))?;
    Some(if shape.contains(&0) { 0 } else { product })
}
