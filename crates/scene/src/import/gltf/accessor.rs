//! Numbers in buffers: every bound is checked once, then vertices are read one by one as they are needed, so that
//! no count in a file decides how much memory is asked for.

use super::{document::Document, schema::Sparse};
use crate::{Error, Result};

/// Elements that an accessor may have without a buffer view, where no length of bytes bounds its count.
const MAX_WITHOUT_VIEW: u32 = 1 << 20;

/// How a component is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32) -> Option<Component> {
        match code {
            5120 => Some(Component::I8),
            5121 => Some(Component::U8),
            5122 => Some(Component::I16),
            5123 => Some(Component::U16),
            5125 => Some(Component::U32),
            5126 => Some(Component::F32),
            _ => None,
        }
    }

    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// The number at the start of `bytes`, and what it is divided by if it is normalised.
    fn read(self, bytes: &[u8]) -> (f64, f64) {
        let two = || [bytes[0], bytes[1]];
        let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
        match self {
            Component::I8 => (f64::from(bytes[0] as i8), 127.0),
            Component::U8 => (f64::from(bytes[0]), 255.0),
            Component::I16 => (f64::from(i16::from_le_bytes(two())), 32767.0),
            Component::U16 => (f64::from(u16::from_le_bytes(two())), 65535.0),
            Component::U32 => (f64::from(u32::from_le_bytes(four())), 4_294_967_295.0),
            Component::F32 => (f64::from(f32::from_le_bytes(four())), 1.0),
        }
    }
}

/// Elements of `width` components, `stride` bytes apart.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// An accessor whose bounds are checked.
pub struct Reader<'a> {
    component: Component,
    normalized: bool,
    count: usize,
    /// `None` where all elements are zero but for the sparse ones.
    dense: Option<Elements<'a>>,
    /// Numbers of the replaced elements, ascending.
    replaced: Vec<u32>,
    replacements: Elements<'a>,
}

impl<'a> Reader<'a> {
    /// Opens accessor `index`, which must be of the type `kind` (`VEC3` …).
    pub fn open(document: &'a Document, index: usize, kind: &str) -> Result<Reader<'a>> {
        let accessor = document.get(&document.root.accessors, index, "accessor")?;
        let refuse = |what: String| document.malformed(format!("accessor {index} {what}; export it again"));
        if accessor.kind != kind {
            return Err(refuse(format!("is of type {:?}, expected {kind}", accessor.kind)));
        }
        let Some(component) = Component::of(accessor.component_type) else {
            return Err(refuse(format!("has the component type {}, which does not exist", accessor.component_type)));
        };
        let size = component.size() * width(kind);
        let count = u32::try_from(accessor.count).map_err(|_| refuse(format!("counts {} elements", accessor.count)))?;
        if accessor.buffer_view.is_none() && count > MAX_WITHOUT_VIEW {
            return Err(refuse(format!("counts {count} elements and has no buffer view")));
        }
        let source = Source { document, index, count: accessor.count };
        let dense = match accessor.buffer_view {
            None => None,
            Some(view) => Some(source.elements(view, accessor.byte_offset, accessor.count, size, true)?),
        };
        let mut reader = Reader {
            component,
            normalized: accessor.normalized,
            count: count as usize,
            dense,
            replaced: vec![],
            replacements: Elements { bytes: &[], stride: size },
        };
        if let Some(sparse) = &accessor.sparse {
            (reader.replaced, reader.replacements) = source.sparse(sparse, size)?;
        }
        Ok(reader)
    }

    /// How many elements there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether any element is stored at all.
    pub fn has_data(&self) -> bool {
        self.dense.is_some() || !self.replaced.is_empty()
    }

    /// Whether the components are unsigned integers that are not normalised, as indices must be.
    pub fn is_index(&self) -> bool {
        !self.normalized && matches!(self.component, Component::U8 | Component::U16 | Component::U32)
    }

    /// Element `i`, below [`Reader::count`], of `N` components.
    pub fn get<const N: usize>(&self, i: usize) -> [f64; N] {
        let (elements, i) = match (self.replaced.binary_search(&(i as u32)), &self.dense) {
            (Ok(at), _) => (&self.replacements, at),
            (Err(_), Some(dense)) => (dense, i),
            (Err(_), None) => return [0.0; N],
        };
        let bytes = &elements.bytes[i * elements.stride..];
        std::array::from_fn(|k| {
            let (number, one) = self.component.read(&bytes[k * self.component.size()..]);
            if self.normalized { (number / one).max(-1.0) } else { number }
        })
    }
}

/// An accessor being opened.
struct Source<'a> {
    document: &'a Document<'a>,
    index: usize,
    count: u64,
}

impl<'a> Source<'a> {
    /// `count` elements of `size` bytes in a buffer view from `offset` on; the view's stride counts if `strided`.
    fn elements(&self, view: usize, offset: u64, count: u64, size: usize, strided: bool) -> Result<Elements<'a>> {
        let (bytes, stride) = self.document.view(view)?;
        let stride = stride.filter(|_| strided).unwrap_or(size as u64);
        if stride < size as u64 {
            return Err(self.refuse(format!("has elements of {size} bytes, {stride} apart")));
        }
        let need = count.checked_sub(1).map_or(Some(0), |before| before.checked_mul(stride)?.checked_add(size as u64));
        match need.and_then(|need| need.checked_add(offset)).filter(|&end| end <= bytes.len() as u64) {
            Some(_) => {
                Ok(Elements { bytes: bytes.get(offset as usize..).unwrap_or_default(), stride: stride as usize })
            }
            None => Err(self.refuse(format!(
                "counts {count} elements of {size} bytes from byte {offset} on, its buffer view {view} has {} bytes",
                bytes.len()
            ))),
        }
    }

    /// Numbers of the replaced elements, and what replaces them.
    fn sparse(&self, sparse: &Sparse, size: usize) -> Result<(Vec<u32>, Elements<'a>)> {
        let kind = match Component::of(sparse.indices.component_type) {
            Some(kind @ (Component::U8 | Component::U16 | Component::U32)) => kind,
            _ => return Err(self.refuse("is sparse with indices that are no unsigned integers".into())),
        };
        let (view, offset) = (sparse.indices.buffer_view, sparse.indices.byte_offset);
        let indices = self.elements(view, offset, sparse.count, kind.size(), false)?;
        let (view, offset) = (sparse.values.buffer_view, sparse.values.byte_offset);
        let values = self.elements(view, offset, sparse.count, size, false)?;
        let index = |bytes: &[u8]| kind.read(bytes).0 as u32;
        let replaced = indices.bytes.chunks_exact(kind.size()).take(sparse.count as usize).map(index);
        let replaced: Vec<u32> = replaced.collect();
        match replaced.is_sorted_by(|a, b| a < b) && replaced.last().is_none_or(|&i| u64::from(i) < self.count) {
            true => Ok((replaced, values)),
            false => Err(self.refuse(format!("is sparse with indices that do not ascend below {}", self.count))),
        }
    }

    fn refuse(&self, what: String) -> Error {
        self.document.malformed(format!("accessor {} {what}; export it again", self.index))
    }
}

fn width(kind: &str) -> usize {
    match kind {
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 1,
    }
}
