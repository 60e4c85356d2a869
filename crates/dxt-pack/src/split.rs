//! Which entries go to the texture and which are kept apart.

use radfile::Operator;
use rayon::prelude::*;

use crate::{Error, Result, quantile::threshold};

/// The operator cut in two by a threshold a channel.
pub struct Split<'a> {
    operator: &'a Operator<'a>,
    thresholds: Vec<f32>,
    /// Whether entries above the diagonal are left to those below.
    half: bool,
    /// Largest value of each channel among the entries that are no outliers.
    pub scale: [f32; 3],
    /// `n` + 1 offsets into `column`.
    pub start: Vec<u32>,
    /// Columns of the outliers, increasing within a row.
    pub column: Vec<u32>,
}

impl<'a> Split<'a> {
    /// Keeps apart every entry that exceeds the (1 − `share`) quantile of its channel in some channel.
    ///
    /// With `half` only entries on and below the diagonal are looked at, of which each stands for two.
    ///
    /// One position serves all channels, because the index of an outlier costs as much as a value and
    /// the largest entries of the channels nearly coincide.
    ///
    /// # Errors
    ///
    /// [`Error::TooManyOutliers`].
    pub fn new(operator: &'a Operator<'a>, share: f64, half: bool) -> Result<Split<'a>> {
        let thresholds = (0..operator.channels).map(|c| threshold(operator.channel(c), share)).collect();
        let mut split = Split { operator, thresholds, half, scale: [0.0; 3], start: vec![0], column: Vec::new() };
        let rows: Vec<(Vec<u32>, [f32; 3])> = (0..operator.n).into_par_iter().map(|row| split.row(row)).collect();
        let count = rows.iter().map(|(columns, _)| columns.len() as u64).sum();
        check_count(count)?;
        split.column.reserve_exact(count as usize);
        for (columns, largest) in rows {
            split.column.extend(columns);
            split.start.push(split.column.len() as u32);
            split.scale = std::array::from_fn(|c| split.scale[c].max(largest[c]));
        }
        Ok(split)
    }

    /// Outliers of a row, and the largest of its other values in each channel.
    fn row(&self, row: usize) -> (Vec<u32>, [f32; 3]) {
        let n = self.operator.n;
        let mut largest = [0f32; 3];
        let mut columns = Vec::new();
        for column in 0..if self.half { row + 1 } else { n } {
            if self.is_outlier(row, column) {
                columns.push(column as u32);
            } else {
                largest = std::array::from_fn(|c| largest[c].max(self.operator.channel(c)[row * n + column]));
            }
        }
        (columns, largest)
    }

    /// Whether an entry is kept apart.
    pub fn is_outlier(&self, row: usize, column: usize) -> bool {
        let at = row * self.operator.n + column;
        self.thresholds.iter().enumerate().any(|(c, &t)| self.operator.channel(c)[at] > t)
    }

    /// One entry of one channel in units of the channel's scale; above 1 only for outliers.
    pub fn relative(&self, channel: usize, row: usize, column: usize) -> f32 {
        let value = self.operator.channel(channel)[row * self.operator.n + column];
        if self.scale[channel] > 0.0 { value / self.scale[channel] } else { 0.0 }
    }
}

/// Offsets into the list of outliers are 32 bits wide.
fn check_count(count: u64) -> Result<()> {
    if count > u64::from(u32::MAX) { Err(Error::TooManyOutliers { count }) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_outliers_than_the_format_indexes_are_refused() {
        assert!(check_count(4_294_967_295).is_ok());
        assert_eq!(
            check_count(4_294_967_296).unwrap_err().to_string(),
            "4294967296 outliers, the format indexes up to 4294967295; lower the share of outliers or use fewer patches"
        );
    }
}
