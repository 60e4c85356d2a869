//! Curves that fill space: points that follow each other on them are close to each other.
//!
//! Source: J. Skilling, Programming the Hilbert curve, AIP Conference Proceedings 707, 2004
//! (axes to transpose); G. M. Morton, 1966.

/// Bits of a coordinate: a millionth of the scene, three of them fit a 64-bit key.
const BITS: u32 = 20;

/// Positions as cells of a cube of 2²⁰ cells a side around them. Scaled alike along all axes, so near stays near.
pub fn cells(positions: &[[f32; 3]]) -> Vec<[u32; 3]> {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for p in positions {
        for a in 0..3 {
            low[a] = low[a].min(f64::from(p[a]));
            high[a] = high[a].max(f64::from(p[a]));
        }
    }
    let extent = (0..3).map(|a| high[a] - low[a]).fold(0.0, f64::max);
    let largest = f64::from((1 << BITS) - 1);
    let scale = if extent > 0.0 { largest / extent } else { 0.0 };
    let cell = |p: &[f32; 3]| std::array::from_fn(|a| ((f64::from(p[a]) - low[a]) * scale).min(largest) as u32);
    positions.iter().map(cell).collect()
}

/// Place of a cell on Morton's curve: its bits interleaved, x highest.
pub fn morton(cell: [u32; 3]) -> u64 {
    let mut key = 0;
    for bit in (0..BITS).rev() {
        for coordinate in cell {
            key = key << 1 | u64::from(coordinate >> bit & 1);
        }
    }
    key
}

/// Place of a cell on Hilbert's curve. Cells that follow each other share a face.
pub fn hilbert(mut x: [u32; 3]) -> u64 {
    const HIGHEST: u32 = 1 << (BITS - 1);
    // Undo the rotations and reflections of each level, coarse to fine.
    let mut bit = HIGHEST;
    while bit > 1 {
        let lower = bit - 1;
        for axis in 0..3 {
            if x[axis] & bit != 0 {
                x[0] ^= lower;
            } else {
                let swap = (x[0] ^ x[axis]) & lower;
                x[0] ^= swap;
                x[axis] ^= swap;
            }
        }
        bit >>= 1;
    }
    // Gray code.
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut flip = 0;
    let mut bit = HIGHEST;
    while bit > 1 {
        if x[2] & bit != 0 {
            flip ^= bit - 1;
        }
        bit >>= 1;
    }
    morton(x.map(|v| v ^ flip))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(edge: u32) -> Vec<[u32; 3]> {
        (0..edge.pow(3)).map(|i| [i / edge / edge, i / edge % edge, i % edge]).collect()
    }

    #[test]
    fn hilbert_neighbours_share_a_face_on_a_full_grid() {
        // The curve starts at cell (0, 0, 0) and fills every 2ᵏ cube there before it leaves it.
        let mut cells = grid(16);
        cells.sort_by_key(|&c| hilbert(c));
        let keys: Vec<u64> = cells.iter().map(|&c| hilbert(c)).collect();
        assert_eq!(keys, (0..4096).collect::<Vec<u64>>());
        for pair in cells.windows(2) {
            let steps: u32 = (0..3).map(|a| pair[0][a].abs_diff(pair[1][a])).sum();
            assert_eq!(steps, 1, "{pair:?}");
        }
    }

    #[test]
    fn hilbert_neighbours_share_a_face_at_the_finest_level_anywhere() {
        // Around the centre of the whole cube, all levels turn at once.
        let centre = 1 << (BITS - 1);
        let mut cells: Vec<[u32; 3]> = grid(8).iter().map(|c| c.map(|v| centre - 8 + v)).collect();
        cells.sort_by_key(|&c| hilbert(c));
        for pair in cells.windows(2) {
            let steps: u32 = (0..3).map(|a| pair[0][a].abs_diff(pair[1][a])).sum();
            assert_eq!(steps, 1, "an aligned cube is filled without leaving it: {pair:?}");
        }
    }

    #[test]
    fn morton_interleaves_bits() {
        assert_eq!(morton([1, 0, 0]), 0b100);
        assert_eq!(morton([0b11, 0b01, 0b10]), 0b101_110);
    }

    #[test]
    fn cells_fit_the_scene_and_survive_a_scene_of_one_point() {
        assert_eq!(cells(&[[7.0; 3]; 2]), [[0; 3]; 2]);
        let top = (1 << BITS) - 1;
        assert_eq!(cells(&[[-1.0, 0.0, 5.0], [3.0, 2.0, 5.0]]), [[0, 0, 0], [top, top / 2, 0]]);
        assert!(cells(&[]).is_empty());
    }
}
