//! Points to evaluate: the CSV of docs/design.md §4, read and repeated with the answers.

use std::path::Path;

use anyhow::{Context, bail};

use crate::files;

/// The columns that a points file must have.
const COLUMNS: [&str; 6] = ["px", "py", "pz", "nx", "ny", "nz"];

/// The columns that answers add, whoever gives them.
pub const ANSWERS: [&str; 6] = ["direct_r", "direct_g", "direct_b", "indirect_r", "indirect_g", "indirect_b"];

/// A points file.
pub struct Points {
    header: Vec<String>,
    records: Vec<Vec<String>>,
    /// Positions in the scene file's axes, metres.
    pub position: Vec<[f64; 3]>,
    /// Unit normals; they pick the side.
    pub normal: Vec<[f32; 3]>,
}

impl Points {
    /// Reads a points file: a header with px,py,pz,nx,ny,nz, other columns are handed through,
    /// lines that start with # are comments. `answers` are the columns that will be added.
    pub fn read(path: &Path, answers: &[&str]) -> anyhow::Result<Points> {
        Points::parse(&files::text(path)?, answers).with_context(|| path.display().to_string())
    }

    fn parse(text: &str, answers: &[&str]) -> anyhow::Result<Points> {
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
        let header: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
        if let Some(twice) = COLUMNS.iter().find(|name| header.iter().filter(|h| h == *name).count() > 1) {
            bail!("column {twice} is there twice; which one is meant?");
        }
        if let Some(taken) = answers.iter().find(|name| header.iter().any(|h| h == *name)) {
            bail!("column {taken} is already there; rename it, the answers use this name");
        }
        let mut columns = [0; 6];
        for (column, name) in columns.iter_mut().zip(COLUMNS) {
            *column = header.iter().position(|h| h == name).with_context(|| {
                format!("column {name} is missing, expected px,py,pz,nx,ny,nz; found {}", header.join(","))
            })?;
        }
        let mut points = Points { header, records: vec![], position: vec![], normal: vec![] };
        for record in reader.records() {
            let record = record?;
            let line = record.position().map_or(0, |p| p.line());
            let mut values = [0.0f64; 6];
            for ((value, column), name) in values.iter_mut().zip(columns).zip(COLUMNS) {
                let text = record.get(column).unwrap_or("");
                *value = text
                    .parse()
                    .ok()
                    .filter(|v: &f64| v.is_finite())
                    .with_context(|| format!("line {line}: {name} is {text:?}, expected a number"))?;
            }
            let [px, py, pz, normal @ ..] = values;
            let largest = normal.iter().fold(0.0f64, |m, x| m.max(x.abs())); // so that no square overflows
            if largest < 1e-12 {
                bail!("line {line}: the normal is zero; it must pick the side of the surface");
            }
            let normal = normal.map(|x| x / largest);
            let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            points.position.push([px, py, pz]);
            points.normal.push(normal.map(|x| (x / length) as f32));
            points.records.push(record.iter().map(str::to_owned).collect());
        }
        Ok(points)
    }

    /// Points that were not read from a file.
    pub fn new(position: Vec<[f64; 3]>, normal: Vec<[f32; 3]>) -> Points {
        let records = position
            .iter()
            .zip(&normal)
            .map(|(p, n)| p.iter().map(f64::to_string).chain(n.iter().map(f32::to_string)).collect());
        Points { header: COLUMNS.map(String::from).to_vec(), records: records.collect(), position, normal }
    }

    /// The columns `name_r`, `name_g`, `name_b`, which the file must have.
    pub fn colours(&self, name: &str) -> anyhow::Result<Vec<[f64; 3]>> {
        let mut values = vec![[0.0; 3]; self.records.len()];
        for (channel, letter) in ["r", "g", "b"].into_iter().enumerate() {
            let column = format!("{name}_{letter}");
            let at = self.header.iter().position(|h| *h == column);
            let at = at.with_context(|| format!("column {column} is missing; found {}", self.header.join(",")))?;
            for (number, (value, record)) in values.iter_mut().zip(&self.records).enumerate() {
                let number_found = record[at].parse().ok().filter(|v: &f64| v.is_finite() && *v >= 0.0);
                value[channel] = number_found.with_context(|| {
                    format!("point {}: {column} is {:?}, expected 0 or a positive number", number + 1, record[at])
                })?;
            }
        }
        Ok(values)
    }

    /// Writes the points with the columns `answers` appended; `row` gives them for a point.
    pub fn write(&self, path: &Path, answers: &[&str], row: impl Fn(usize) -> Vec<String>) -> anyhow::Result<()> {
        let mut out = csv::Writer::from_writer(Vec::new());
        out.write_record(self.header.iter().map(String::as_str).chain(answers.iter().copied()))?;
        for (i, record) in self.records.iter().enumerate() {
            out.write_record(record.iter().cloned().chain(row(i)))?;
        }
        files::write(path, &out.into_inner()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_may_come_in_any_order_and_others_are_handed_through() {
        let points = Points::parse("# made by hand\nnz,ny,nx,id,pz,py,px\n2,0,0,seven,3,2,1\n", &ANSWERS).unwrap();
        assert_eq!(points.position, [[1.0, 2.0, 3.0]]);
        assert_eq!(points.normal, [[0.0, 0.0, 1.0]]);
        assert_eq!(points.records[0][3], "seven");
    }

    #[test]
    fn a_bad_line_is_named() {
        let refused = |text: &str| Points::parse(text, &ANSWERS).err().map(|e| e.to_string()).unwrap_or_default();
        let header = "px,py,pz,nx,ny,nz\n";
        assert!(refused("px,py,pz\n1,2,3\n").contains("column nx is missing"));
        assert!(refused(&format!("{header}1,2,3,0,0,1\n1,2,oops,0,0,1\n")).contains("line 3: pz is \"oops\""));
        assert!(refused(&format!("{header}1,2,NaN,0,0,1\n")).contains("expected a number"));
        assert!(refused(&format!("{header}1,2,3,0,0,0\n")).contains("the normal is zero"));
        assert!(refused("px,py,pz,nx,ny,nz,px\n").contains("px is there twice"));
        assert!(refused("px,py,pz,nx,ny,nz,direct_r\n").contains("direct_r is already there"));
        assert!(refused(&format!("{header}1,2,3\n")).contains("3 fields"));
    }
}
