//! A bounding volume hierarchy with eight children a node, traversed by one ray.
//!
//! obvhs builds a binary tree of high quality; here it is widened, because eight boxes are tested
//! for little more than the price of one. obvhs' own eight-wide tree is not used: its boxes are
//! rounded to 8 bits, it ignores what is nearer than a fixed distance, and it drops nodes of
//! trees that are too deep. None of that is watertight.
//!
//! Sources: I. Wald, C. Benthin, S. Boulos, Getting Rid of Packets, RT 2008 (wide trees for single
//! rays); T. Ize, Robust BVH Ray Traversal, JCGT 2(2), 2013 (rounding of the box test).

use glam::{Vec3, Vec3A, Vec4};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, reinsertion::ReinsertionOptimizer},
    ploc::PlocBuilder,
    splits::split_aabbs_preset,
    triangle::Triangle,
};

use crate::triangle_test::Quad;

/// Three corners.
pub type Corners = [[f32; 3]; 3];

/// Triangles in a search tree.
pub struct WideBvh {
    nodes: Vec<Node>,
    quads: Vec<Quad>,
}

/// Eight boxes: planes of the low x, y, z, then of the high ones; empty ones are inside out.
struct Node {
    planes: [[Vec4; 2]; 6],
    /// Number of a node, or [`LEAF`] and the number of a leaf's first quad.
    child: [u32; 8],
}

const LEAF: u32 = 1 << 31;
/// Subtrees of so many triangles become leaves: one quad.
const LEAF_SIZE: usize = 4;
/// Nodes from the root to the deepest; what lies below becomes one leaf.
const DEPTH: usize = 16;
/// A node leaves at most seven brothers of the child that is entered.
const STACK: usize = 7 * DEPTH + 1;
/// Bound of three roundings in the distance to a plane, on both sides (Ize).
const FAR: f32 = 1.0 + 4.0 * f32::EPSILON;

/// A ray, prepared for testing many boxes.
pub struct BoxRay {
    origin: [Vec4; 3],
    inverse: [Vec4; 3],
    /// Planes that the ray meets first and last.
    near: [usize; 3],
    far: [usize; 3],
}

impl BoxRay {
    pub fn new(origin: Vec3, direction: Vec3) -> BoxRay {
        // The inverse of 0 is capped, as 0 · ∞ would be no number.
        let inverse = direction.to_array().map(|d| (1.0 / d).clamp(-1e30, 1e30));
        let low = |axis: usize| if inverse[axis] < 0.0 { axis + 3 } else { axis };
        BoxRay {
            origin: origin.to_array().map(Vec4::splat),
            inverse: inverse.map(Vec4::splat),
            near: std::array::from_fn(low),
            far: std::array::from_fn(|axis| 2 * axis + 3 - low(axis)),
        }
    }
}

impl Node {
    /// Children whose boxes the ray enters before `reach`, a bit each, and where it enters them.
    #[inline(always)]
    fn meet(&self, ray: &BoxRay, reach: f32) -> (u32, [Vec4; 2]) {
        let half = |h: usize| {
            let distance = |plane: usize, axis: usize| (self.planes[plane][h] - ray.origin[axis]) * ray.inverse[axis];
            let [nx, ny, nz] = [distance(ray.near[0], 0), distance(ray.near[1], 1), distance(ray.near[2], 2)];
            let [fx, fy, fz] = [distance(ray.far[0], 0), distance(ray.far[1], 1), distance(ray.far[2], 2)];
            let near = nx.max(ny).max(nz.max(Vec4::ZERO));
            let far = (fx.min(fy).min(fz) * FAR).min(Vec4::splat(reach));
            (near.cmple(far).bitmask(), near)
        };
        let ((low, near_low), (high, near_high)) = (half(0), half(1));
        (low | high << 4, [near_low, near_high])
    }
}

impl WideBvh {
    /// Builds the tree; every box is padded by `pad`.
    pub fn new(triangles: &[Corners], pad: f32) -> WideBvh {
        let mut tree = WideBvh { nodes: vec![], quads: vec![] };
        let binary = build_binary(triangles, pad);
        if !triangles.is_empty() {
            tree.widen(&binary, triangles, 0, 0);
        }
        tree
    }

    /// Calls `visit` with the quads that the ray may meet, roughly from near to far. `visit` returns how far
    /// the ray still reaches; a negative reach ends the search.
    #[inline(always)]
    pub fn traverse(&self, ray: &BoxRay, mut reach: f32, mut visit: impl FnMut(&Quad) -> f32) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = [(0u32, 0.0f32); STACK];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let (child, near) = stack[top];
            if near > reach {
                continue;
            }
            if child & LEAF != 0 {
                for quad in &self.quads[(child & !LEAF) as usize..] {
                    reach = visit(quad);
                    if quad.last || reach < 0.0 {
                        break;
                    }
                }
                continue;
            }
            let node = &self.nodes[child as usize];
            let (mut hits, near) = node.meet(ray, reach);
            let near: [f32; 8] = std::array::from_fn(|k| near[k / 4][k % 4]);
            let first = top;
            while hits != 0 {
                let k = hits.trailing_zeros() as usize;
                hits &= hits - 1;
                // Sorted in: the nearest is on top.
                let mut at = top;
                while at > first && stack[at - 1].1 < near[k] {
                    stack[at] = stack[at - 1];
                    at -= 1;
                }
                stack[at] = (node.child[k], near[k]);
                top += 1;
            }
        }
    }

    /// Makes a wide node of a binary one and what is below it; returns its number.
    fn widen(&mut self, binary: &Bvh2, triangles: &[Corners], root: u32, depth: usize) -> u32 {
        let number = self.nodes.len();
        let empty = [[Vec4::INFINITY; 2], [Vec4::NEG_INFINITY; 2]];
        self.nodes.push(Node { planes: std::array::from_fn(|p| empty[p / 3]), child: [0; 8] });
        for (k, &child) in children(binary, root).iter().enumerate() {
            let box_ = binary.nodes[child as usize].aabb();
            for axis in 0..3 {
                self.nodes[number].planes[axis][k / 4][k % 4] = box_.min[axis];
                self.nodes[number].planes[axis + 3][k / 4][k % 4] = box_.max[axis];
            }
            let members = members(binary, child, if depth + 1 < DEPTH { LEAF_SIZE } else { usize::MAX });
            self.nodes[number].child[k] = match members {
                Some(members) => self.add_leaf(triangles, members),
                None => self.widen(binary, triangles, child, depth + 1),
            };
        }
        number as u32
    }

    fn add_leaf(&mut self, triangles: &[Corners], mut members: Vec<u32>) -> u32 {
        let first = self.quads.len() as u32;
        // Split triangles may have come here more than once.
        members.sort_unstable();
        members.dedup();
        for four in members.chunks(4) {
            let four: Vec<_> = four.iter().map(|&t| (t, triangles[t as usize])).collect();
            self.quads.push(Quad::new(&four));
        }
        self.quads.last_mut().expect("a leaf has triangles").last = true;
        LEAF | first
    }
}

/// Up to eight nodes below `root`: the largest is opened until there is no more room. What fits into a
/// leaf stays together: a full quad costs no more than one of a single triangle.
fn children(binary: &Bvh2, root: u32) -> Vec<u32> {
    let node = |n: u32| &binary.nodes[n as usize];
    let mut open = vec![root];
    while open.len() < 8 {
        let can_open =
            |&(_, &n): &(usize, &u32)| !node(n).is_leaf() && (n == root || members(binary, n, LEAF_SIZE).is_none());
        let area = |n: u32| node(n).aabb().half_area();
        let largest = open.iter().enumerate().filter(can_open).max_by(|a, b| area(*a.1).total_cmp(&area(*b.1)));
        let Some((at, &n)) = largest else { break };
        let pair = node(n).first_index;
        open[at] = pair;
        open.push(pair + 1);
    }
    open
}

/// Triangles below a node, `None` if there are more than `most`.
fn members(binary: &Bvh2, root: u32, most: usize) -> Option<Vec<u32>> {
    let (mut members, mut open) = (Vec::new(), vec![root]);
    while let Some(n) = open.pop() {
        let node = &binary.nodes[n as usize];
        if node.is_leaf() {
            let first = node.first_index as usize;
            members.extend_from_slice(&binary.primitive_indices[first..first + node.prim_count as usize]);
        } else {
            open.extend([node.first_index, node.first_index + 1]);
        }
        if members.len() + open.len() > most {
            return None;
        }
    }
    Some(members)
}

/// The slow, good build of obvhs: large triangles are split, boxes padded.
fn build_binary(triangles: &[Corners], pad: f32) -> Bvh2 {
    let params = BvhBuildParams::very_slow_build();
    let triangles: Vec<Triangle> =
        triangles.iter().map(|&[a, b, c]| Triangle { v0: a.into(), v1: b.into(), v2: c.into() }).collect();
    let mut boxes: Vec<Aabb> = triangles.iter().map(Triangle::aabb).collect();
    let mut indices: Vec<u32> = (0..triangles.len() as u32).collect();
    let largest = boxes.iter().map(Aabb::half_area).fold(0.0, f32::max);
    let mean = boxes.iter().map(Aabb::half_area).sum::<f32>() / boxes.len().max(1) as f32;
    split_aabbs_preset(&mut boxes, &mut indices, &triangles, mean, largest);
    for b in &mut boxes {
        b.min -= Vec3A::splat(pad);
        b.max += Vec3A::splat(pad);
    }
    let mut binary = PlocBuilder::with_capacity(boxes.len()).build(
        params.ploc_search_distance,
        &boxes,
        indices,
        params.sort_precision,
        params.search_depth_threshold,
    );
    binary.uses_spatial_splits = true;
    ReinsertionOptimizer::default().run(&mut binary, params.reinsertion_batch_ratio, None);
    binary
}
