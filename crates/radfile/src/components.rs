//! Which patches exchange light at all, after any number of bounces.

use crate::Operator;

impl Operator<'_> {
    /// Groups of patches that exchange nothing with each other, by their first patch; patches increase. Sealed rooms are
    /// groups of their own, and packing must not let light from one to the other.
    pub fn components(&self) -> Vec<Vec<u32>> {
        let n = self.n;
        let mut groups = Groups::new(n);
        for row in 0..n {
            let exchanges = |column: &usize| (0..self.channels).any(|c| self.channel(c)[row * n + column] > 0.0);
            (0..row).filter(exchanges).for_each(|column| groups.join(row as u32, column as u32));
        }
        groups.lists()
    }
}

/// Patches that are joined two by two.
pub struct Groups {
    /// Another patch of the group, or itself.
    parent: Vec<u32>,
}

impl Groups {
    /// `n` patches, each a group.
    pub fn new(n: usize) -> Groups {
        Groups { parent: (0..n as u32).collect() }
    }

    /// Makes one group of those of two patches.
    ///
    /// # Panics
    ///
    /// If there are no such patches.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.first(a), self.first(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// The groups by their first patch; patches increase.
    pub fn lists(mut self) -> Vec<Vec<u32>> {
        let mut lists = vec![Vec::new(); self.parent.len()];
        (0..self.parent.len() as u32).for_each(|patch| lists[self.first(patch) as usize].push(patch));
        lists.retain(|list| !list.is_empty());
        lists
    }

    /// The first patch of a group, which shortens the way to it.
    fn first(&mut self, mut patch: u32) -> u32 {
        while self.parent[patch as usize] != patch {
            self.parent[patch as usize] = self.parent[self.parent[patch as usize] as usize];
            patch = self.parent[patch as usize];
        }
        patch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_are_one_group_and_strangers_are_none() {
        let linked = [(1, 4), (4, 2), (5, 0)];
        let value = |i: usize, j: usize| if linked.contains(&(i, j)) || linked.contains(&(j, i)) { 1.0 } else { 0.0 };
        let values: Vec<f32> = (0..36).map(|at| value(at / 6, at % 6)).collect();
        let operator = Operator { n: 6, channels: 1, bounces: None, values: values.into() };
        assert_eq!(operator.components(), [vec![0, 5], vec![1, 2, 4], vec![3]]);
    }
}
