//! Small metadata as bincode 2 `legacy()`: little-endian, fixed-width integers, u64 lengths.
//!
//! The only module that names bincode. Its byte layout is specified in `formats/rad.md` §5
//! and is the same that wincode reads and writes (a test decodes it so), which keeps a
//! maintained successor one edit away. Bulk arrays never come here.

use serde::{Serialize, de::DeserializeOwned};

/// Largest metadata section, so that a hostile length prefix cannot ask for memory.
const LIMIT: usize = 16 << 20;

fn config() -> impl bincode::config::Config {
    bincode::config::legacy().with_limit::<LIMIT>()
}

/// Bytes of `value`.
///
/// # Panics
///
/// If `value` is over 16 MiB or holds a type that bincode cannot express: a bug in the caller.
pub fn encode<T: Serialize>(value: &T) -> Vec<u8> {
    bincode::serde::encode_to_vec(value, config()).expect("metadata of our own types is encodable")
}

/// The value that `bytes` hold; all of them must be used.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    let (value, used) = bincode::serde::decode_from_slice(bytes, config()).map_err(|e| e.to_string())?;
    match bytes.len() - used {
        0 => Ok(value),
        rest => Err(format!("{rest} bytes are left over")),
    }
}
