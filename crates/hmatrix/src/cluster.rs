//! A balanced binary tree of patches: those that lie near each other and face alike are together.
//!
//! Every cluster is halved across the direction in which its patches spread most, in the space of position and
//! normal. All leaves are equally deep and their sizes differ by one at most, so the tree is known from the
//! number of patches and its depth alone. Receivers, which may be many more, have a tree for each chunk of them.

use std::ops::Range;

/// How far apart opposite directions are, as a share of the scene's extent. Measured: 0.05 to 0.1 give the fewest
/// bytes, ten times as much costs a fifth more.
const FACING: f64 = 0.07;

/// Shape of a tree, or of several side by side: level l has 2^l clusters below each root.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tree {
    /// Patches.
    pub n: usize,
    /// Clusters of level 0; the first ones larger by one if need be. None if there are no patches.
    pub roots: usize,
    /// Levels below the root; no more than patches allow.
    pub depth: u32,
}

impl Tree {
    /// With leaves of at most `leaf` patches.
    pub fn new(n: usize, leaf: usize) -> Tree {
        Tree { n, roots: 1, depth: n.div_ceil(leaf).next_power_of_two().ilog2() }
    }

    /// Clusters of a level.
    pub fn count(&self, level: u32) -> usize {
        self.roots << level
    }

    /// Places of the largest cluster of a level.
    pub fn largest(&self, level: u32) -> usize {
        self.range(level, 0).len()
    }

    /// Places of cluster `index` of `level`: a root, halved again and again, the first half larger by one if need be.
    pub fn range(&self, level: u32, index: usize) -> Range<usize> {
        let (root, roots) = (index >> level, self.roots.max(1));
        let (mut len, larger) = (self.n / roots, self.n % roots);
        let mut start = root * len + root.min(larger);
        len += usize::from(root < larger);
        for l in (0..level).rev() {
            let half = len.div_ceil(2);
            if index >> l & 1 == 1 {
                start += half;
                len -= half;
            } else {
                len = half;
            }
        }
        start..start + len
    }
}

/// Patch at each place: those of a cluster of `tree` stand together. Patches of different groups, the number of which is
/// given for each patch, are apart as far as sizes of clusters allow.
pub fn order(position: &[[f32; 3]], normal: &[[f32; 3]], groups: &[u32], tree: Tree) -> Vec<u32> {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for p in position {
        for a in 0..3 {
            low[a] = low[a].min(p[a].into());
            high[a] = high[a].max(p[a].into());
        }
    }
    let extent = (0..3).map(|a| high[a] - low[a]).fold(f64::MIN_POSITIVE, f64::max);
    let place = |(p, m): (&[f32; 3], &[f32; 3])| -> Feature {
        std::array::from_fn(|k| if k < 3 { f64::from(p[k]) / extent } else { FACING * f64::from(m[k - 3]) })
    };
    let features: Vec<Feature> = position.iter().zip(normal).map(place).collect();
    let mut order: Vec<u32> = (0..tree.n as u32).collect();
    part(&features, groups, &mut order, tree, 0..tree.roots);
    order
}

type Feature = [f64; 6];

/// Parts the roots from each other, then halves each.
fn part(features: &[Feature], groups: &[u32], order: &mut [u32], tree: Tree, roots: Range<usize>) {
    if roots.len() < 2 {
        return halve(features, groups, order, tree.depth);
    }
    let middle = roots.start + roots.len().div_ceil(2);
    let size = tree.range(0, middle).start - tree.range(0, roots.start).start;
    let (left, right) = cut(features, groups, order, size);
    part(features, groups, left, tree, roots.start..middle);
    part(features, groups, right, tree, middle..roots.end);
}

fn halve(features: &[Feature], groups: &[u32], order: &mut [u32], depth: u32) {
    if depth == 0 {
        return;
    }
    let (left, right) = cut(features, groups, order, order.len().div_ceil(2));
    halve(features, groups, left, depth - 1);
    halve(features, groups, right, depth - 1);
}

/// Cuts across the direction of the largest spread, so that the first part has `size`.
fn cut<'a>(features: &[Feature], groups: &[u32], order: &'a mut [u32], size: usize) -> (&'a mut [u32], &'a mut [u32]) {
    let axis = principal_axis(features, order);
    let along = |p: &u32| -> f64 { axis.iter().zip(&features[*p as usize]).map(|(a, f)| a * f).sum() };
    let group = |p: &u32| groups[*p as usize];
    order.sort_by(|a, b| group(a).cmp(&group(b)).then(along(a).total_cmp(&along(b))).then(a.cmp(b)));
    order.split_at_mut(size)
}

/// Direction of the largest spread, by power iteration on the covariance.
fn principal_axis(features: &[Feature], order: &[u32]) -> Feature {
    let mut mean = [0.0; 6];
    for &p in order {
        mean = std::array::from_fn(|k| mean[k] + features[p as usize][k] / order.len() as f64);
    }
    let mut covariance = [[0.0; 6]; 6];
    for &p in order {
        let d: Feature = std::array::from_fn(|k| features[p as usize][k] - mean[k]);
        for i in 0..6 {
            for j in 0..6 {
                covariance[i][j] += d[i] * d[j];
            }
        }
    }
    // Not along any axis of a symmetric room, and not zero where all patches coincide.
    let mut axis: Feature = std::array::from_fn(|k| covariance[k][k].sqrt() + 1e-12 * (k + 1) as f64);
    for _ in 0..100 {
        let next: Feature = std::array::from_fn(|i| (0..6).map(|j| covariance[i][j] * axis[j]).sum());
        let norm = next.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm == 0.0 {
            break;
        }
        axis = next.map(|x| x / norm);
    }
    axis
}
