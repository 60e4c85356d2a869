//! Writing: sections are collected, laid out once, and put in place by a rename.

use std::{
    borrow::Cow,
    io::{BufWriter, ErrorKind, Write},
    path::Path,
};

use serde::Serialize;

use crate::{
    Container, ElementType, Provenance, Section, Step,
    bytes::Bytes,
    container::other_than_a_file,
    element::Element,
    error::{Error, Result},
    layout::{
        ENTRY_LENGTH, Entry, HEADER_CRC_SPAN, HEADER_LENGTH, Header, IDENTIFIER, MAX_RANK, VERSION, aligned,
        is_legal_name,
    },
    meta,
    record::minor_of,
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
    /// If `shape` does not multiply to `data.len()` or has more than four extents, or if the name is not made of
    /// 1 to 32 of `a-z 0-9 . _ -`: bugs in the caller.
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
    ///
    /// # Panics
    ///
    /// If the name is illegal (see [`Builder::array`]) or `value` cannot be encoded: bugs in the caller.
    #[track_caller]
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
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] or [`Error::Meta`] if the provenance of `input` cannot be read.
    pub fn provenance(&mut self, input: Option<&Container>, step: Step) -> Result<()> {
        let mut provenance = input.map(Provenance::read).transpose()?.unwrap_or_default();
        provenance.steps.push(step);
        provenance.write(self);
        Ok(())
    }

    #[track_caller]
    fn put(&mut self, section: Pending<'a>) {
        let name = &section.name;
        assert!(is_legal_name(name.as_bytes()), "section name {name:?} is not 1 to 32 of a-z 0-9 . _ -");
        assert!(section.shape.len() <= MAX_RANK, "section {name} has more than {MAX_RANK} dimensions");
        self.sections.retain(|s| s.name != section.name);
        self.sections.push(section);
    }

    /// Writes the container to `path` by way of a temporary file beside it: at every moment `path` is the old
    /// file, the new one, or not there. An error leaves it as it was and removes the temporary file.
    ///
    /// # Errors
    ///
    /// [`Error::Io`], also when `path` is a folder or a device; [`Error::Meta`] for metadata beyond 64 MiB.
    pub fn write_file(&self, path: &Path) -> Result<()> {
        self.check_metadata()?;
        let io = |source| Error::Io { path: path.to_owned(), source };
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() {
            let what = format!("the folder {} does not exist; create it first", folder.display());
            return Err(io(std::io::Error::new(ErrorKind::NotFound, what)));
        }
        // A rename would replace a device such as /dev/null by a file.
        match other_than_a_file(path) {
            Ok(Some(kind)) => return Err(io(std::io::Error::other(format!("is {kind}, expected a file name")))),
            Ok(None) => {}
            Err(e) if e.kind() == ErrorKind::NotFound => {}
            Err(e) => return Err(io(e)),
        }
        let mut file = temporary_file(folder).map_err(io)?;
        let mut writer = BufWriter::with_capacity(1 << 20, file.as_file_mut());
        self.write_to(&mut writer).and_then(|()| writer.flush()).map_err(io)?;
        drop(writer);
        file.persist(path).map_err(|e| io(e.error))?;
        Ok(())
    }

    /// The container in memory, for the next stage of the same process.
    ///
    /// # Errors
    ///
    /// [`Error::Meta`] for metadata beyond 64 MiB.
    pub fn finish(&self) -> Result<Container> {
        self.check_metadata()?;
        let (header, table) = self.layout();
        Container::from_source(Bytes::filled(header.file_length as usize, |memory| {
            self.write_laid_out(&header, &table, &mut &mut *memory).expect("the memory has the length of the file");
        }))
    }

    /// The bytes of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.write_to(&mut bytes).expect("writing to memory does not fail");
        bytes
    }

    /// Readers refuse larger metadata, so it must not be written.
    fn check_metadata(&self) -> Result<()> {
        let large = self.sections.iter().find(|s| s.element == ElementType::Meta && s.data.len() > meta::LIMIT);
        large.map_or(Ok(()), |s| {
            let what = format!("it would hold {} bytes, at most {} can be read", s.data.len(), meta::LIMIT);
            Err(Error::Meta { name: s.name.clone(), what })
        })
    }

    fn layout(&self) -> (Header, Vec<Entry>) {
        let mut end = HEADER_LENGTH + self.sections.len() as u64 * ENTRY_LENGTH;
        let mut table = Vec::with_capacity(self.sections.len());
        for section in &self.sections {
            let entry = section.entry(aligned(end));
            end = entry.offset + entry.length;
            table.push(entry);
        }
        let minor = self.sections.iter().map(|s| minor_of(&s.name)).max().unwrap_or(0);
        (header(minor, &table, aligned(end)), table)
    }

    fn write_to(&self, out: &mut impl Write) -> std::io::Result<()> {
        let (header, table) = self.layout();
        self.write_laid_out(&header, &table, out)
    }

    fn write_laid_out(&self, header: &Header, table: &[Entry], out: &mut impl Write) -> std::io::Result<()> {
        out.write_all(bytemuck::bytes_of(header))?;
        out.write_all(bytemuck::cast_slice(table))?;
        let mut written = HEADER_LENGTH + size_of_val(table) as u64;
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

fn header(minor: u16, table: &[Entry], file_length: u64) -> Header {
    let mut header = Header {
        identifier: IDENTIFIER,
        major: VERSION.0,
        minor,
        section_count: table.len() as u32,
        table_offset: HEADER_LENGTH,
        file_length,
        table_crc: crc32fast::hash(bytemuck::cast_slice(table)),
        header_crc: 0,
        reserved: [0; 24],
    };
    header.header_crc = crc32fast::hash(&bytemuck::bytes_of(&header)[..HEADER_CRC_SPAN]);
    header
}

fn pad(out: &mut impl Write, written: &mut u64) -> std::io::Result<()> {
    let to = aligned(*written);
    out.write_all(&[0; 64][..(to - *written) as usize])?;
    *written = to;
    Ok(())
}

/// A new file in `folder` that removes itself unless it is kept, with the rights that the user gives to new files.
fn temporary_file(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut file = tempfile::Builder::new();
    file.prefix(".rad-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        file.permissions(std::fs::Permissions::from_mode(0o666)); // less the umask
    }
    file.tempfile_in(folder)
}
