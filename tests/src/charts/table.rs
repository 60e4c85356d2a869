//! Numbers behind a chart, as CSV.

use std::fmt::Write;

/// One column.
pub struct Column {
    pub name: &'static str,
    /// What it holds, with its unit.
    pub meaning: &'static str,
}

/// A cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    Word(String),
    Number(f64),
    /// The method gave no answer.
    Nothing,
}

/// Rows of named columns. The first `keys` columns tell rows apart.
pub struct Table {
    pub about: String,
    pub columns: Vec<Column>,
    pub keys: usize,
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// The file: comment lines that say what the columns mean, the header, the rows.
    pub fn csv(&self) -> String {
        let mut text = format!("# {}\n", self.about);
        for column in &self.columns {
            writeln!(text, "# {}: {}", column.name, column.meaning).expect("writing to a string");
        }
        let header: Vec<&str> = self.columns.iter().map(|c| c.name).collect();
        writeln!(text, "{}", header.join(",")).expect("writing to a string");
        for row in &self.rows {
            let cells: Vec<String> = row.iter().map(Cell::text).collect();
            writeln!(text, "{}", cells.join(",")).expect("writing to a string");
        }
        text
    }
}

impl Cell {
    /// As in the file: numbers with six digits.
    pub fn text(&self) -> String {
        match self {
            Cell::Word(word) => word.clone(),
            Cell::Number(value) => {
                let short: f64 = format!("{value:.5e}").parse().expect("a number was written");
                let plain = short == 0.0 || (1e-4..1e7).contains(&short.abs());
                if plain { format!("{short}") } else { format!("{short:e}") }
            }
            Cell::Nothing => String::new(),
        }
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Cell {
        if value.is_finite() { Cell::Number(value) } else { Cell::Nothing }
    }
}

impl From<&str> for Cell {
    fn from(word: &str) -> Cell {
        Cell::Word(word.to_owned())
    }
}

impl From<Option<f64>> for Cell {
    fn from(value: Option<f64>) -> Cell {
        value.map_or(Cell::Nothing, Cell::from)
    }
}

/// When two numbers that should be one are taken for it: rounding differs from one kind of processor to another.
#[derive(Clone, Copy, Debug)]
pub struct Agreement {
    /// The larger is at most this multiple of the smaller.
    pub factor: f64,
    /// Numbers up to this size are all alike.
    pub floor: f64,
}

impl Agreement {
    pub fn holds(&self, a: &Cell, b: &Cell) -> bool {
        match (a, b) {
            (Cell::Number(a), Cell::Number(b)) => {
                let (small, large) = if a.abs() < b.abs() { (*a, *b) } else { (*b, *a) };
                large.abs() <= self.floor || (small.signum() == large.signum() && large / small <= self.factor)
            }
            _ => a == b,
        }
    }
}

/// Rows of a file that [`Table::csv`] wrote.
pub fn rows(csv: &str) -> Vec<Vec<Cell>> {
    let cell = |text: &str| match text.parse() {
        Ok(number) => Cell::Number(number),
        Err(_) if text.is_empty() => Cell::Nothing,
        Err(_) => Cell::from(text),
    };
    let lines = csv.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines.map(|line| line.split(',').map(cell).collect()).collect()
}
