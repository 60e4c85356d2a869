//! Small metadata as bincode 2 `legacy()`: little-endian, fixed-width integers, u64 lengths.
//!
//! The only module that names bincode. Its byte layout is specified in `formats/rad.md` §5
//! and is the same that wincode reads and writes (a test decodes it so), which keeps a
//! maintained successor one edit away. Bulk arrays never come here.

use serde::{Serialize, de::DeserializeOwned};

/// Largest metadata section in bytes, so that a hostile length prefix cannot ask for more memory than this.
pub const LIMIT: usize = 64 << 20;

fn config() -> impl bincode::config::Config {
    bincode::config::legacy().with_limit::<LIMIT>()
}

/// Bytes of `value`.
///
/// # Panics
///
/// If `value` holds a type that bincode cannot express: a bug in the caller.
pub fn encode<T: Serialize>(value: &T) -> Vec<u8> {
    bincode::serde::encode_to_vec(value, config()).expect("metadata of our own types is encodable")
}

/// The value that `bytes` hold; all of them must be used.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    let (value, used) = bincode::serde::decode_from_slice(bytes, config()).map_err(|e| in_words(&e))?;
    match bytes.len() - used {
        0 => Ok(value),
        rest => Err(format!("{rest} bytes are left over")),
    }
}

fn in_words(error: &bincode::error::DecodeError) -> String {
    use bincode::error::DecodeError::*;
    match error {
        UnexpectedEnd { .. } => "it ends too early".into(),
        LimitExceeded => format!("a length in it is beyond {} MiB", LIMIT >> 20),
        InvalidBooleanValue(found) => format!("a truth value is {found}, expected 0 or 1"),
        UnexpectedVariant { found, .. } => format!("there is no alternative number {found}"),
        Utf8 { .. } => "a text is not UTF-8".into(),
        other => other.to_string(),
    }
}
