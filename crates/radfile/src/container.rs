//! Reading: the whole file is checked once, when it is opened; arrays are then views into it.

use std::{fs::File, path::Path};

use serde::de::DeserializeOwned;

use crate::{
    ElementType,
    bytes::Bytes,
    element::Element,
    error::{Error, Result},
    layout::{ALIGNMENT, ENTRY_LENGTH, Entry, FLAG_PATCH_ORDER, FLAG_REQUIRED, HEADER_LENGTH, Header, aligned},
    meta, record,
};

/// An opened `.rad` file or its equal in memory.
///
/// Header, table, lengths, padding and every checksum have been verified; what the numbers mean is
/// checked by the records that read them.
pub struct Container {
    bytes: Bytes,
    version: (u16, u16),
    sections: Vec<Section>,
}

/// One row of the section table.
#[derive(Clone, Debug)]
pub struct Section {
    /// Name, such as `patches.area`.
    pub name: String,
    /// Element type.
    pub element: ElementType,
    /// [`FLAG_REQUIRED`], [`FLAG_PATCH_ORDER`].
    pub flags: u32,
    /// Extent of each dimension, outermost first.
    pub shape: Vec<u64>,
    /// CRC-32 of the bytes.
    pub crc: u32,
    /// First byte in the file.
    pub offset: u64,
    /// Length in bytes.
    pub length: u64,
}

impl Container {
    /// Maps and checks a file.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be read, otherwise the rule of `formats/rad.md` that it breaks.
    pub fn open(path: &Path) -> Result<Container> {
        let io = |source| Error::Io { path: path.to_owned(), source };
        let file = File::open(path).map_err(io)?;
        if file.metadata().map_err(io)?.is_dir() {
            return Err(io(std::io::ErrorKind::IsADirectory.into()));
        }
        Self::from_source(Bytes::map(&file).map_err(io)?)
    }

    /// Checks a container that is in memory (the bytes are copied to aligned memory).
    pub fn from_bytes(bytes: &[u8]) -> Result<Container> {
        Self::from_source(Bytes::copy(bytes))
    }

    fn from_source(bytes: Bytes) -> Result<Container> {
        let slice = bytes.as_slice();
        let header = Header::read(slice)?;
        let sections = read_table(slice, &header)?;
        for section in &sections {
            let data = &slice[section.offset as usize..][..section.length as usize];
            check_crc(&format!("section {}", section.name), data, section.crc)?;
            if section.flags & FLAG_REQUIRED != 0 && record::stage_of(&section.name).is_none() {
                return Err(Error::UnknownRequired { name: section.name.clone() });
            }
        }
        Ok(Container { version: (header.major, header.minor), sections, bytes })
    }

    /// Version of the file.
    pub fn version(&self) -> (u16, u16) {
        self.version
    }

    /// The section table, in file order.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// All bytes of the file.
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.as_slice()
    }

    /// Whether a section of this name is there.
    pub fn has(&self, name: &str) -> bool {
        self.sections.iter().any(|s| s.name == name)
    }

    /// The table row of a section.
    ///
    /// # Errors
    ///
    /// [`Error::Missing`] names the stage that would have written it.
    pub fn section(&self, name: &str) -> Result<&Section> {
        self.sections.iter().find(|s| s.name == name).ok_or_else(|| Error::Missing {
            name: name.into(),
            stage: record::stage_of(name).unwrap_or("(no stage of this version)"),
        })
    }

    /// The raw bytes of a section.
    pub fn data(&self, section: &Section) -> &[u8] {
        &self.as_bytes()[section.offset as usize..][..section.length as usize]
    }

    /// A raw array, viewed in place, with its shape.
    ///
    /// # Errors
    ///
    /// [`Error::Missing`], or [`Error::Shape`] if element type or rank differ.
    pub fn array<T: Element>(&self, name: &str, rank: usize) -> Result<(&[T], &[u64])> {
        let section = self.section(name)?;
        if section.element != T::TYPE || section.shape.len() != rank {
            return Err(Error::Shape {
                name: name.into(),
                found: section.describe(),
                expected: format!("{} of rank {rank}", T::TYPE.name()),
            });
        }
        Ok((bytemuck::cast_slice(self.data(section)), &section.shape))
    }

    /// A raw array of known shape; `None` in `shape` leaves that extent open.
    ///
    /// # Errors
    ///
    /// As [`Container::array`], and [`Error::Shape`] if an extent differs.
    pub fn array_of<T: Element>(&self, name: &str, shape: &[Option<usize>]) -> Result<&[T]> {
        let (data, found) = self.array::<T>(name, shape.len())?;
        let fits = shape.iter().zip(found).all(|(want, have)| want.is_none_or(|w| w as u64 == *have));
        if !fits {
            let extents: Vec<String> = shape.iter().map(|s| s.map_or("any".into(), |v| v.to_string())).collect();
            return Err(Error::Shape {
                name: name.into(),
                found: self.section(name)?.describe(),
                expected: format!("{} [{}]", T::TYPE.name(), extents.join(", ")),
            });
        }
        Ok(data)
    }

    /// A metadata section, decoded.
    ///
    /// # Errors
    ///
    /// [`Error::Missing`], [`Error::Shape`] if it is no metadata, [`Error::Meta`] if it cannot be decoded.
    pub fn meta<T: DeserializeOwned>(&self, name: &str) -> Result<T> {
        let section = self.section(name)?;
        if section.element != ElementType::Meta {
            return Err(Error::Shape { name: name.into(), found: section.describe(), expected: "metadata".into() });
        }
        meta::decode(self.data(section)).map_err(|what| Error::Meta { name: name.into(), what })
    }
}

impl Section {
    /// Element type and shape in words, such as `f32 [1024, 3]`.
    pub fn describe(&self) -> String {
        let extents: Vec<String> = self.shape.iter().map(u64::to_string).collect();
        format!("{} [{}]", self.element.name(), extents.join(", "))
    }

    /// Whether the contents depend on the order of patches.
    pub fn follows_patch_order(&self) -> bool {
        self.flags & FLAG_PATCH_ORDER != 0
    }
}

fn check_crc(what: &str, data: &[u8], expected: u32) -> Result<()> {
    match crc32fast::hash(data) {
        found if found == expected => Ok(()),
        found => Err(Error::Checksum { what: what.into(), found, expected }),
    }
}

fn read_table(bytes: &[u8], header: &Header) -> Result<Vec<Section>> {
    let rule = |what: String| Error::Layout { what, rule: "§3" };
    if header.table_offset != HEADER_LENGTH {
        return Err(rule(format!("section table at byte {}, expected {HEADER_LENGTH}", header.table_offset)));
    }
    let table_end = HEADER_LENGTH + u64::from(header.section_count) * ENTRY_LENGTH;
    let Some(table) = bytes.get(HEADER_LENGTH as usize..table_end as usize) else {
        return Err(rule(format!("{} sections do not fit into {} bytes", header.section_count, bytes.len())));
    };
    check_crc("section table", table, header.table_crc)?;

    let mut sections = Vec::with_capacity(header.section_count as usize);
    let mut end = table_end;
    for raw in table.chunks_exact(ENTRY_LENGTH as usize) {
        let section = read_entry(&bytemuck::pod_read_unaligned(raw))?;
        let start = aligned(end);
        if section.offset != start {
            return Err(rule(format!(
                "section {} at byte {}, expected {start} (multiples of {ALIGNMENT}, no holes)",
                section.name, section.offset
            )));
        }
        let stop = start.checked_add(section.length).filter(|&stop| stop <= bytes.len() as u64);
        let Some(stop) = stop else {
            return Err(rule(format!("section {} ends beyond the end of the file", section.name)));
        };
        check_padding(bytes, end, start)?;
        if sections.iter().any(|s: &Section| s.name == section.name) {
            return Err(rule(format!("section {} is there twice", section.name)));
        }
        sections.push(section);
        end = stop;
    }
    if bytes.len() as u64 != aligned(end) {
        return Err(rule(format!("{} bytes follow the last section", bytes.len() as u64 - end)));
    }
    check_padding(bytes, end, aligned(end))?;
    Ok(sections)
}

fn check_padding(bytes: &[u8], from: u64, to: u64) -> Result<()> {
    let padding = bytes.get(from as usize..to as usize);
    if padding.is_some_and(|p| p.iter().all(|&b| b == 0)) {
        return Ok(());
    }
    Err(Error::Layout { what: format!("bytes {from} to {to} should be zero padding"), rule: "§3" })
}

fn read_entry(entry: &Entry) -> Result<Section> {
    let rule = |what: String| Error::Layout { what, rule: "§3" };
    let used = entry.name.iter().position(|&b| b == 0).unwrap_or(entry.name.len());
    let name = &entry.name[..used];
    let legal = |b: &u8| b.is_ascii_lowercase() || b.is_ascii_digit() || matches!(b, b'.' | b'_' | b'-');
    if name.is_empty() || !name.iter().all(legal) || entry.name[used..].iter().any(|&b| b != 0) {
        return Err(rule(format!("section name {:?} is not lower-case ASCII", String::from_utf8_lossy(&entry.name))));
    }
    let name = String::from_utf8_lossy(name).into_owned();
    let element = ElementType::from_code(entry.element)
        .ok_or_else(|| rule(format!("section {name} has unknown element type {}", entry.element)))?;
    let rank = entry.rank as usize;
    if rank > 4 || entry.shape[rank.min(4)..].iter().any(|&e| e != 0) {
        return Err(rule(format!("section {name} has rank {rank} and shape {:?}", entry.shape)));
    }
    let shape = entry.shape[..rank].to_vec();
    let need = shape.iter().try_fold(element.size(), |bytes, &extent| bytes.checked_mul(extent));
    if need != Some(entry.length) {
        return Err(rule(format!(
            "section {name}: shape {shape:?} of {} does not make the {} bytes that the table says",
            element.name(),
            entry.length
        )));
    }
    Ok(Section { name, element, flags: entry.flags, shape, crc: entry.crc, offset: entry.offset, length: entry.length })
}
