//! The front of what nothing else beats in both respects (V. Pareto).

/// The stairs between points that no other equals or undercuts in both coordinates, from left to right: lower left of them
/// is nothing. Points that are not finite do not count.
pub fn front(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted: Vec<[f64; 2]> = points.iter().copied().filter(|p| p.iter().all(|v| v.is_finite())).collect();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut stairs: Vec<[f64; 2]> = Vec::new();
    for [x, y] in sorted {
        match stairs.last().copied() {
            Some([_, lowest]) if y >= lowest => {}
            Some([_, lowest]) => stairs.extend([[x, lowest], [x, y]]),
            None => stairs.push([x, y]),
        }
    }
    stairs
}

#[cfg(test)]
mod tests {
    use super::front;

    #[test]
    fn stairs_pass_what_is_beaten() {
        let points = [[4.0, 1.0], [1.0, 8.0], [2.0, 9.0], [2.0, 3.0], [4.0, 2.0], [f64::NAN, 0.0]];
        assert_eq!(front(&points), [[1.0, 8.0], [2.0, 8.0], [2.0, 3.0], [4.0, 3.0], [4.0, 1.0]]);
        assert_eq!(front(&[]), Vec::<[f64; 2]>::new());
    }
}
