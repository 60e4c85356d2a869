//! What came out, in numbers for people.

use probes::Errors;
use radfile::{BlockFormat, Colour, PackedOperator, ValueMap};
use serde::Serialize;

/// Numbers about a packed operator.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Number of patches.
    pub patches: u32,
    /// Channels of the operator.
    pub channels: u32,
    /// Block format.
    pub format: BlockFormat,
    /// Map from codes to values.
    pub map: ValueMap,
    /// Value of code 1, one a channel.
    pub scale: [f32; 3],
    /// Entries kept apart; of the half, where half is stored.
    pub outliers: usize,
    /// Share of the n² entries that they stand for.
    pub outlier_share: f64,
    /// Bytes of the textures, padding of the tiles included.
    pub texture_bytes: usize,
    /// Bytes of the outliers with their index.
    pub outlier_bytes: usize,
    /// Columns of the basis of colour, all components together; none where the whole matrix is stored.
    pub colour_rank: u32,
    /// Components of the operator that have colour, which share none of it.
    pub colour_components: usize,
    /// Bytes of the colour.
    pub colour_bytes: usize,
    /// Bytes of all.
    pub bytes: usize,
    /// Bytes per entry of the n × n matrix, all channels together.
    pub bytes_per_entry: f64,
    /// How many times smaller than one dense f32 form-factor matrix, which classical radiosity keeps.
    pub smaller_than_form_factors: f64,
    /// Errors under probe lights, if they were measured.
    pub errors: Option<Errors>,
}

impl Report {
    pub(crate) fn new(packed: &PackedOperator, errors: Option<Errors>) -> Report {
        let p = &packed.packing;
        let entries = f64::from(p.n).powi(2);
        let (bytes, texture_bytes) = (packed.size_in_bytes(), packed.blocks.len());
        let half = packed.half.as_ref();
        let colour_bytes = half.map_or(0, Colour::size_in_bytes);
        // Each outlier of the half stands for two entries, but those on the diagonal.
        let outliers = packed.outliers().column.len();
        Report {
            patches: p.n,
            channels: p.channels,
            format: p.format,
            map: p.map,
            scale: p.scale,
            outliers: packed.outlier_column.len(),
            outlier_share: outliers as f64 / entries,
            texture_bytes,
            outlier_bytes: bytes - texture_bytes - colour_bytes,
            colour_rank: half.map_or(0, |colour| colour.rank.iter().sum()),
            colour_components: half.map_or(0, |colour| colour.rank.len()),
            colour_bytes,
            bytes,
            bytes_per_entry: bytes as f64 / entries,
            smaller_than_form_factors: 4.0 * entries / bytes as f64,
            errors,
        }
    }
}
