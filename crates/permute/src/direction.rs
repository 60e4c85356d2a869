//! Directions in few classes, ordered so that neighbouring classes are similar.
//!
//! A class is all directions nearest to one of 26: the middles of the faces, edges and corners of a cube.
//! Walls along the axes lie in the middle of their class, so noise of a normal does not divide them.

/// Number of classes.
pub const CLASSES: u8 = 26;

/// Class of a direction. The path goes from +z round the upper corners, round the sides, round the lower
/// corners, to −z; classes that follow each other touch.
pub fn class(normal: [f32; 3]) -> u8 {
    let similarity = |class: &u8| {
        let d = middle(*class).map(f64::from);
        let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
        (0..3).map(|a| d[a] * f64::from(normal[a])).sum::<f64>() / length
    };
    // The first of equals, so that ties do not depend on anything.
    (0..CLASSES).rev().max_by(|a, b| similarity(a).total_cmp(&similarity(b))).expect("there are classes")
}

/// The direction in the middle of a class, not of unit length.
fn middle(class: u8) -> [i8; 3] {
    const RING: [[i8; 2]; 8] = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];
    if class == 0 || class == CLASSES - 1 {
        return [0, 0, if class == 0 { 1 } else { -1 }];
    }
    let (level, step) = ((class - 1) / 8, (class - 1) % 8);
    // Each ring starts where the one above ended, one step before its own end.
    let [x, y] = RING[((step + 7 * level) % 8) as usize];
    [x, y, 1 - level as i8]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_middle_is_in_its_own_class() {
        for c in 0..CLASSES {
            assert_eq!(class(middle(c).map(f32::from)), c);
        }
    }

    #[test]
    fn classes_that_follow_each_other_touch() {
        for c in 1..CLASSES {
            let (a, b) = (middle(c - 1), middle(c));
            assert!((0..3).all(|i| a[i].abs_diff(b[i]) <= 1), "{a:?} {b:?}");
        }
    }

    #[test]
    fn a_slightly_bent_wall_is_one_class() {
        for bent in [[0.1, 0.99, -0.1], [-0.15, 0.98, 0.1], [0.0, 1.0, 0.0]] {
            assert_eq!(class(bent), class([0.0, 1.0, 0.0]));
        }
    }
}
