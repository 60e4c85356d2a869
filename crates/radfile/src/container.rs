//! Reading: the whole file is checked once, when it is opened; arrays are then views into it.

use std::{fs::File, path::Path};

use serde::de::DeserializeOwned;

use crate::{
    ElementType,
    bytes::Bytes,
    element::Element,
    error::{Error, Result},
    layout::{FLAG_PATCH_ORDER, FLAG_REQUIRED, Header},
    meta, record,
    table::{check_crc, read_table},
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
        // Asked before opening, because opening a pipe waits for its other end.
        if let Some(kind) = other_than_a_file(path).map_err(io)? {
            return Err(io(std::io::Error::other(format!("is {kind}, expected a .rad file"))));
        }
        let file = File::open(path).map_err(io)?;
        Self::from_source(Bytes::map(&file).map_err(io)?)
    }

    /// Checks a container that is in memory (the bytes are copied to aligned memory).
    pub fn from_bytes(bytes: &[u8]) -> Result<Container> {
        Self::from_source(Bytes::copy(bytes))
    }

    pub(crate) fn from_source(bytes: Bytes) -> Result<Container> {
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
    ///
    /// # Panics
    ///
    /// If `section` is a row of another container's table: a bug in the caller.
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
            let dimensions = if rank == 1 { "dimension" } else { "dimensions" };
            return Err(Error::Shape {
                name: name.into(),
                found: section.describe(),
                expected: format!("{} with {rank} {dimensions}", T::TYPE.name()),
            });
        }
        // Sections start at multiples of 64 in memory that is aligned to 8, so the cast cannot fail.
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

/// What `path` is if it is neither a regular file nor a link to one.
pub(crate) fn other_than_a_file(path: &Path) -> std::io::Result<Option<&'static str>> {
    let metadata = std::fs::metadata(path)?;
    Ok(match (metadata.is_file(), metadata.is_dir()) {
        (true, _) => None,
        (_, true) => Some("a folder"),
        _ => Some("a pipe or a device"),
    })
}
