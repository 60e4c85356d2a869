//! Which texels a triangle touches, and how much of each it covers.
//!
//! Coverage is conservative: a texel of which any part lies in a triangle is touched, because a bilinear filter at that
//! part reads it. Every triangle touches at least one texel, however small it is.

use rayon::prelude::*;

use crate::{
    Atlas,
    atlas::NO_CHART,
    flat::{Flat, Point, Polygon},
};

/// A triangle must reach into a texel by more than this, in texels: charts are laid along its sides, and rounding would
/// let them touch the texels beyond.
const INSET: f64 = 1e-3;

/// The part of a triangle that lies in one texel.
#[derive(Clone, Copy, Debug)]
pub struct Fragment {
    /// Number of the texel, row by row.
    pub texel: u32,
    pub triangle: u32,
    /// Part of the texel that is covered, 0 to 1.
    pub area: f32,
    /// Centroid of that part, from the texel's corner, in texels.
    pub centroid: [f32; 2],
}

/// Fragments of all triangles of an atlas, by texel and then by triangle.
pub fn fragments(atlas: &Atlas) -> Vec<Fragment> {
    let size = [atlas.width, atlas.height];
    let mut all: Vec<Fragment> = (0..atlas.corner_uv.len() as u32)
        .into_par_iter()
        .filter(|&t| atlas.chart[t as usize] != NO_CHART)
        .flat_map_iter(|triangle| {
            let mut own = Vec::new();
            touch(atlas.corners(triangle), size, |[x, y], part| {
                let (area, centroid) = part.area_and_centroid();
                let from = [x, y].map(f64::from);
                let centroid = [0, 1].map(|k| (centroid[k] - from[k]) as f32);
                own.push(Fragment { texel: y * atlas.width + x, triangle, area: area as f32, centroid });
            });
            own
        })
        .collect();
    all.par_sort_unstable_by_key(|f| (f.texel, f.triangle));
    all
}

/// Calls `visit` with the column and row of every texel that a triangle touches, and with what lies in it.
pub fn touch(corners: Flat, size: [u32; 2], mut visit: impl FnMut([u32; 2], &Polygon)) {
    let mut met = false;
    touch_inset(corners, size, INSET, |texel, part| {
        met = true;
        visit(texel, part);
    });
    if !met {
        // It is thinner than the inset and lies on the sides of texels.
        touch_inset(corners, size, 0.0, visit);
    }
}

fn touch_inset(corners: Flat, size: [u32; 2], inset: f64, mut visit: impl FnMut([u32; 2], &Polygon)) {
    let whole = Polygon::triangle(corners);
    let steps = |p: &Polygon, axis: usize| {
        let [low, high] = p.range(axis).map(|x| x.clamp(0.0, f64::from(size[axis] - 1)) as u32);
        low..=high
    };
    let within = |p: &Polygon, axis: usize, k: u32| p.between(axis, f64::from(k) + inset, f64::from(k + 1) - inset);
    for y in steps(&whole, 1) {
        let row = within(&whole, 1, y);
        if row.is_empty() {
            continue;
        }
        for x in steps(&row, 0) {
            let part = within(&row, 0, x);
            if !part.is_empty() {
                visit([x, y], &part);
            }
        }
    }
}

/// Number of texels that the charts touch if each is scaled and lies in a corner of the texels' grid.
///
/// `charts` are triangles of each chart, from its lowest coordinates on; 2^24 texels a chart at most are counted.
pub fn count(charts: &[Vec<Flat>], scale: f64) -> u64 {
    const MOST: f64 = (1 << 24) as f64;
    let of_chart = |triangles: &Vec<Flat>| {
        let scaled = |p: Point| p.map(|x| scale * x);
        let highest = |axis: usize| triangles.iter().flatten().map(|p| p[axis]).fold(0.0, f64::max);
        let extent = [0, 1].map(|axis| (scale * highest(axis)).ceil().max(1.0));
        if extent[0] * extent[1] > MOST {
            return (extent[0] * extent[1]) as u64;
        }
        let size = extent.map(|e| e as u32);
        let mut touched = vec![false; (size[0] * size[1]) as usize];
        for triangle in triangles {
            touch(triangle.map(scaled), size, |[x, y], _| touched[(y * size[0] + x) as usize] = true);
        }
        touched.iter().filter(|t| **t).count() as u64
    };
    charts.par_iter().map(of_chart).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touched(corners: Flat, size: [u32; 2]) -> Vec<([u32; 2], f64)> {
        let mut all = Vec::new();
        touch(corners, size, |texel, part| all.push((texel, part.area_and_centroid().0)));
        all
    }

    #[test]
    fn texels_of_a_right_triangle_are_those_below_its_hypotenuse() {
        let all = touched([[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]], [4, 4]);
        let texels: Vec<[u32; 2]> = all.iter().map(|t| t.0).collect();
        assert_eq!(texels, [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [0, 2]]);
        let area: f64 = all.iter().map(|t| t.1).sum();
        // Three whole texels and three halves, each less its inset.
        assert!((area - 4.5).abs() < 24.0 * INSET, "{area}");
    }

    #[test]
    fn what_lies_along_the_side_of_a_texel_does_not_touch_the_next() {
        let texels: Vec<[u32; 2]> = touched([[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]], [4, 4]).iter().map(|t| t.0).collect();
        assert_eq!(texels, [[1, 1]]);
    }

    #[test]
    fn triangles_of_no_size_touch_a_texel() {
        for corners in [[[1.5, 1.5]; 3], [[2.0, 1.0]; 3], [[4.0, 4.0]; 3], [[0.0, 2.0], [4.0, 2.0], [4.0, 2.0]]] {
            assert!(!touched(corners, [4, 4]).is_empty(), "{corners:?}");
        }
        // A sliver of a hundredth of a texel crosses all texels of its row.
        assert_eq!(touched([[0.1, 1.5], [3.9, 1.5], [3.9, 1.51]], [4, 4]).len(), 4);
    }

    #[test]
    fn counts_of_charts_are_those_of_their_texels() {
        let square = vec![[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]], [[0.0, 0.0], [2.0, 2.0], [0.0, 2.0]]];
        assert_eq!(count(&[square.clone(), square], 1.5), 18);
    }
}
