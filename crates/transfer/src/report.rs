//! What was made, for people.

use serde::Serialize;

use crate::rows::Row;

/// The fine mesh, its receivers, and how light comes to them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Longest edge that was left whole, metres.
    pub edge: f32,
    /// Vertices of the fine mesh.
    pub fine_vertices: usize,
    /// Triangles of the fine mesh.
    pub fine_triangles: usize,
    /// Sides of fine vertices that receive light.
    pub receivers: usize,
    /// How it is interpolated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interpolated: Option<Interpolated>,
    /// How it is gathered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gathered: Option<Gathered>,
    /// The lightmap.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lightmap: Option<Lightmap>,
    /// The irradiance volume.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume: Option<Volume>,
}

/// A lightmap and what its texels gather.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Lightmap {
    /// Where the coordinates of the mesh come from.
    pub coordinates: String,
    /// How its texels are placed.
    #[serde(flatten)]
    pub placed: lightmap::Report,
    /// Their form factors.
    pub gathered: Gathered,
}

/// An irradiance volume and what its probes gather.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Volume {
    /// Cells along x, y and z.
    pub count: [u32; 3],
    /// Edges of a cell, metres.
    pub spacing: [f32; 3],
    /// Cells with a probe of their own.
    pub probes: usize,
    /// Cells that lie inside or behind something and show a probe nearby.
    pub filled: usize,
    /// Form factors of the probes, six receivers each.
    pub gathered: Gathered,
}

/// Rows of weights over patches nearby.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Interpolated {
    /// Weights in all rows.
    pub entries: usize,
    /// Weights in a row, on average.
    pub mean_row: f64,
    /// Weights in the longest row.
    pub longest_row: usize,
    /// Rows without a weight.
    pub empty_rows: usize,
    /// Rows that found no patch in sight and take the patch that they lie on.
    pub fallback_rows: usize,
    /// Rows that found patches only beyond the first radius.
    pub widened_rows: usize,
}

impl Interpolated {
    pub(crate) fn of(rows: &[Row]) -> Interpolated {
        let count = |f: fn(&Row) -> bool| rows.iter().filter(|r| f(r)).count();
        let entries = rows.iter().map(|r| r.entries.len()).sum();
        Interpolated {
            entries,
            mean_row: entries as f64 / rows.len().max(1) as f64,
            longest_row: rows.iter().map(|r| r.entries.len()).max().unwrap_or(0),
            empty_rows: count(|r| r.entries.is_empty()),
            fallback_rows: count(|r| r.fallback),
            widened_rows: count(|r| r.widened),
        }
    }
}

/// Packed form factors of receivers.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Gathered {
    /// Elements that light is gathered from.
    pub elements: usize,
    /// Rays of each receiver.
    pub rays: u32,
    /// Elements that a receiver sees, on average.
    pub mean_row: f64,
    /// Numbers of the receivers that lie inside of something: their rays meet no patch and no sky.
    #[serde(serialize_with = "count")]
    pub buried: Vec<u32>,
    /// Bytes of the packed rows.
    pub bytes: usize,
    /// Bytes per receiver.
    pub bytes_per_receiver: f64,
    /// Error of light that packing was allowed; shares, 0.01 is 1 %.
    pub error_wanted: f64,
    /// L2 norm of that error relative to that of the light, mean over probe lights that packing did not see.
    pub l2_mean: f64,
    /// 99th percentile of the error relative to what is seen at the place, mean over the same.
    pub vis99: f64,
}

/// A report says how many there are.
fn count<S: serde::Serializer>(numbers: &[u32], serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.serialize_u64(numbers.len() as u64)
}
