//! Rows of `bench/record/<machine>/<date>-operators.csv`.

use std::{fs, io, path::Path};

use serde::{Deserialize, Serialize};

/// One operator of one scene. What was not measured is `None`. Errors are fractions.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    pub date: String,
    pub commit: String,
    pub machine: String,
    pub scene: String,
    /// Patches.
    pub n: usize,
    pub format: String,
    pub setting: String,
    /// Of the operator as stored.
    pub bytes: usize,
    pub bytes_per_n2: f64,
    /// Seconds from the dense operator, on all cores.
    pub pack_s: Option<f64>,
    /// Median of a product in three colours, on one thread and on two, milliseconds.
    pub cpu1_ms: Option<f64>,
    pub cpu2_ms: Option<f64>,
    /// Adapter, and the median of a product on it.
    pub gpu: Option<String>,
    pub gpu_ms: Option<f64>,
    /// Of the timed product: see [`super::judge::Score`].
    pub l2: Option<f64>,
    pub vis99: Option<f64>,
    pub furnace: Option<f64>,
}

/// Rows of a record; none if there is no file.
///
/// # Errors
///
/// If it cannot be read or has other columns.
pub fn read<T: for<'a> Deserialize<'a>>(path: &Path) -> io::Result<Vec<T>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    Ok(csv::Reader::from_path(path)?.deserialize().collect::<Result<_, _>>()?)
}

/// Writes a record with its header.
///
/// # Errors
///
/// If it cannot be written.
pub fn write<T: Serialize>(path: &Path, rows: &[T]) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut writer = csv::Writer::from_path(path)?;
    for row in rows {
        writer.serialize(row)?;
    }
    writer.flush()
}

/// A number with as many digits as it is worth.
pub fn digits(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().expect("a number was written")
}
