//! Element types of raw arrays.

use bytemuck::Pod;

/// Code of an element type in the section table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum ElementType {
    /// Metadata: bincode bytes, `formats/rad.md` §5.
    Meta = 0,
    /// Unsigned byte.
    U8 = 1,
    /// Unsigned 16-bit integer.
    U16 = 2,
    /// Unsigned 32-bit integer.
    U32 = 3,
    /// Unsigned 64-bit integer.
    U64 = 4,
    /// IEEE 754 binary32.
    F32 = 5,
    /// IEEE 754 binary64.
    F64 = 6,
}

impl ElementType {
    /// The type with this code.
    pub fn from_code(code: u32) -> Option<ElementType> {
        use ElementType::*;
        [Meta, U8, U16, U32, U64, F32, F64].into_iter().find(|t| *t as u32 == code)
    }

    /// Bytes of one element.
    pub fn size(self) -> u64 {
        match self {
            ElementType::Meta | ElementType::U8 => 1,
            ElementType::U16 => 2,
            ElementType::U32 | ElementType::F32 => 4,
            ElementType::U64 | ElementType::F64 => 8,
        }
    }

    /// Name used in messages and in `inspect`.
    pub fn name(self) -> &'static str {
        match self {
            ElementType::Meta => "meta",
            ElementType::U8 => "u8",
            ElementType::U16 => "u16",
            ElementType::U32 => "u32",
            ElementType::U64 => "u64",
            ElementType::F32 => "f32",
            ElementType::F64 => "f64",
        }
    }
}

/// A Rust type that can be the element of a raw array.
pub trait Element: Pod {
    /// Its code in the file.
    const TYPE: ElementType;
}

macro_rules! element {
    ($($rust:ty => $code:ident),*) => { $(impl Element for $rust { const TYPE: ElementType = ElementType::$code; })* };
}
element!(u8 => U8, u16 => U16, u32 => U32, u64 => U64, f32 => F32, f64 => F64);
