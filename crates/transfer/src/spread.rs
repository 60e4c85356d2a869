//! Numbers spread over a grid from the cells that have one to those that have none.

use std::collections::BTreeMap;

/// In place of a number in cells that have none.
pub const NONE: u32 = u32::MAX;

/// Cells without a number take, step by step outwards, that of a cell beside them, if `may(cell, beside, number)` says
/// so; the smallest where several offer one. Cell (x, y, z) is x + count_x (y + count_y z).
pub fn spread(count: [u32; 3], numbers: &mut [u32], may: impl Fn(usize, usize, u32) -> bool) {
    let mut front: Vec<usize> = (0..numbers.len()).filter(|&cell| numbers[cell] != NONE).collect();
    while !front.is_empty() {
        let mut taken: BTreeMap<usize, u32> = BTreeMap::new();
        for &cell in &front {
            let number = numbers[cell];
            for empty in beside(count, cell).filter(|&c| numbers[c] == NONE) {
                if taken.get(&empty).is_none_or(|&best| number < best) && may(empty, cell, number) {
                    taken.insert(empty, number);
                }
            }
        }
        for (&cell, &number) in &taken {
            numbers[cell] = number;
        }
        front = taken.into_keys().collect();
    }
}

/// The cells that share a side with one.
fn beside(count: [u32; 3], cell: usize) -> impl Iterator<Item = usize> {
    let [x, y, z] = count.map(|n| n as usize);
    [(1, x), (x, y), (x * y, z)].into_iter().flat_map(move |(step, extent)| {
        let at = cell / step % extent;
        [(at > 0).then(|| cell - step), (at + 1 < extent).then(|| cell + step)].into_iter().flatten()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_take_the_nearest_number_and_the_smaller_of_two() {
        let mut line = [NONE, 7, NONE, NONE, NONE, 3, NONE, NONE];
        spread([8, 1, 1], &mut line, |_, _, _| true);
        assert_eq!(line, [7, 7, 7, 3, 3, 3, 3, 3]);
        // Steps are along axes: cell 3 of a square is two from cell 0.
        let mut square = [0, NONE, NONE, NONE];
        spread([2, 1, 2], &mut square, |cell, _, _| cell != 2);
        assert_eq!(square, [0, 0, NONE, 0]);
    }

    #[test]
    fn rows_do_not_go_on_in_the_next() {
        let mut grid = [NONE; 27];
        grid[2] = 5;
        spread([3, 3, 3], &mut grid, |cell, _, _| cell == 1 || cell == 3);
        assert_eq!((grid[1], grid[3]), (5, NONE));
    }
}
