//! Path-traced reference points and how an answer is scored against them.
//!
//! The points lie outside of the repository; tests that want them skip, with a printed reason,
//! where they are absent.

use std::path::{Path, PathBuf};

use crate::{root, skipped};

/// A file of the reference folder, or `None` with a printed reason.
pub fn shared(path: &str) -> Option<PathBuf> {
    let file = root().join("../shared").join(path);
    if file.exists() {
        return Some(file);
    }
    skipped(&format!("the reference data {path} is not beside this checkout"));
    None
}

/// A CSV file as columns of numbers.
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads a CSV file; lines that start with # are comments.
    pub fn read(path: &Path) -> Table {
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).expect("a CSV file");
        let header = reader.headers().expect("a header").iter().map(str::to_owned).collect();
        let rows = reader.records().map(|r| r.expect("a record").iter().map(str::to_owned).collect()).collect();
        Table { header, rows }
    }

    /// A column of numbers.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let at = self.header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no column {name}"));
        self.rows.iter().map(|row| row[at].parse().expect("a number")).collect()
    }

    /// Mean of the colour columns `name_r`, `name_g`, `name_b`.
    pub fn grey(&self, name: &str) -> Vec<f64> {
        let [r, g, b] = ["r", "g", "b"].map(|c| self.column(&format!("{name}_{c}")));
        r.iter().zip(&g).zip(&b).map(|((r, g), b)| (r + g + b) / 3.0).collect()
    }

    /// Writes some columns as a CSV file of their own.
    pub fn export(&self, columns: &[&str], path: &Path) {
        let mut writer = csv::Writer::from_path(path).expect("a file");
        writer.write_record(columns).expect("a record");
        let at: Vec<usize> = columns
            .iter()
            .map(|name| self.header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no column {name}")))
            .collect();
        for row in &self.rows {
            writer.write_record(at.iter().map(|&c| &row[c])).expect("a record");
        }
        writer.flush().expect("a file");
    }
}

/// How far an answer is from the reference.
#[derive(Clone, Copy, Debug)]
pub struct Score {
    /// Mean of the answer over mean of the reference, minus 1.
    pub bias: f64,
    /// RMS error over the reference's mean, the reference's own noise taken off.
    pub rms: f64,
}

/// Scores grey values; `noise` is the reference's standard error at each point.
pub fn score(answer: &[f64], reference: &[f64], noise: &[f64]) -> Score {
    assert_eq!(answer.len(), reference.len());
    assert!(answer.iter().all(|x| x.is_finite()), "an answer is not finite");
    let n = answer.len() as f64;
    let mean = reference.iter().sum::<f64>() / n;
    let squares: f64 = answer.iter().zip(reference).map(|(a, r)| (a - r).powi(2)).sum::<f64>() / n;
    let own: f64 = noise.iter().map(|s| s * s).sum::<f64>() / n;
    Score { bias: answer.iter().sum::<f64>() / n / mean - 1.0, rms: (squares - own).max(0.0).sqrt() / mean }
}
