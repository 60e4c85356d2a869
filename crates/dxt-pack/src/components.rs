//! Which patches exchange light at all, after any number of bounces.

use radfile::Operator;

/// Groups of patches that exchange nothing with each other, by their first patch; patches increase.
pub fn components(operator: &Operator) -> Vec<Vec<u32>> {
    let n = operator.n;
    let mut parent: Vec<u32> = (0..n as u32).collect();
    for row in 0..n {
        let exchanges = |column: &usize| (0..operator.channels).any(|c| operator.channel(c)[row * n + column] > 0.0);
        for column in (0..row).filter(exchanges) {
            let (a, b) = (root(&mut parent, row as u32), root(&mut parent, column as u32));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut groups = vec![Vec::new(); n];
    for patch in 0..n as u32 {
        groups[root(&mut parent, patch) as usize].push(patch);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

/// The first patch of a group, which shortens the way to it.
fn root(parent: &mut [u32], mut patch: u32) -> u32 {
    while parent[patch as usize] != patch {
        parent[patch as usize] = parent[parent[patch as usize] as usize];
        patch = parent[patch as usize];
    }
    patch
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
        assert_eq!(components(&operator), [vec![0, 5], vec![1, 2, 4], vec![3]]);
    }
}
