//! Writing: sections are collected, laid out once, and put in place by a rename.

use std::{borrow::Cow, io::Write, path::Path};

use serde::Serialize;

use crate::{
    Container, ElementType, Provenance, Section, Step,
    element::Element,
    error::{Error, Result},
    layout::{ENTRY_LENGTH, Entry, HEADER_LENGTH, Header, IDENTIFIER, VERSION, aligned},
    meta,
};

/// Where a stage puts its finished container: a file, or memory for the next stage.
pub type Sink<'s> = dyn FnMut(&Builder<'_>) -> Result<()> + 's;

/// Collects the sections of one container. Array data may be borrowed until it is written.
#[derive(Default)]
pub struct Builder<'a> {
    sections: Vec<Pending<'a>>,
}

struct Pending<'a> {
    name: String,
    element: ElementType,
    flags: u32,
    shape: Vec<u64>,
    data: Cow<'a, [u8]>,
}

impl<'a> Builder<'a> {
    /// An empty container.
    pub fn new() -> Builder<'a> {
        Builder::default()
    }

    /// A container that starts with the sections of `input` that `keep` accepts.
    ///
    /// A stage passes on what it does not replace in this way, unknown optional sections included.
    pub fn from_input(input: &'a Container, keep: impl Fn(&Section) -> bool) -> Builder<'a> {
        let mut builder = Builder::new();
        for section in input.sections().iter().filter(|s| keep(s)) {
            builder.put(Pending {
                name: section.name.clone(),
                element: section.element,
                flags: section.flags,
                shape: section.shape.clone(),
                data: Cow::Borrowed(input.data(section)),
            });
        }
        builder
    }

    /// Adds a raw array; a section of the same name is replaced.
    ///
    /// # Panics
    ///
    /// If `shape` does not multiply to `data.len()` or the name is longer than 32 bytes: bugs in the caller.
    #[track_caller]
    pub fn array<T: Element>(&mut self, name: &str, flags: u32, shape: &[usize], data: impl Into<Cow<'a, [T]>>) {
        let data = data.into();
        assert_eq!(shape.iter().product::<usize>(), data.len(), "shape {shape:?} of section {name}");
        let data = match data {
            Cow::Borrowed(slice) => Cow::Borrowed(bytemuck::cast_slice(slice)),
            Cow::Owned(vec) => Cow::Owned(bytemuck::cast_slice(&vec).to_vec()),
        };
        let shape = shape.iter().map(|&e| e as u64).collect();
        self.put(Pending { name: name.into(), element: T::TYPE, flags, shape, data });
    }

    /// Adds a metadata section; a section of the same name is replaced.
    pub fn meta<T: Serialize>(&mut self, name: &str, flags: u32, value: &T) {
        let data = meta::encode(value);
        self.put(Pending {
            name: name.into(),
            element: ElementType::Meta,
            flags,
            shape: vec![data.len() as u64],
            data: Cow::Owned(data),
        });
    }

    /// Appends a step to the provenance of `input` and writes it.
    pub fn provenance(&mut self, input: Option<&Container>, step: Step) -> Result<()> {
        let mut provenance = input.map(Provenance::read).transpose()?.unwrap_or_default();
        provenance.steps.push(step);
        provenance.write(self);
        Ok(())
    }

    #[track_caller]
    fn put(&mut self, section: Pending<'a>) {
        assert!(section.name.len() <= 32, "section name {} is longer than 32 bytes", section.name);
        self.sections.retain(|s| s.name != section.name);
        self.sections.push(section);
    }

    /// Writes the container to `path` by way of a temporary file beside it, so that no half-written file is ever seen.
    ///
    /// # Errors
    ///
    /// [`Error::Io`].
    pub fn write_file(&self, path: &Path) -> Result<()> {
        let io = |source| Error::Io { path: path.to_owned(), source };
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut file = tempfile::NamedTempFile::new_in(folder).map_err(io)?;
        let mut writer = std::io::BufWriter::with_capacity(1 << 20, file.as_file_mut());
        self.write_to(&mut writer).and_then(|()| writer.flush()).map_err(io)?;
        drop(writer);
        allow_others_to_read(file.as_file()).map_err(io)?;
        file.persist(path).map_err(|e| io(e.error))?;
        Ok(())
    }

    /// The container in memory, for the next stage of the same process.
    pub fn finish(&self) -> Result<Container> {
        Container::from_bytes(&self.to_bytes())
    }

    /// The bytes of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.write_to(&mut bytes).expect("writing to memory does not fail");
        bytes
    }

    fn write_to(&self, out: &mut impl Write) -> std::io::Result<()> {
        let mut end = HEADER_LENGTH + self.sections.len() as u64 * ENTRY_LENGTH;
        let mut table = Vec::with_capacity(self.sections.len());
        for section in &self.sections {
            let entry = section.entry(aligned(end));
            end = entry.offset + entry.length;
            table.push(entry);
        }
        let table: &[u8] = bytemuck::cast_slice(&table);
        out.write_all(bytemuck::bytes_of(&header(self.sections.len(), table, aligned(end))))?;
        out.write_all(table)?;
        let mut written = HEADER_LENGTH + table.len() as u64;
        for section in &self.sections {
            pad(out, &mut written)?;
            out.write_all(&section.data)?;
            written += section.data.len() as u64;
        }
        pad(out, &mut written)
    }
}

impl Pending<'_> {
    fn entry(&self, offset: u64) -> Entry {
        let mut name = [0; 32];
        name[..self.name.len()].copy_from_slice(self.name.as_bytes());
        let mut shape = [0; 4];
        shape[..self.shape.len()].copy_from_slice(&self.shape);
        Entry {
            name,
            element: self.element as u32,
            flags: self.flags,
            crc: crc32fast::hash(&self.data),
            rank: self.shape.len() as u32,
            offset,
            length: self.data.len() as u64,
            shape,
        }
    }
}

fn header(section_count: usize, table: &[u8], file_length: u64) -> Header {
    let mut header = Header {
        identifier: IDENTIFIER,
        major: VERSION.0,
        minor: VERSION.1,
        section_count: section_count as u32,
        table_offset: HEADER_LENGTH,
        file_length,
        table_crc: crc32fast::hash(table),
        header_crc: 0,
        reserved: [0; 24],
    };
    header.header_crc = crc32fast::hash(&bytemuck::bytes_of(&header)[..36]);
    header
}

fn pad(out: &mut impl Write, written: &mut u64) -> std::io::Result<()> {
    let to = aligned(*written);
    out.write_all(&[0; 64][..(to - *written) as usize])?;
    *written = to;
    Ok(())
}

/// Temporary files are private; the finished one gets the usual rights.
#[cfg(unix)]
fn allow_others_to_read(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn allow_others_to_read(_file: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}
