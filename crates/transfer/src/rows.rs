//! Rows of single receivers, and all of them as one table.

use radfile::Rows;

/// The weights of one receiver.
#[derive(Default)]
pub struct Row {
    /// Sender and weight.
    pub entries: Vec<(u32, f32)>,
    /// No patch was in sight; the one that the receiver lies on stands in.
    pub fallback: bool,
    /// The first radius held no patch in sight.
    pub widened: bool,
}

/// Rows one after the other.
pub fn join(rows: Vec<Row>) -> Rows {
    let mut joined = Rows { row_start: vec![0], ..Rows::default() };
    for row in rows {
        for (sender, weight) in row.entries {
            joined.sender.push(sender);
            joined.weight.push(weight);
        }
        joined.row_start.push(joined.sender.len() as u32);
    }
    joined
}
