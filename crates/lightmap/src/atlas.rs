//! Where the triangles of a mesh lie in the plane of the texels.

use std::collections::HashMap;

use crate::{edges::Sets, flat::Flat};

/// Chart of a triangle that lies in none: it has no area, and neither has a triangle around it.
pub const NO_CHART: u32 = u32::MAX;

/// A mesh laid out flat.
///
/// Coordinates are those of glTF: (0, 0) is the outer corner of the first texel of the first row, (1, 1) that of the last
/// texel of the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Atlas {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Corners of each triangle of the mesh, 0 to 1.
    pub corner_uv: Vec<[[f32; 2]; 3]>,
    /// Chart of each triangle, or [`NO_CHART`]. Triangles of a chart lie together on the mesh and in the atlas.
    pub chart: Vec<u32>,
    /// Texels around each chart that belong to it.
    pub padding: u32,
}

impl Atlas {
    /// Number of charts.
    pub fn charts(&self) -> usize {
        self.chart.iter().filter(|&&c| c != NO_CHART).max().map_or(0, |&c| c as usize + 1)
    }

    /// Corners of a triangle, in texels.
    pub(crate) fn corners(&self, triangle: u32) -> Flat {
        let size = [self.width, self.height].map(f64::from);
        self.corner_uv[triangle as usize].map(|uv| [0, 1].map(|k| f64::from(uv[k]) * size[k]))
    }
}

/// Charts of triangles by their coordinates: those that have an edge in common are of one chart. Numbered by their first
/// triangle.
pub fn charts_of(corner_uv: &[[[f32; 2]; 3]]) -> Vec<u32> {
    let mut sets = Sets::new(corner_uv.len());
    let mut edges: HashMap<[[u32; 2]; 2], u32> = HashMap::with_capacity(3 * corner_uv.len() / 2);
    for (t, corners) in (0u32..).zip(corner_uv) {
        let corners = corners.map(|uv| uv.map(|x| (x + 0.0).to_bits()));
        for k in 0..3 {
            let mut edge = [corners[k], corners[(k + 1) % 3]];
            edge.sort_unstable();
            sets.join(t, *edges.entry(edge).or_insert(t));
        }
    }
    let mut number = HashMap::new();
    let numbered = |t: u32| {
        let next = number.len() as u32;
        *number.entry(sets.root(t)).or_insert(next)
    };
    (0..corner_uv.len() as u32).map(numbered).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_with_a_common_edge_are_one_chart_and_those_with_a_common_corner_are_not() {
        let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let far = [[0.0, 0.0], [0.25, 0.5], [0.5, 0.25]];
        assert_eq!(charts_of(&[far, [a, b, c], [d, a, c]]), [0, 1, 1]);
    }
}
