//! Packing errs to either side, but no irradiance comes out below 0.

mod common;

use common::cube;
use hmatrix::{Params, Row, Senders, compress, compress_rows};
use radfile::{Certificate, GatherCertificate, Gathered, Kernel, Quiet};
use relight::{Bounces, Frame, Operator, Receivers, radiosity};
use scene::Rays;

/// Light on one patch alone, so that others have little.
fn one_lit(n: usize, lit: usize) -> Vec<[f32; 3]> {
    (0..n).map(|i| if i == lit { [1.0, 2.0, 4.0] } else { [0.0; 3] }).collect()
}

/// How many values are below 0.
fn negative(light: &[[f32; 3]]) -> usize {
    light.as_flattened().iter().filter(|e| **e < 0.0).count()
}

#[test]
fn light_of_a_coarse_operator_is_nowhere_negative() {
    let cube = cube(6, 0.5, 0.0);
    let n = cube.patches.len();
    let values = cube.factors.values.clone();
    let dense = radfile::Operator { n, channels: 1, bounces: None, values };
    let (matrix, _) = compress(&dense, &cube.patches, &Params::error(0.3), &Quiet).expect("symmetric");
    // Equal patches: light scaled by the roots of areas comes back as it is.
    let direct = one_lit(n, 0);
    let sent: Vec<[f32; 3]> = direct.iter().map(|h| h.map(|h| 0.5 * h)).collect();
    let mut product = vec![[0.0; 3]; n];
    matrix.multiply(&sent, &mut product, &mut matrix.workspace());
    assert!(negative(&product) > 0, "the packed product is below 0 somewhere, or this shows nothing");
    let certificate = Certificate {
        n: n as u32,
        channels: 1,
        kernel: Kernel::AllBounces,
        bounces: None,
        error_wanted: 0.3,
        probes: 1,
        l2_mean: 0.0,
        vis99: 0.0,
    };
    let operator = Operator::Hierarchical(matrix, certificate);
    let mut bounces = Bounces::new(&cube.patches, &operator);
    for (light, product) in bounces.indirect(&direct).as_flattened().iter().zip(product.as_flattened()) {
        assert!(*light >= 0.0 && (light - product.max(0.0)).abs() <= 1e-5 * product.abs(), "{light} of {product}");
    }
}

#[test]
fn light_of_coarse_rows_is_nowhere_negative() {
    let cube = cube(8, 0.5, 0.0);
    let n = cube.patches.len();
    let row = |receiver: usize, out: &mut Row| {
        let own = cube.factors.row(receiver).iter().enumerate();
        out.extend(own.filter(|(_, f)| **f > 0.0).map(|(sender, f)| (sender as u32, 0.9 * f)));
    };
    // Senders are the patches and then their elements, which are whole patches here; no row names those.
    let twice = |v: &[[f32; 3]]| [v, v].concat();
    let (position, normal) = (&cube.patches.position, &cube.patches.normal);
    let senders = Senders {
        position: &twice(position),
        normal: &twice(normal),
        area: &[&cube.patches.area[..], &cube.patches.area].concat(),
        reflectance: &twice(&cube.patches.reflectance),
    };
    let places = hmatrix::Receivers { position, normal };
    let (rows, _) = compress_rows(&places, &senders, &row, &Params::error(0.3), &Quiet).expect("sound rows");
    let of_one = |lit: usize| {
        let direct = one_lit(n, lit);
        let frame = Frame { element_direct: direct.clone(), direct, indirect: vec![[0.0; 3]; n] };
        let mut product = vec![[0.0; 3]; n];
        rows.multiply(&radiosity(&cube.elements, &frame), &mut product, &mut rows.workspace());
        (frame, product)
    };
    let mut all = (0..n).map(of_one);
    let found = all.find(|(_, product)| negative(product) > 0);
    let (frame, product) = found.expect("the packed product is below 0 somewhere, or this shows nothing");
    let stream = rows.to_bytes().to_vec();
    let gathered = Gathered { certificate: GatherCertificate::default(), stream, sky: vec![0.1; n] };
    let receivers = Receivers::gathered(&gathered, cube.elements.senders()).expect("own bytes");
    let rays = Rays::new(&cube.scene.mesh);
    let bake = cube.relighter(&rays);
    for (light, product) in receivers.indirect(&bake, &frame).as_flattened().iter().zip(product.as_flattened()) {
        assert_eq!(*light, product.max(0.0));
    }
}
