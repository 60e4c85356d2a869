//! Patches joined pair by pair, where that costs least.
//!
//! J. H. Ward, Hierarchical grouping to optimize an objective function, JASA 58, 1963: of all neighbours the two are
//! joined that lose least of what is told apart, again and again, until so many are left as are wanted. What is told
//! apart are irradiances under many lamps, weighed by area, so the loss is the growth of the squared error of patches
//! that carry one irradiance each. Where light is smooth large patches arise, across a steep change narrow ones.
//!
//! Lamps that were not tried will differ elsewhere. So places and reflectances are told apart, too, in proportion to
//! the light that arrives ([`Weights`]).

use std::{cmp::Ordering, collections::BinaryHeap};

use glam::DVec3;

use crate::sets::root;

/// Cosine of 35°: neighbours that face apart by more stay apart, as within a voxel.
pub const CONE: f64 = 0.819;
/// Cosine of 60°: the same for what does not touch.
const WIDE_CONE: f64 = 0.5;
/// Least length of the mean of a patch's normals: that of an arc of 104°, and of two that face apart by 60°.
const FLAT: f64 = 0.866;

/// How much differences of place and reflectance count.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    /// Of a squared metre, relative to squared irradiance.
    pub place: f64,
    /// Of a squared difference in reflectance.
    pub reflectance: f64,
}

/// What is known of a patch; means are those of its members.
pub struct Node {
    /// m².
    pub area: f64,
    /// Sum of area times normal.
    pub normal: DVec3,
    /// Mean irradiance under every lamp.
    pub light: Vec<f64>,
    /// Area times mean square of the irradiance.
    pub mass: f64,
    /// Mean by mass.
    pub place: DVec3,
    /// Mean by mass.
    pub reflectance: DVec3,
    /// Nodes of different kinds are never joined.
    pub kind: u32,
}

impl Node {
    /// What is lost if two are one.
    fn loss(&self, other: &Node, weights: &Weights) -> f64 {
        let light: f64 = self.light.iter().zip(&other.light).map(|(a, b)| (a - b).powi(2)).sum();
        let place = weights.place * self.place.distance_squared(other.place)
            + weights.reflectance * self.reflectance.distance_squared(other.reflectance);
        harmonic(self.area, other.area) * light + harmonic(self.mass, other.mass) * place
    }

    /// Whether two face alike enough, within a cone of this cosine.
    fn fits(&self, other: &Node, cone: f64) -> bool {
        let (a, b) = (self.normal, other.normal);
        self.kind == other.kind
            && a.dot(b) >= cone * a.length() * b.length()
            && (a + b).length() >= FLAT * (self.area + other.area)
    }

    fn join(&mut self, other: &Node) {
        let share = other.area / (self.area + other.area);
        self.light.iter_mut().zip(&other.light).for_each(|(a, b)| *a += share * (b - *a));
        let mass = self.mass + other.mass;
        let share = if mass > 0.0 { other.mass / mass } else { share };
        self.place += share * (other.place - self.place);
        self.reflectance += share * (other.reflectance - self.reflectance);
        self.area += other.area;
        self.mass = mass;
        self.normal += other.normal;
    }
}

/// a b / (a + b).
fn harmonic(a: f64, b: f64) -> f64 {
    if a + b > 0.0 { a * b / (a + b) } else { 0.0 }
}

/// Nodes, who is next to whom, and who has joined whom.
pub struct Forest {
    nodes: Vec<Node>,
    weights: Weights,
    parent: Vec<u32>,
    /// For every root its neighbours, by numbers that may have joined others since, and whether they touch.
    around: Vec<Vec<(u32, bool)>>,
    /// How often a root has changed.
    age: Vec<u32>,
    heap: BinaryHeap<Pair>,
    count: usize,
}

/// Two roots that may be joined, if neither has changed since.
struct Pair {
    loss: f64,
    nodes: [u32; 2],
    age: [u32; 2],
}

impl Ord for Pair {
    fn cmp(&self, other: &Pair) -> Ordering {
        // The least loss is the greatest; among equals the first.
        other.loss.total_cmp(&self.loss).then_with(|| other.nodes.cmp(&self.nodes))
    }
}

impl PartialOrd for Pair {
    fn partial_cmp(&self, other: &Pair) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Pair {
    fn eq(&self, other: &Pair) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Pair {}

impl Forest {
    /// Nodes that have joined none yet; only those that are `kept` count.
    pub fn new(nodes: Vec<Node>, kept: &[bool], weights: Weights) -> Forest {
        let n = nodes.len();
        Forest {
            count: kept.iter().filter(|&&kept| kept).count(),
            parent: (0..n as u32).collect(),
            around: vec![Vec::new(); n],
            age: vec![0; n],
            heap: BinaryHeap::new(),
            nodes,
            weights,
        }
    }

    /// Number of patches.
    pub fn count(&self) -> usize {
        self.count
    }

    pub fn node(&self, root: u32) -> &Node {
        &self.nodes[root as usize]
    }

    /// The patch that a node is part of now.
    pub fn root(&mut self, node: u32) -> u32 {
        root(&mut self.parent, node)
    }

    /// Makes neighbours of pairs that touch or, if they do not, may still be joined.
    pub fn link(&mut self, pairs: impl IntoIterator<Item = [u32; 2]>, touching: bool) {
        for [a, b] in pairs {
            let (a, b) = (self.root(a), self.root(b));
            if a != b {
                self.around[a as usize].push((b, touching));
                self.around[b as usize].push((a, touching));
                self.offer(a, b, touching);
            }
        }
    }

    fn offer(&mut self, a: u32, b: u32, touching: bool) {
        let (a, b) = (a.min(b), a.max(b));
        let [one, other] = [a, b].map(|k| &self.nodes[k as usize]);
        if one.fits(other, if touching { CONE } else { WIDE_CONE }) {
            let age = [self.age[a as usize], self.age[b as usize]];
            self.heap.push(Pair { loss: one.loss(other, &self.weights), nodes: [a, b], age });
        }
    }

    /// Joins until `wanted` are left or no two may be joined.
    pub fn join_until(&mut self, wanted: usize) {
        while self.count > wanted
            && let Some(Pair { nodes: [a, b], age, .. }) = self.heap.pop()
        {
            if age == [self.age[a as usize], self.age[b as usize]] {
                self.join(a, b);
            }
        }
    }

    /// The larger number becomes part of the smaller.
    fn join(&mut self, a: u32, b: u32) {
        let [into, from] = self.nodes.get_disjoint_mut([a as usize, b as usize]).expect("two nodes");
        into.join(from);
        from.light = vec![];
        self.parent[b as usize] = a;
        self.age[a as usize] += 1;
        self.age[b as usize] = u32::MAX;
        self.count -= 1;
        let mut around = std::mem::take(&mut self.around[a as usize]);
        around.append(&mut self.around[b as usize]);
        for (other, _) in &mut around {
            *other = self.root(*other);
        }
        // Who touches comes first, and stays.
        around.sort_unstable_by_key(|&(other, touching)| (other, !touching));
        around.dedup_by_key(|(other, _)| *other);
        around.retain(|&(other, _)| other != a);
        for &(other, touching) in &around {
            self.offer(a, other, touching);
        }
        self.around[a as usize] = around;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIGHT_ONLY: Weights = Weights { place: 0.0, reflectance: 0.0 };

    fn node(light: f64) -> Node {
        Node {
            area: 1.0,
            normal: DVec3::Z,
            light: vec![light],
            mass: 1.0,
            place: DVec3::ZERO,
            reflectance: DVec3::ZERO,
            kind: 0,
        }
    }

    fn row(lights: &[f64], wanted: usize) -> Vec<u32> {
        let nodes: Vec<Node> = lights.iter().map(|&l| node(l)).collect();
        let mut forest = Forest::new(nodes, &vec![true; lights.len()], LIGHT_ONLY);
        forest.link((1..lights.len() as u32).map(|k| [k - 1, k]), true);
        forest.join_until(wanted);
        assert_eq!(forest.count(), wanted);
        (0..lights.len() as u32).map(|k| forest.root(k)).collect()
    }

    #[test]
    fn borders_are_left_where_light_changes() {
        assert_eq!(row(&[1.0, 1.1, 1.0, 5.0, 5.2, 1.0], 3), [0, 0, 0, 3, 3, 5]);
    }

    /// The loss of joining two means is that of their members: Σ a (h − mean)² grows by it.
    #[test]
    fn losses_add_up_to_the_squared_error() {
        let lights = [0.3, 1.7, 0.4, 2.0];
        let mut sum = node(lights[0]);
        let mut lost = 0.0;
        for &light in &lights[1..] {
            lost += sum.loss(&node(light), &LIGHT_ONLY);
            sum.join(&node(light));
        }
        let mean = lights.iter().sum::<f64>() / 4.0;
        let squares: f64 = lights.iter().map(|l| (l - mean).powi(2)).sum();
        assert!((lost - squares).abs() < 1e-12, "{lost}, expected {squares}");
        assert!((sum.light[0] - mean).abs() < 1e-12 && sum.area == 4.0);
    }

    #[test]
    fn other_kinds_and_other_facings_stay_apart() {
        let turned = Node { normal: DVec3::X, ..node(1.0) };
        let nodes = vec![node(1.0), turned, node(1.0), Node { kind: 1, ..node(1.0) }, node(1.0)];
        let mut forest = Forest::new(nodes, &[true; 5], LIGHT_ONLY);
        forest.link([[0, 1], [1, 2], [2, 3], [3, 4], [0, 4]], true);
        forest.join_until(1);
        let roots: Vec<u32> = (0..5).map(|k| forest.root(k)).collect();
        assert_eq!(roots, [0, 1, 2, 3, 0]);
    }
}
