//! Points and directions: stratified, uniform, finite.

use glam::{DVec3, Vec3};
use radfile::{Patches, Piece};
use scene::{PatchSampler, Sobol, basis, cosine_direction, square_to_triangle};

const SEEDS: [u32; 4] = [0, 1, 0xdead_beef, u32::MAX];

fn points(seed: u32, first: u32, count: u32) -> Vec<[f32; 4]> {
    let sobol = Sobol::new(seed);
    (first..first + count).map(|i| sobol.sample(i)).collect()
}

/// Every block of 2^k points of every dimension has one point in each interval of length 2^-k.
#[test]
fn each_number_of_the_sequence_is_stratified_by_itself() {
    for seed in SEEDS {
        for (k, block) in [(0, 5), (4, 0), (4, 3), (10, 0), (10, 7), (13, 1)] {
            let points = points(seed, block << k, 1 << k);
            for d in 0..4 {
                let mut seen = vec![0; 1 << k];
                points.iter().for_each(|p| seen[(p[d] * (1 << k) as f32) as usize] += 1);
                assert!(seen.iter().all(|&s| s == 1), "seed {seed}, dimension {d}, block {block} of 2^{k}");
            }
        }
    }
}

/// Points of 2^k in all elementary rectangles of area 2^-k: the first two dimensions are a (0, 2)-sequence.
#[test]
fn the_first_two_numbers_are_a_net() {
    for seed in SEEDS {
        for (k, block) in [(4u32, 0), (8, 0), (8, 5), (12, 1)] {
            let points = points(seed, block << k, 1 << k);
            for a in 0..=k {
                let (columns, rows) = (1usize << a, 1usize << (k - a));
                let mut seen = vec![0; columns * rows];
                for p in &points {
                    seen[(p[0] * columns as f32) as usize * rows + (p[1] * rows as f32) as usize] += 1;
                }
                assert!(seen.iter().all(|&s| s == 1), "seed {seed}: {columns} × {rows} cells, block {block}");
            }
        }
    }
}

/// The other pairs have the quality t of Joe and Kuo's numbers: no cell of 2^t / 2^k is empty or overfull.
#[test]
fn all_pairs_of_numbers_are_nearly_nets() {
    let (k, t) = (12u32, 3u32);
    for seed in SEEDS {
        let points = points(seed, 0, 1 << k);
        for (d, e) in [(0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            for a in 0..=k - t {
                let (columns, rows) = (1usize << a, 1usize << (k - t - a));
                let mut seen = vec![0; columns * rows];
                for p in &points {
                    seen[(p[d] * columns as f32) as usize * rows + (p[e] * rows as f32) as usize] += 1;
                }
                assert!(seen.iter().all(|&s| s == 1 << t), "seed {seed}: dimensions {d}, {e}, {columns} × {rows}");
            }
        }
    }
}

/// Over seeds, a given sample is uniform and two samples are independent: the scrambling has no favourites.
#[test]
fn scrambling_makes_every_sample_uniform() {
    let n = 40_000;
    for d in 0..4 {
        let (mut sum, mut square, mut product) = (0.0, 0.0, 0.0);
        for seed in 0..n {
            let sobol = Sobol::new(seed);
            let (a, b) = (f64::from(sobol.sample(3)[d]), f64::from(sobol.sample(3)[(d + 1) % 4]));
            sum += a;
            square += a * a;
            product += (a - 0.5) * (b - 0.5);
        }
        let n = f64::from(n);
        // Five standard errors: the variance of a uniform number is 1/12, of its square 4/45, of the product 1/144.
        assert!((sum / n - 0.5).abs() < 5.0 * (1.0 / 12.0 / n).sqrt(), "dimension {d}: mean {}", sum / n);
        assert!((square / n - 1.0 / 3.0).abs() < 5.0 * (4.0 / 45.0 / n).sqrt(), "dimension {d}: {}", square / n);
        assert!((product / n).abs() < 5.0 * (1.0 / 144.0 / n).sqrt(), "dimensions {d} and next: {}", product / n);
    }
}

/// Sequences of different seeds side by side fill the square as evenly as chance at least.
#[test]
fn two_sequences_may_be_used_side_by_side() {
    let (a, b) = (points(1, 0, 4096), points(2, 0, 4096));
    let mut seen = [0u32; 256];
    for (p, q) in a.iter().zip(&b) {
        seen[(p[0] * 16.0) as usize * 16 + (q[0] * 16.0) as usize] += 1;
    }
    // 16 expected in each; chance alone has a standard deviation of 4.
    assert!(seen.iter().all(|s| (1..40).contains(s)), "{seen:?}");
}

#[test]
fn cosine_directions_carry_flux_evenly_about_the_normal() {
    for normal in [Vec3::Z, Vec3::NEG_Z, Vec3::new(1.0, -2.0, 0.5).normalize(), Vec3::X] {
        let (mut mean, mut square) = (DVec3::ZERO, 0.0);
        for [_, _, x, y] in points(5, 0, 1 << 14) {
            let direction = cosine_direction(normal, x, y);
            assert!((direction.length() - 1.0).abs() < 1e-6 && direction.dot(normal) > 0.0, "{direction}");
            mean += direction.as_dvec3();
            square += f64::from(direction.dot(normal)).powi(2);
        }
        let n = f64::from(1 << 14);
        // E[ω] = 2/3 n and E[cos² θ] = 1/2 for density cos θ / π; stratified sums are good to 1/n and better.
        assert!((mean / n).abs_diff_eq(normal.as_dvec3() * 2.0 / 3.0, 2e-4), "mean {} about {normal}", mean / n);
        assert!((square / n - 0.5).abs() < 2e-4, "cos² {}", square / n);
    }
    for corner in [[0.0, 0.0], [0.0, 0.999_999_9], [0.999_999_9, 0.5], [0.5, 0.5]] {
        assert!(cosine_direction(Vec3::Y, corner[0], corner[1]).y > 0.0, "{corner:?} is below the surface");
    }
}

#[test]
fn frames_are_right_handed() {
    for [x, y, z, _] in points(3, 0, 256) {
        let n = (2.0 * Vec3::new(x, y, z) - 1.0).normalize();
        let (s, t) = basis(n);
        assert!(s.cross(t).abs_diff_eq(n, 1e-5) && s.dot(t).abs() < 1e-6, "frame of {n}");
    }
}

/// Area by area: sub-triangles of the four-fold subdivision get a quarter of the points each.
#[test]
fn points_fill_a_triangle_evenly() {
    let mut seen = [0u32; 4];
    let mut mean = [0.0f64; 2];
    for [x, y, ..] in points(8, 0, 1 << 14) {
        let (u, v) = square_to_triangle(x, y);
        assert!(u > 0.0 && v > 0.0 && u + v < 1.0, "({u}, {v}) is not inside");
        let part = if u > 0.5 {
            0
        } else if v > 0.5 {
            1
        } else if u + v < 0.5 {
            2
        } else {
            3
        };
        seen[part] += 1;
        mean = [mean[0] + f64::from(u), mean[1] + f64::from(v)];
    }
    assert!(seen.iter().all(|&s| (s as i32 - 4096).abs() < 100), "{seen:?}");
    assert!(mean.iter().all(|m| (m / f64::from(1 << 14) - 1.0 / 3.0).abs() < 1e-4), "{mean:?}");
}

fn patch_of(pieces: Vec<Piece>) -> Patches {
    Patches {
        position: vec![[0.0; 3]],
        normal: vec![[0.0, 0.0, 1.0]],
        area: vec![1.0],
        reflectance: vec![[0.5; 3]],
        emission: vec![[0.0; 3]],
        piece_start: vec![0, pieces.len() as u32],
        pieces,
        ..Patches::default()
    }
}

#[test]
fn pieces_get_points_by_their_area() {
    let triangle =
        |x: f32, size: f32, face| Piece { corners: [[x, 0.0, 0.0], [x + size, 0.0, 0.0], [x, size, 0.0]], face };
    let patches = patch_of(vec![triangle(0.0, 1.0, 0), triangle(5.0, 0.0, 2), triangle(2.0, 3.0, 5)]);
    let sampler = PatchSampler::new(&patches);
    let mut seen = [0; 3];
    for [x, y, ..] in points(1, 0, 1000) {
        let point = sampler.point(0, x, y);
        seen[point.triangle as usize] += 1;
        let side = if point.triangle == 2 { Vec3::NEG_Z } else { Vec3::Z };
        assert_eq!(point.normal, side, "face 5 is a back");
    }
    assert_eq!(seen, [100, 0, 900], "areas are 1 : 0 : 9");
}

/// Slivers, points and lines are what clipping leaves over; sampling them must stay finite and in place.
#[test]
fn degenerate_pieces_give_finite_points() {
    let slivers: [[[f32; 3]; 3]; 5] = [
        [[1.0; 3]; 3],
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1e-30, 0.0]],
        [[0.0, 0.0, 0.0], [1e-20, 0.0, 0.0], [0.0, 1e-20, 0.0]],
        [[5.0, 5.0, 5.0], [5.0, 5.0, 5.000_000_5], [5.0, 5.000_000_5, 5.0]],
    ];
    let piece = |corners| Piece { corners, face: 1 };
    let mut scenes: Vec<Vec<Piece>> = slivers.iter().map(|&s| vec![piece(s)]).collect();
    scenes.push(slivers.map(piece).to_vec());
    for pieces in scenes {
        let patches = patch_of(pieces);
        let sampler = PatchSampler::new(&patches);
        for [x, y, ..] in points(2, 0, 256) {
            let point = sampler.point(0, x, y);
            assert!(point.position.is_finite() && point.position.abs().max_element() <= 5.1, "{point:?}");
            assert!((point.normal.length() - 1.0).abs() < 1e-5, "{point:?}");
        }
    }
}

#[test]
fn points_keep_their_distance_from_the_edges() {
    let corners = [[8.0f32, 0.0, 0.0], [8.002, 0.0, 0.0], [8.0, 0.001, 0.0]];
    let patches = patch_of(vec![Piece { corners, face: 0 }]);
    let sampler = PatchSampler::new(&patches);
    let [a, b, c] = corners.map(Vec3::from);
    // Four gaps of 16 epsilon, less the rounding of coordinates at 8.
    let inset = 60.0 * f32::EPSILON * 8.002;
    for i in 0..=100u16 {
        for j in 0..=100u16 {
            let p = sampler.point(0, f32::from(i) / 100.0, f32::from(j) / 100.0).position;
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let distance = (to - from).cross(p - from).z / (to - from).length();
                assert!(distance > inset, "{p} is {distance} from an edge");
            }
        }
    }
}
