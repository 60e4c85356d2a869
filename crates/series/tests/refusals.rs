//! Input that has no answer is refused in a sentence that names the culprit.

mod common;

use common::patches;
use radfile::{FormFactors, Patches, Quiet};
use series::all_bounces;

fn refusal(patches: &Patches, factors: &FormFactors, bounces: Option<u32>) -> String {
    all_bounces(patches, factors, &common::params(bounces), &Quiet)
        .map(|_| ())
        .expect_err("must be refused")
        .to_string()
}

fn plates(values: [f32; 4]) -> FormFactors<'static> {
    FormFactors { values: values.to_vec().into(), sky: vec![0.0; 2].into() }
}

#[test]
fn light_that_grows_is_refused_and_the_patch_is_named() {
    // A disc formula near contacts: patch 2 would see 0.9 + 0.9 of the others.
    let mut values = vec![0.0; 9];
    for (i, j, f) in [(0, 1, 0.1), (0, 2, 0.9), (1, 2, 0.9)] {
        values[i * 3 + j] = f;
        values[j * 3 + i] = f;
    }
    let factors = FormFactors { values: values.into(), sky: vec![0.0; 3].into() };
    for bounces in [None, Some(3)] {
        let text = refusal(&patches(vec![1.0; 3], vec![[0.2, 0.9, 0.2]; 3]), &factors, bounces);
        assert!(text.starts_with("green: light grows from bounce to bounce"), "{text}");
        assert!(text.contains("patch 2, which gives back 1.6200"), "{text}");
        assert!(text.contains("by 1.1") && text.contains("make the form factors again"), "{text}");
    }
}

#[test]
fn light_that_never_fades_is_refused() {
    // Eight patches that hand on all they get and a bit more: radius just above 1, found by Cholesky or before.
    let n = 8;
    let values: Vec<f32> = (0..n * n).map(|at| if at / n == at % n { 0.0 } else { 0.143 }).collect();
    let factors = FormFactors { values: values.into(), sky: vec![0.0; n].into() };
    let text = refusal(&patches(vec![1.0; n], vec![[0.9999; 3]; n]), &factors, None);
    assert!(text.starts_with("grey: light grows") && text.contains("by 1.000"), "{text}");
}

#[test]
fn a_corner_where_light_grows_slowly_is_found_among_many_where_it_fades() {
    // Ten separate corners of three patches; light keeps 0.998 of itself a bounce in nine, 1.0002 in the fourth.
    // Power iteration is too slow to tell them apart; the factorisation is exact.
    let n = 30;
    let mut values = vec![0.0; n * n];
    for i in 0..n {
        let keeps: f32 = if i / 3 == 3 { 1.0002 } else { 0.998 };
        for j in (0..n).filter(|&j| j != i && j / 3 == i / 3) {
            values[i * n + j] = keeps / 2.0 / 0.999;
        }
    }
    let factors = FormFactors { values: values.into(), sky: vec![0.0; n].into() };
    let text = refusal(&patches(vec![1.0; n], vec![[0.999; 3]; n]), &factors, None);
    assert!(text.starts_with("grey: light grows") && text.contains("1.0002 of the light around it"), "{text}");
    assert!((9..12).any(|patch| text.contains(&format!("the worst is patch {patch},"))), "{text}");
}

#[test]
fn form_factors_of_another_scene_are_refused() {
    let text = refusal(&patches(vec![1.0; 3], vec![[0.5; 3]; 3]), &plates([0.0; 4]), None);
    assert!(text.starts_with("form factors of 2 patches (4 values), but there are 3 patches"), "{text}");
}

#[test]
fn a_scene_without_patches_is_refused() {
    let none = FormFactors { values: vec![].into(), sky: vec![].into() };
    assert!(refusal(&patches(vec![], vec![]), &none, None).starts_with("the scene has no patches"));
}

#[test]
fn no_bounce_at_all_is_refused() {
    let text = refusal(&patches(vec![1.0; 2], vec![[0.5; 3]; 2]), &plates([0.0, 0.5, 0.5, 0.0]), Some(0));
    assert!(text.starts_with("0 bounces were asked for"), "{text}");
}

#[test]
fn numbers_that_no_surface_has_are_refused_by_patch() {
    let good = || patches(vec![1.0; 2], vec![[0.5; 3]; 2]);
    let f = || plates([0.0, 0.5, 0.5, 0.0]);
    for area in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let text = refusal(&Patches { area: vec![1.0, area], ..good() }, &f(), None);
        assert!(text.starts_with("area of patch 1 is"), "{text}");
    }
    for rho in [1.0, -0.1, f32::NAN] {
        let text = refusal(&Patches { reflectance: vec![[0.5, rho, 0.5], [0.5; 3]], ..good() }, &f(), None);
        assert!(text.starts_with("reflectance of patch 0 is"), "{text}");
    }
    for factor in [1.5, -0.1, f32::NAN] {
        let text = refusal(&good(), &plates([0.0, 0.5, factor, 0.0]), None);
        assert!(text.starts_with("a form factor of patch 1 is"), "{text}");
    }
    let text = refusal(&good(), &FormFactors { sky: vec![0.5, f32::NAN].into(), ..f() }, None);
    assert!(text.starts_with("the sky's share of patch 1 is"), "{text}");
}
