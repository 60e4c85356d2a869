//! One permutation moves patches, form factors, operator and locator together; light does not notice.

use radfile::{CUT, Cut, Operator, PatchLocator, Patches, Permutation};

use crate::fixture::{cube, cube_with_cuts, patches_of_a_parted_floor};

/// Irradiance of every patch after one product with the operator.
fn gather(operator: &Operator, channel: usize, light: &[f32]) -> Vec<f64> {
    let row = |i: usize| &operator.channel(channel)[i * operator.n..][..operator.n];
    (0..operator.n).map(|i| row(i).iter().zip(light).map(|(k, l)| f64::from(*k) * f64::from(*l)).sum()).collect()
}

/// Three ways to the same light: in the old order, in the new order, and back again.
#[test]
fn a_permuted_operator_gathers_the_same_light() {
    let cube = cube();
    let order = Permutation::new(vec![5, 2, 0, 1, 4, 3]).expect("every patch once");
    let back = Permutation::new(order.old_to_new()).expect("the inverse of a permutation is one");
    let light = [1.0, 0.5, 8.0, 0.25, 2.0, 4.0];
    for channel in 0..3 {
        let old = &cube.operator;
        let mut moved = Vec::new();
        (0..3).for_each(|c| moved.extend(order.apply_to_matrix(old.channel(c))));
        let new = Operator { values: moved.into(), ..old.clone() };
        let there = gather(&new, channel, &order.apply(&light));
        let sums = gather(old, channel, &light);
        // The same products in another order; f64 sums of six f32 products differ by a few parts in 10^16.
        for (expected, found) in sums.iter().zip(back.apply(&there)) {
            assert!((expected - found).abs() <= 1e-14 * expected, "{expected} became {found}");
        }
    }
}

#[test]
fn permuting_and_back_is_the_identity() {
    let cube = cube();
    let back = Permutation::new(cube.order.old_to_new()).expect("an inverse");
    assert_eq!(cube.patches.permuted(&back).permuted(&cube.order), cube.patches);
    let matrix: Vec<f32> = (0..36).map(|i| i as f32).collect();
    assert_eq!(back.apply_to_matrix(&cube.order.apply_to_matrix(&matrix)), matrix);
    assert_eq!(cube.patches.permuted(&Permutation::identity(6)), cube.patches);
}

#[test]
fn every_attribute_of_a_patch_moves_with_it() {
    let cube = cube();
    let walls: Patches = cube.patches.permuted(&Permutation::new(cube.order.old_to_new()).expect("an inverse"));
    for (new, &old) in cube.order.new_to_old().iter().enumerate() {
        let old = old as usize;
        assert_eq!(cube.patches.position[new], walls.position[old]);
        assert_eq!(cube.patches.normal[new], walls.normal[old]);
        assert_eq!(cube.patches.reflectance[new], walls.reflectance[old]);
        assert_eq!(cube.patches.emission[new], walls.emission[old]);
        assert_eq!(cube.patches.pieces_of(new), walls.pieces_of(old));
        let [a, b, c] = cube.patches.pieces_of(new)[0].corners;
        let middle = std::array::from_fn(|i| (a[i] + b[i] + c[i]) / 3.0);
        let found = cube.patches.locator.patch_at(cube.patches.pieces_of(new)[0].face, middle);
        assert_eq!(found, Some(new as u32), "the locator names the patch by its new number");
    }
}

/// Both halves of the floor keep their points in any order, and the trees their shape.
#[test]
fn cuts_name_the_patches_by_their_new_numbers() {
    let old = patches_of_a_parted_floor();
    let order = Permutation::new(vec![6, 2, 0, 5, 4, 1, 3]).expect("every patch once");
    let new = old.permuted(&order);
    new.check().expect("legal");
    for face in [16, 18] {
        for i in 0..100 {
            let point = [(i % 10) as f32 / 10.0 + 0.03, (i / 10) as f32 / 10.0 + 0.04, 0.0];
            let [a, b] = [&old, &new].map(|p| p.position[p.locator.patch_at(face, point).expect("a patch") as usize]);
            assert_eq!((a, a[0] > 0.5), (b, point[0] + point[1] >= 1.0), "at {point:?}");
        }
    }
    let back = Permutation::new(order.old_to_new()).expect("an inverse");
    assert_eq!(new.permuted(&back), old);
    let (cube, shuffle) = (cube_with_cuts(), Permutation::new(vec![5, 2, 0, 1, 4, 3]).expect("every patch once"));
    assert_eq!(
        cube.patches.permuted(&shuffle).permuted(&Permutation::new(shuffle.old_to_new()).expect("one")),
        cube.patches
    );
}

/// Patches 0 to 3 in the quarters of a square, by a tree of three cuts, then a cell with patch 1 alone.
fn quarters() -> PatchLocator {
    let plane = |axis: usize| std::array::from_fn(|i| if i == axis { 1.0 } else { 0.5 * f32::from(i == 3) });
    PatchLocator {
        cell_size: 1.0,
        face_start: vec![0, 2],
        cell_key: vec![0, 1],
        cell_patch: vec![CUT, 1],
        cuts: vec![
            Cut { plane: plane(0), child: [CUT | 1, CUT | 2] },
            Cut { plane: plane(1), child: [0, 1] },
            Cut { plane: plane(1), child: [2, 3] },
        ],
        ..PatchLocator::default()
    }
}

#[test]
fn the_place_of_a_dropped_patch_goes_to_the_other_side_of_the_nearest_cut() {
    let places = [[0.2, 0.2, 0.0], [0.2, 0.8, 0.0], [0.8, 0.2, 0.0], [0.8, 0.8, 0.0], [1.5, 0.5, 0.0]];
    let found = |l: &PatchLocator| places.map(|p| l.patch_at(0, p));
    assert_eq!(found(&quarters()), [0, 1, 2, 3, 1].map(Some));
    let without = |dropped: &[u32]| quarters().renumbered(|p| (!dropped.contains(&p)).then_some(p));
    assert_eq!(found(&without(&[0])), [1, 1, 2, 3, 1].map(Some));
    assert_eq!(without(&[0]).cuts.len(), 2);
    assert_eq!(found(&without(&[0, 1])), [2, 3, 2, 3, 3].map(Some), "the second cell has lost its only patch");
    assert_eq!(found(&without(&[0, 1, 3])), [Some(2); 5]);
    assert_eq!((without(&[0, 1, 3]).cuts, without(&[0, 1, 3]).cell_patch), (vec![], vec![2]));
    assert_eq!(found(&without(&[0, 1, 2, 3])), [None; 5]);
    let joined = quarters().renumbered(|p| Some(p / 2));
    assert_eq!((found(&joined), joined.cuts.len()), ([0, 0, 1, 1, 0].map(Some), 1));
    assert_eq!(quarters().renumbered(Some), quarters());
}

#[test]
fn a_point_at_a_border_is_told_from_one_that_only_lies_beside_it() {
    let locator = quarters();
    let find = |x: f32, y: f32, tolerance: f32| {
        let found = locator.find(0, [x, y, 0.0], tolerance).expect("the face has patches");
        (found.patch, found.at_border)
    };
    // Both sides of a cut, at one unit in the last place.
    let (low, high) = (0.5f32.next_down(), 0.5f32);
    assert_eq!([find(low, 0.2, 1e-6), find(high, 0.2, 1e-6)], [(0, true), (2, true)]);
    assert_eq!([find(0.2, low, 1e-6), find(0.2, high, 1e-6)], [(0, true), (1, true)]);
    assert_eq!([find(low, 0.2, 0.0), find(high, 0.2, 0.0)], [(0, false), (2, false)], "no error was asked for");
    // The cut between the patches of the other half is none of a point's.
    assert_eq!([find(0.498, 0.2, 1e-3), find(0.498, 0.2, 3e-3)], [(0, false), (0, true)]);
    // Both sides of the border between two cells.
    let (low, high) = (1.0f32.next_down(), 1.0f32);
    assert_eq!([find(low, 0.2, 1e-6), find(high, 0.2, 1e-6)], [(2, true), (1, true)]);
    assert_eq!([find(0.9, 0.2, 1e-6), find(1.1, 0.2, 1e-6)], [(2, false), (1, false)]);
    // Beyond the other ends of the cells there is nothing to be confused with.
    assert_eq!(
        [find(1e-9, 0.2, 1e-6), find(2.0, 0.2, 1e-6), find(2.1, 0.2, 1e-6)],
        [(0, false), (1, false), (1, false)]
    );
    let joined = locator.renumbered(|_| Some(0)).find(0, [low, 0.5, 0.0], 1e-6).expect("the face has patches");
    assert!(!joined.at_border, "one patch does not border on itself");
}

#[test]
fn form_factors_stay_reciprocal_in_any_order() {
    let cube = cube();
    for i in 0..6 {
        assert!((cube.factors.row(i).iter().sum::<f32>() - 1.0).abs() < 1e-6, "six f32 factors sum to 1");
        for j in 0..6 {
            assert_eq!(cube.factors.row(i)[j], cube.factors.row(j)[i], "all areas are 1");
        }
    }
}

#[test]
#[should_panic(expected = "one value a patch")]
fn a_list_of_another_length_is_a_bug_of_the_caller() {
    cube().order.apply(&[1.0]);
}

#[test]
#[should_panic(expected = "a square matrix over the patches")]
fn a_matrix_of_another_size_is_a_bug_of_the_caller() {
    cube().order.apply_to_matrix(&[1.0; 35]);
}
