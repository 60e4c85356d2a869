//! One permutation moves patches, form factors, operator and locator together; light does not notice.

use radfile::{Operator, Patches, Permutation};

use crate::fixture::cube;

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
