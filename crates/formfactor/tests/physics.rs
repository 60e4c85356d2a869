//! What form factors must obey, whatever the rays say.

mod walls;

use formfactor::{Budget, Params, Report, form_factors};
use radfile::{FormFactors, Quiet};
use walls::{Room, Wall, cut, inside_of_box, whole};

/// Unit squares, opposed at distance 1 and perpendicular with a common edge (Howell C-11, C-14).
const OPPOSED: f64 = 0.199824895698387;
const PERPENDICULAR: f64 = 0.200043776075403;

fn measure(room: &Room, rays: u32, seed: u32) -> (FormFactors<'static>, Report) {
    form_factors(&room.mesh, &room.patches, &Params::rays(rays, seed), &Quiet).expect("patches and rays")
}

fn row_sum(factors: &FormFactors, i: usize) -> f64 {
    factors.row(i).iter().map(|&f| f64::from(f)).sum()
}

/// A_i F_ij against A_j F_ji, relative.
fn assert_reciprocal(room: &Room, factors: &FormFactors) {
    let area = &room.patches.area;
    for i in 0..factors.len() {
        for j in 0..i {
            let there = f64::from(area[i]) * f64::from(factors.row(i)[j]);
            let back = f64::from(area[j]) * f64::from(factors.row(j)[i]);
            // Each of the two was rounded to f32 once.
            assert!((there - back).abs() <= 1.3e-7 * there.max(back), "pair {i}, {j}: {there} and {back}");
            assert!(there <= f64::from(area[i].min(area[j])) * (1.0 + 1e-6), "pair {i}, {j} exchanges {there}");
        }
    }
}

/// Part of the flux leaving the patches of one wall that reaches those of another.
fn between(room: &Room, factors: &FormFactors, from: usize, to: usize) -> f64 {
    let area = |i: usize| f64::from(room.patches.area[i]);
    let whole: f64 = room.of_wall[from].iter().map(|&i| area(i)).sum();
    let flux = |&i: &usize| area(i) * room.of_wall[to].iter().map(|&j| f64::from(factors.row(i)[j])).sum::<f64>();
    room.of_wall[from].iter().map(flux).sum::<f64>() / whole
}

fn floor() -> Wall {
    Wall::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
}

fn ceiling() -> Wall {
    Wall::new([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0])
}

/// The standard error is 3e-4 at 2^16 rays (plain Monte Carlo: 1.1e-3), so the limit is three of them.
#[test]
fn unit_squares_exchange_what_the_closed_forms_say() {
    let side = Wall::new([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    for room in [whole(&[floor(), ceiling(), side]), cut(&[floor(), ceiling(), side], 0.25)] {
        let (factors, _) = measure(&room, 1 << 16, 1);
        for (from, to, exact) in [(0, 1, OPPOSED), (0, 2, PERPENDICULAR), (2, 1, PERPENDICULAR)] {
            let found = between(&room, &factors, from, to);
            assert!((found - exact).abs() < 1e-3, "{from} to {to}: {found}, exactly {exact}");
        }
        assert_reciprocal(&room, &factors);
    }
}

/// The obstacle, seen from any point of the floor, hides a quarter of the ceiling or nothing.
#[test]
fn a_black_square_of_half_size_leaves_three_quarters() {
    let obstacle = Wall::new([0.0, 0.0, 0.5], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0]).black();
    let (factors, report) = measure(&whole(&[floor(), ceiling(), obstacle]), 1 << 16, 1);
    let found = f64::from(factors.row(0)[1]);
    assert!((found - 0.75 * OPPOSED).abs() < 1e-3, "{found}, exactly {}", 0.75 * OPPOSED);
    assert!(report.absorbed > 0);
}

#[test]
fn a_closed_room_sees_no_sky_and_rows_sum_to_one() {
    for room in [whole(&inside_of_box([0.0; 3], [1.0; 3])), cut(&inside_of_box([0.0; 3], [1.0; 3]), 0.25)] {
        let (factors, report) = measure(&room, 1024, 1);
        assert_eq!((report.escaped, report.absorbed, report.discarded), (0, 0, 0));
        assert_eq!(factors.sky.iter().copied().fold(0.0, f32::max), 0.0);
        for i in 0..factors.len() {
            assert!((row_sum(&factors, i) - 1.0).abs() < 1e-6, "row {i} sums to {}", row_sum(&factors, i));
        }
        assert!(report.converged && report.rows_not_met == 0, "{report:?}");
        assert!(report.closure_after_max < 1e-6 && report.closure_before_max > 1e-4, "{report:?}");
        assert_reciprocal(&room, &factors);
    }
}

#[test]
fn what_an_open_box_does_not_see_of_itself_is_sky() {
    let room = cut(&inside_of_box([0.0; 3], [1.0; 3])[1..], 0.25);
    let (factors, report) = measure(&room, 1024, 1);
    assert!(report.escaped > 0 && report.rows_not_met == 0, "{report:?}");
    for i in 0..factors.len() {
        let sum = row_sum(&factors, i) + f64::from(factors.sky[i]);
        assert!((sum - 1.0).abs() < 1e-6, "row and sky of {i} sum to {sum}");
        assert!(factors.sky[i] > 0.0, "patch {i} sees the opening");
    }
    // By reciprocity the opening gets from the ceiling what the ceiling would get from it.
    let ceiling = room.of_wall[0].iter().map(|&i| f64::from(factors.sky[i])).sum::<f64>() / 16.0;
    assert!((ceiling - OPPOSED).abs() < 2e-3, "the ceiling sees {ceiling} sky");
}

#[test]
fn light_that_meets_a_side_without_patch_is_neither_kept_nor_sky() {
    let mut walls = inside_of_box([0.0; 3], [1.0; 3]);
    walls.push(Wall::new([0.25, 0.25, 0.5], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0]).black());
    let room = cut(&walls, 0.25);
    let (factors, report) = measure(&room, 1024, 1);
    let lost: f64 = (0..factors.len()).map(|i| 1.0 - row_sum(&factors, i) - f64::from(factors.sky[i])).sum();
    let absorbed = report.absorbed as f64 / 1024.0;
    assert!(report.absorbed > 0 && report.escaped == 0);
    assert!((lost - absorbed).abs() < 1e-4 * absorbed, "lost {lost}, absorbed {absorbed}");
}

#[test]
fn patches_of_unequal_area_exchange_the_same_both_ways() {
    let mut walls = inside_of_box([0.0; 3], [3.0, 2.0, 1.0]);
    walls.push(Wall::new([1.0, 1.0, 0.2], [0.1, 0.0, 0.0], [0.0, 0.1, 0.05]).both());
    let room = whole(&walls);
    let (factors, report) = measure(&room, 1024, 5);
    assert_reciprocal(&room, &factors);
    assert!(report.reciprocity_before > 1e-4 && report.reciprocity_after < 1.3e-7, "{report:?}");
    // The small panel fills little of what the floor sees; floor and panel agree on how little.
    assert!(factors.row(0)[6] + factors.row(0)[7] < 0.02);
}

/// A tent over a square floor: everything the floor sends reaches the tent, the rest is the tent's own.
#[test]
fn a_patch_that_is_not_plane_sees_itself() {
    let top = glam::Vec3::new(0.5, 0.5, 0.7);
    let mut room = whole(&[floor(), ceiling(), ceiling()]);
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    for k in 0..4 {
        let triangle = [corners[(k + 1) % 4], corners[k], top.to_array()];
        for (c, &vertex) in triangle.iter().enumerate() {
            room.mesh.positions[room.mesh.triangles[2 + k][c] as usize] = vertex;
        }
        let first = room.mesh.positions.len() as u32;
        room.mesh.positions.extend(triangle);
        room.mesh.triangles[2 + k] = [first, first + 1, first + 2];
        room.patches.pieces[2 + k].corners = triangle;
    }
    let slope = 4.0 * 0.5 * (0.5f32 * 0.5 + 0.7 * 0.7).sqrt();
    let p = &mut room.patches;
    (p.area, p.piece_start) = (vec![1.0, slope], vec![0, 2, 6]);
    for list in [&mut p.position, &mut p.normal, &mut p.reflectance, &mut p.emission] {
        list.truncate(2);
    }
    p.locator.cell_patch.iter_mut().for_each(|patch| *patch = (*patch).min(1));
    let (factors, report) = measure(&room, 1 << 14, 1);
    assert_eq!(report.escaped, 0);
    let own = 1.0 - 1.0 / slope;
    for (found, exact) in [(0, 0.0), (1, 1.0)].map(|(j, e)| (factors.row(0)[j], e)) {
        assert!((found - exact).abs() < 1e-6, "floor: {found}, exactly {exact}");
    }
    assert!((factors.row(1)[1] - own).abs() < 1e-6, "the tent sees {} of itself, exactly {own}", factors.row(1)[1]);
}

#[test]
fn a_sealed_room_exchanges_nothing_with_the_room_beside_it() {
    let mut walls = inside_of_box([0.0; 3], [1.0; 3]);
    walls[3] = walls[3].both();
    let mut next = inside_of_box([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]);
    next.remove(2);
    walls.extend(next);
    let room = cut(&walls, 0.25);
    let (factors, report) = measure(&room, 4096, 3);
    assert_eq!((report.escaped, report.absorbed), (0, 0));
    // Wall sides 0 to 3, 5 and 6 belong to the first room; 4 is the back of the wall between them.
    let first_room = |wall: usize| wall < 7 && wall != 4;
    for from in 0..room.of_wall.len() {
        for to in 0..room.of_wall.len() {
            if first_room(from) != first_room(to) {
                assert_eq!(between(&room, &factors, from, to), 0.0, "light from wall {from} to wall {to}");
            }
        }
    }
}

#[test]
fn rooms_of_any_size_and_place_are_as_tight() {
    for (low, high) in [([0.0; 3], [1e-3; 3]), ([0.0; 3], [1e3; 3]), ([7.0, -3.0, 2.0], [8.0, -2.0, 3.0])] {
        let (factors, report) = measure(&whole(&inside_of_box(low, high)), 1 << 14, 1);
        assert_eq!((report.escaped, report.absorbed, report.discarded), (0, 0, 0), "box {low:?} to {high:?}");
        assert!((f64::from(factors.row(0)[1]) - OPPOSED).abs() < 1e-3, "box {low:?}: {}", factors.row(0)[1]);
    }
}

/// A tunnel with the cross-section of a needle: starts near its edge lie closer to the next wall than the gap.
#[test]
fn light_in_an_acute_corner_stays_in_the_corner() {
    let rise = 0.04;
    let mut walls = vec![
        Wall::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        Wall::new([0.0; 3], [0.0, 1.0, 0.0], [1.0, 0.0, rise]),
        Wall::new([1.0, 0.0, 0.0], [0.0, 0.0, rise], [0.0, 1.0, 0.0]),
    ];
    // The ends: squares that stick out far beyond the tunnel.
    walls.push(Wall::new([-1.0, 0.0, -1.0], [0.0, 0.0, 3.0], [3.0, 0.0, 0.0]));
    walls.push(Wall::new([-1.0, 1.0, -1.0], [3.0, 0.0, 0.0], [0.0, 0.0, 3.0]));
    let (factors, report) = measure(&whole(&walls), 1 << 17, 1);
    for i in 0..3 {
        // Both sky and the absorbing outsides are beyond the walls.
        assert_eq!(factors.sky[i], 0.0, "wall {i} of the tunnel sees the sky");
        assert!((row_sum(&factors, i) - 1.0).abs() < 1e-6, "wall {i} keeps {} inside", row_sum(&factors, i));
    }
    assert!(report.moved + report.discarded > 0, "no start was near the edge: not a test");
}

/// Two plates agree on one exchange area, and what each lacks is the sky's.
#[test]
fn plates_that_see_only_each_other_share_what_both_measured() {
    let room = cut(&[floor(), ceiling()], 0.25);
    let (factors, report) = measure(&room, 256, 2);
    assert_reciprocal(&room, &factors);
    assert!(report.converged, "{report:?}");
    assert!(report.closure_after_max < 0.1 * report.closure_before_max, "{report:?}");
    for i in 0..factors.len() {
        let sum = row_sum(&factors, i) + f64::from(factors.sky[i]);
        assert!((sum - 1.0).abs() < 1e-6, "row and sky of {i} sum to {sum}");
    }
}

#[test]
fn the_number_of_threads_does_not_change_a_byte() {
    let room = cut(&inside_of_box([0.0; 3], [1.0; 3]), 0.25);
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| measure(&room, 256, 9))
    };
    let (one, two, again) = (with_threads(1), with_threads(2), with_threads(3));
    assert!(one.0 == two.0 && one.0 == again.0, "form factors differ");
    assert_eq!(one.1, two.1);
    assert_ne!(one.0, measure(&room, 256, 10).0, "the seed changes nothing");
}

/// Root mean square error of the cube's face-to-face factors over seeds.
fn cube_error(room: &Room, rays: u32) -> f64 {
    let mut sum = 0.0;
    for seed in 0..8 {
        let (factors, _) = measure(room, rays, seed);
        for (i, j) in (0..36).map(|p| (p / 6, p % 6)).filter(|(i, j)| i != j) {
            let exact = if i / 2 == j / 2 { OPPOSED } else { PERPENDICULAR };
            sum += (f64::from(factors.row(i)[j]) - exact).powi(2);
        }
    }
    (sum / (8.0 * 30.0)).sqrt()
}

/// 64 times as many rays make plain Monte Carlo 8 times better. What is counted jumps at the edges of
/// patches, for which points stratified in d dimensions promise N^(−1/2 − 1/2d), so 13.5 times here.
#[test]
fn error_falls_faster_than_the_root_of_the_rays() {
    let room = whole(&inside_of_box([0.0; 3], [1.0; 3]));
    let (few, many) = (cube_error(&room, 1 << 8), cube_error(&room, 1 << 14));
    println!("rms error {few:.2e} with 2^8 rays, {many:.2e} with 2^14");
    assert!(few / many > 10.5, "{few} with 2^8 rays, {many} with 2^14");
}

/// `levels` times, every piece of the patch becomes four; then they are shuffled.
fn crumble(room: &mut Room, patch: usize, levels: u32) {
    let p = &mut room.patches;
    let range = p.piece_start[patch] as usize..p.piece_start[patch + 1] as usize;
    let mut pieces = p.pieces[range.clone()].to_vec();
    for _ in 0..levels {
        let quarter = |piece: radfile::Piece| {
            let [a, b, c] = piece.corners.map(glam::Vec3::from);
            let [ab, bc, ca] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                .map(|corners| radfile::Piece { corners: corners.map(|x| x.to_array()), face: piece.face })
        };
        pieces = pieces.into_iter().flat_map(quarter).collect();
    }
    pieces.sort_by_key(|piece| scene::hash(piece.corners[0][0].to_bits(), piece.corners[1][1].to_bits()));
    let grown = (pieces.len() - range.len()) as u32;
    p.pieces.splice(range, pieces);
    p.piece_start[patch + 1..].iter_mut().for_each(|start| *start += grown);
    p.check().expect("crumbled patches");
}

/// RMS error over seeds of the form factor between two unit squares.
fn squares_error(room: &Room, exact: f64, rays: u32, seeds: u32) -> f64 {
    let squared = |seed| (f64::from(measure(room, rays, seed).0.row(0)[1]) - exact).powi(2);
    ((0..seeds).map(squared).sum::<f64>() / f64::from(seeds)).sqrt()
}

/// Slope of a line through (log rays, log error).
fn slope(rays: &[u32], errors: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> = rays.iter().zip(errors).map(|(n, e)| (f64::from(*n).ln(), e.ln())).collect();
    let n = points.len() as f64;
    let (x, y) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

/// Unoccluded, nothing else in the scene: what closing does to one pair alone is nothing.
#[test]
fn unoccluded_squares_are_exact_to_a_thousandth_and_improve_faster_than_the_root() {
    let side = Wall::new([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let rays = [1 << 8, 1 << 10, 1 << 12, 1 << 14, 1 << 16];
    for (name, other, exact) in [("opposed", ceiling(), OPPOSED), ("perpendicular", side, PERPENDICULAR)] {
        let room = whole(&[floor(), other]);
        let errors: Vec<f64> = rays.iter().map(|&n| squares_error(&room, exact, n, 16)).collect();
        let slope = slope(&rays, &errors);
        println!("{name}: rms errors {errors:?}, slope {slope:.3}");
        assert!(errors[4] < 5e-4, "{name}: {} with 2^16 rays", errors[4]);
        assert!(slope < -0.55, "{name}: slope {slope}, plain Monte Carlo has -0.5");
    }
}

/// Points are stratified over the area of a patch, whatever it is made of.
#[test]
fn a_patch_of_many_pieces_is_sampled_as_well_as_one_of_two() {
    let two = whole(&[floor(), ceiling()]);
    let mut many = whole(&[floor(), ceiling()]);
    crumble(&mut many, 0, 4);
    crumble(&mut many, 1, 4);
    for rays in [1 << 10, 1 << 13] {
        let [few, many] = [&two, &many].map(|room| squares_error(room, OPPOSED, rays, 24));
        let independent = (OPPOSED * (1.0 - OPPOSED) / f64::from(2 * rays)).sqrt();
        println!(
            "{rays} rays: rms error {few:.2e} with 2 pieces, {many:.2e} with 512, {independent:.2e} if independent"
        );
        assert!(many < 1.3 * few && many < 0.6 * independent, "{many} with 512 pieces, {few} with 2, {independent}");
    }
}

/// A cube of 1 mm in a room of 10 m: a ten-thousandth of the scene, where single precision resolves 1/2000 of it.
#[test]
fn a_crumb_in_a_hall_sees_the_hall_and_nothing_of_itself() {
    let (size, centre) = (1e-3, 5.0);
    let (low, high) = ([centre - size / 2.0; 3], [centre + size / 2.0; 3]);
    let mut walls = inside_of_box([0.0; 3], [10.0; 3]);
    // Turned inside out, the box looks outwards.
    walls.extend(inside_of_box(low, high).iter().map(|w| Wall { u: w.v, v: w.u, ..*w }));
    let room = whole(&walls);
    let (factors, report) = measure(&room, 1 << 14, 1);
    assert_eq!((report.escaped, report.absorbed, report.discarded), (0, 0, 0));
    for face in 6..12 {
        let own: f32 = factors.row(face)[6..].iter().sum();
        assert_eq!(own, 0.0, "face {face} of the cube sees the cube");
        assert!((row_sum(&factors, face) - 1.0).abs() < 1e-6, "face {face} sums to {}", row_sum(&factors, face));
        // A surface element before the middle of a square at half its edge (Howell B-3): 4 / 2π · 2 · a atan a, a = 1/√2.
        let a = 0.5f64.sqrt();
        let exact = 4.0 / std::f64::consts::PI * a * a.atan();
        let wall = face - 6; // the floor of the cube looks at the floor of the room
        let found = f64::from(factors.row(face)[wall]);
        assert!((found - exact).abs() < 2e-3, "face {face} sees {found} of wall {wall}, exactly {exact}");
    }
    for wall in 0..6 {
        let cube: f64 = factors.row(wall)[6..].iter().map(|&f| f64::from(f)).sum();
        assert!(cube < 2e-8, "wall {wall} sees {cube} of a cube that fills 1e-8 of its area");
    }
}

/// Rooms of Sobol-sized noise, closed: identity 1 of the design to the last bits, physical limits of every pair.
#[test]
fn closed_factors_obey_every_limit() {
    let mut walls = inside_of_box([0.0; 3], [3.0, 2.0, 1.0]);
    walls.push(Wall::new([1.0, 1.0, 0.2], [0.1, 0.0, 0.0], [0.0, 0.1, 0.05]).both());
    for room in [whole(&walls), cut(&inside_of_box([0.0; 3], [1.0; 3]), 0.125)] {
        for rays in [16, 256] {
            let (factors, report) = measure(&room, rays, 3);
            assert!(factors.values.iter().all(|f| *f >= 0.0) && report.least_factor == 0.0);
            assert!(report.fullest_pair.share <= 1.0 + 1e-6, "{report:?}");
            let [i, j] = report.fullest_pair.patches;
            let smaller = f64::from(room.patches.area[i].min(room.patches.area[j]));
            let share = f64::from(room.patches.area[i]) * f64::from(factors.row(i)[j]) / smaller;
            assert!((share - report.fullest_pair.share).abs() < 1e-6, "{share}, said was {report:?}");
            assert!(report.converged && report.balance_max < 1e-6 && report.closure_after_max < 1e-6, "{report:?}");
            assert!(report.reciprocity_after < 1.3e-7, "{report:?}");
        }
    }
}

/// A floor that is said to be larger than all it sees cannot send what its rays measured.
#[test]
fn rows_that_cannot_be_met_are_named() {
    let mut room = whole(&inside_of_box([0.0; 3], [1.0; 3]));
    room.patches.area[0] = 8.0;
    let (_, report) = measure(&room, 256, 1);
    assert!(report.rows_not_met > 0 && report.worst_not_met[0].patch == 0, "{report:?}");
    assert!(report.worst_not_met[0].error > 0.1 && report.balance_max > 0.1, "{report:?}");
    assert!(report.fullest_pair.share <= 1.0 + 1e-6, "{report:?}");
}

/// Two rooms of unequal patches with a door, and lamps that the report knows nothing of.
fn two_rooms() -> Room {
    let mut walls = inside_of_box([0.0; 3], [1.0; 3]);
    let next = inside_of_box([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]);
    walls.remove(3);
    walls.extend([0, 1, 3, 4, 5].map(|k| next[k]));
    // Between them a wall that leaves a quarter open.
    walls.push(Wall::new([1.0, 0.0, 0.0], [0.0, 0.75, 0.0], [0.0, 0.0, 0.75]).both());
    walls.push(Wall::new([1.0, 0.75, 0.0], [0.0, 0.25, 0.0], [0.0, 0.0, 0.25]).both());
    walls.push(Wall::new([1.0, 0.0, 0.75], [0.0, 0.25, 0.0], [0.0, 0.0, 0.25]).both());
    cut(&walls, 0.125)
}

/// RMS over lamps of the error of indirect light relative to the light.
fn light_error(room: &Room, factors: &FormFactors, truth: &FormFactors) -> f64 {
    let n = factors.len();
    let direct = |i: usize, lamp: glam::Vec3| {
        let (at, normal) = (glam::Vec3::from(room.patches.position[i]), glam::Vec3::from(room.patches.normal[i]));
        let away = lamp - at;
        let same_room = (at.x - 1.0) * (lamp.x - 1.0) >= 0.0;
        f64::from(if same_room { (away.dot(normal) / away.length().powi(3)).max(0.0) } else { 0.0 })
    };
    let light = |f: &FormFactors, lamp: glam::Vec3| {
        let mut light = vec![0.0; n];
        for _ in 0..24 {
            let radiosity: Vec<f64> = (0..n).map(|j| 0.5 * (light[j] + direct(j, lamp))).collect();
            light = (0..n).map(|i| f.row(i).iter().zip(&radiosity).map(|(f, b)| f64::from(*f) * b).sum()).collect();
        }
        light
    };
    let relative = |lamp: glam::Vec3| {
        let (found, exact) = (light(factors, lamp), light(truth, lamp));
        let square =
            |e: &dyn Fn(usize) -> f64| (0..n).map(|i| f64::from(room.patches.area[i]) * e(i).powi(2)).sum::<f64>();
        square(&|i| found[i] - exact[i]) / square(&|i| exact[i])
    };
    let place = |k: u32, axis: u32| 0.1 + 0.8 * scene::hash(k, axis) as f32 / u32::MAX as f32;
    let lamp = |k: u32| glam::Vec3::new((k % 2) as f32 + place(k, 0), place(k, 1), place(k, 2));
    ((0..12).map(|k| relative(lamp(k))).sum::<f64>() / 12.0).sqrt()
}

#[test]
fn the_error_of_light_is_what_more_rays_say() {
    let room = two_rooms();
    let by_error = |target| Params { budget: Budget::Error { target, max_rays: 1 << 16 }, seed: 1 };
    let run = |params: &Params| form_factors(&room.mesh, &room.patches, params, &Quiet).expect("form factors");
    let (factors, report) = run(&by_error(0.02));
    let (truth, _) = measure(&room, 16 * report.rays_mean as u32, 7);
    let error = light_error(&room, &factors, &truth);
    println!(
        "{} rays: said {}, found {error}, rows {}",
        report.rays_mean, report.irradiance_error, report.row_error_mean
    );
    assert!(report.target_met && report.irradiance_error <= 0.02, "{report:?}");
    assert!((0.6..1.6).contains(&(error / report.irradiance_error)), "said {}, found {error}", report.irradiance_error);
    // Rays of the same number at every patch: the report finds their error, too.
    let (even, even_report) = measure(&room, report.rays_mean as u32, 1);
    let even_error = light_error(&room, &even, &truth);
    println!("evenly: said {}, found {even_error}", even_report.irradiance_error);
    assert!((0.6..1.6).contains(&(even_error / even_report.irradiance_error)), "{even_error} {even_report:?}");
    // Half the error takes more rays, but no more than independent ones would.
    let (_, finer) = run(&by_error(0.01));
    let more = finer.rays_mean / report.rays_mean;
    assert!(finer.irradiance_error <= 0.01 && (1.5..4.5).contains(&more), "{more} times the rays");
}

#[test]
fn a_target_that_the_rays_cannot_reach_is_not_said_to_be_met() {
    let room = whole(&inside_of_box([0.0; 3], [1.0; 3]));
    let params = Params { budget: Budget::Error { target: 1e-6, max_rays: 1000 }, seed: 1 };
    let (_, report) = form_factors(&room.mesh, &room.patches, &params, &Quiet).expect("form factors");
    assert!(!report.target_met && report.irradiance_error > 1e-6, "{report:?}");
    assert_eq!((report.rays_least, report.rays_most), (512, 512), "256 doubled stays below 1000 once");
}
