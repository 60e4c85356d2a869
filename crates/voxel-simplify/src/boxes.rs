//! Pairs of boxes that overlap.
//!
//! A cell of a detailed scene holds up to hundreds of thousands of edges, most of them crowded
//! into some small object, too many to compare each with each. They are halved across the longest
//! axis again and again; what lies across goes to both halves, and a pair is reported only where
//! the lower corner of its common part lies.

use glam::DVec3;

/// Boxes that are compared each with each.
const FEW: usize = 16;
/// Halvings after which boxes are compared each with each.
const DEEP: u32 = 40;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub struct Box3 {
    pub low: DVec3,
    pub high: DVec3,
}

/// Numbers of boxes that overlap and that `wanted` accepts, the smaller first, in a fixed order.
pub fn close_pairs(boxes: &[Box3], wanted: impl Fn(usize, usize) -> bool) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    let everywhere = Box3 { low: DVec3::NEG_INFINITY, high: DVec3::INFINITY };
    let mut todo: Vec<(Vec<u32>, Box3, u32)> = vec![((0..boxes.len() as u32).collect(), everywhere, 0)];
    while let Some((members, region, depth)) = todo.pop() {
        match halve(boxes, &members, depth) {
            Some((axis, middle, below, above)) => {
                let (mut lower, mut upper) = (region, region);
                lower.high[axis] = middle;
                upper.low[axis] = middle;
                todo.push((below, lower, depth + 1));
                todo.push((above, upper, depth + 1));
            }
            None => compare(boxes, &members, region, &wanted, &mut pairs),
        }
    }
    pairs
}

/// Halves by the median across the longest axis: axis, plane, and what reaches below and above; `None` if that is
/// not worth it.
fn halve(boxes: &[Box3], members: &[u32], depth: u32) -> Option<(usize, f64, Vec<u32>, Vec<u32>)> {
    if members.len() <= FEW || depth >= DEEP {
        return None;
    }
    let of = |&m: &u32| boxes[m as usize];
    let low = members.iter().map(of).fold(DVec3::INFINITY, |v, b| v.min(b.low));
    let high = members.iter().map(of).fold(DVec3::NEG_INFINITY, |v, b| v.max(b.low));
    let axis = (high - low).max_position();
    let mut lows: Vec<f64> = members.iter().map(|m| of(m).low[axis]).collect();
    let half = lows.len() / 2;
    let middle = *lows.select_nth_unstable_by(half, f64::total_cmp).1;
    let below: Vec<u32> = members.iter().filter(|m| of(m).low[axis] < middle).copied().collect();
    let above: Vec<u32> = members.iter().filter(|m| of(m).high[axis] >= middle).copied().collect();
    let worth = below.len() < members.len() && above.len() < members.len() * 9 / 10;
    worth.then_some((axis, middle, below, above))
}

/// Pairs of `members` whose common part has its lower corner in `region`, upper planes not included.
fn compare(
    boxes: &[Box3],
    members: &[u32],
    region: Box3,
    wanted: &impl Fn(usize, usize) -> bool,
    pairs: &mut Vec<(usize, usize)>,
) {
    for (k, &i) in members.iter().enumerate() {
        for &j in &members[k + 1..] {
            let (a, b) = (&boxes[i as usize], &boxes[j as usize]);
            let corner = a.low.max(b.low);
            let overlap = corner.cmple(a.high.min(b.high)).all();
            if overlap
                && corner.cmpge(region.low).all()
                && corner.cmplt(region.high).all()
                && wanted(i as usize, j as usize)
            {
                pairs.push((i as usize, j as usize));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same pairs as comparing each with each, none twice.
    #[test]
    fn no_pair_is_missed_and_none_comes_twice() {
        let number = |k: u32| f64::from(scene::hash(k, 5) >> 8) / f64::from(1 << 24);
        let boxes: Vec<Box3> = (0..2000u32)
            .map(|i| {
                let point = |k: u32| DVec3::new(number(6 * i + k), number(6 * i + k + 1), number(6 * i + k + 2));
                let low = point(0);
                // Most are small, some are long rods, a few are flat.
                let size = point(3).powf(if i % 7 == 0 { 1.0 } else { 9.0 });
                Box3 { low, high: low + if i % 50 == 0 { size * DVec3::new(1.0, 1.0, 0.0) } else { size } }
            })
            .collect();
        let mut found = close_pairs(&boxes, |_, _| true);
        let count = found.len();
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), count, "a pair came twice");
        let all = (0..boxes.len()).flat_map(|i| (i + 1..boxes.len()).map(move |j| (i, j)));
        let overlap = |&(i, j): &(usize, usize)| {
            boxes[i].low.cmple(boxes[j].high).all() && boxes[j].low.cmple(boxes[i].high).all()
        };
        assert_eq!(found, all.filter(overlap).collect::<Vec<_>>());
        assert!(count > 100, "only {count} pairs: the test is too easy");
    }
}
