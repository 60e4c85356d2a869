//! Numbers that a record must not hold: each is refused with the first offender named.

use std::borrow::Cow;

use radfile::{
    CUT, Cut, FormFactors, Materials, Mesh, NO_RECEIVER, Operator, PackedOperator, Packing, Patches, Permutation,
    Record, Rows, Transfer, Weights, read_sky,
};

use crate::{
    assert_says,
    fixture::{Cube, cube, cube_with_cuts, open},
};

/// One way to break the cube, and what is said.
type Case = (fn(&mut Cube), &'static str);

macro_rules! refuses {
    ($test:ident, $record:ty, $cases:expr) => {
        #[test]
        fn $test() {
            let cases: &[Case] = $cases;
            for (break_it, said) in cases {
                let mut cube = cube();
                break_it(&mut cube);
                let (container, said) = (open(&cube.builder()), *said);
                assert!(<$record>::read(&container).is_err(), "this was accepted: {said}");
                assert_says(<$record>::read(&container), &[said]);
            }
        }
    };
}

refuses!(
    a_mesh_with_broken_numbers_is_refused,
    Mesh,
    &[
        (|c| c.mesh.positions[3][1] = f32::NAN, "mesh: vertex 3 is [0.0, NaN, 1.0], expected finite numbers"),
        (|c| c.mesh.origin[2] = f64::INFINITY, "mesh: origin is [4000000.5, -0.25, inf], expected finite"),
        (|c| c.mesh.triangles[11][2] = 24, "mesh: triangle 11 names vertices [20, 22, 24], there are 24"),
        (|c| c.mesh.uv[5][0] = f32::NAN, "mesh: vertex 5 has uv [NaN, 0.0], expected finite numbers"),
        (
            |c| c.mesh.lightmap_uv = vec![[f32::NAN; 2]; 24],
            "mesh: vertex 0 has lightmap_uv [NaN, NaN], expected finite numbers"
        ),
        (|c| c.mesh.emission_uv[0][1] = f32::INFINITY, "mesh: vertex 0 has emission_uv [0.5, inf]"),
        (
            |c| {
                c.mesh.triangles.clear();
                c.mesh.triangle_material.clear();
            },
            "mesh: no triangles"
        ),
        (|c| c.mesh.triangle_material.truncate(11), "section mesh.material holds u32 [11], expected u32 [12]"),
        (|c| c.mesh.uv.truncate(23), "section mesh.uv holds f32 [23, 2], expected f32 [24, 2]"),
    ]
);

refuses!(
    materials_with_broken_numbers_are_refused,
    Materials,
    &[
        (
            |c| c.materials.materials[1].reflectance[0] = 1.0,
            "materials: material \"red\" has reflectance [1.0, 0.065, 0.05], expected 0 ≤ ρ < 1"
        ),
        (|c| c.materials.materials[1].reflectance[2] = f32::NAN, "has reflectance [0.63, 0.065, NaN]"),
        (|c| c.materials.materials[0].reflectance[2] = -0.1, "has reflectance [0.75, 0.75, -0.1]"),
        (|c| c.materials.materials[3].emission[0] = -1.0, "has emission [-1.0, 12.0, 4.0], expected numbers ≥ 0"),
        (|c| c.materials.materials[3].emission[1] = f32::INFINITY, "has emission [17.0, inf, 4.0]"),
        (
            |c| c.materials.materials[2].emission_texture = Some(2),
            "materials: material \"grün\" names a texture that is not there"
        ),
    ]
);

refuses!(
    patches_with_broken_numbers_are_refused,
    Patches,
    &[
        (|c| c.patches.area[2] = f32::NAN, "patches: patch 2 has area NaN, expected a positive number"),
        (|c| c.patches.area[0] = 0.0, "patches: patch 0 has area 0, expected a positive number"),
        (|c| c.patches.area[5] = f32::INFINITY, "patch 5 has area inf"),
        (|c| c.patches.reflectance[4] = [0.5, 1.0, 0.5], "patch 4 has reflectance [0.5, 1.0, 0.5], expected 0 ≤ ρ < 1"),
        (|c| c.patches.emission[1] = [-1.0, 0.0, 0.0], "patch 1 has emission [-1.0, 0.0, 0.0], expected numbers ≥ 0"),
        (|c| c.patches.normal[3] = [0.5, 0.0, 0.0], "patch 3 has normal [0.5, 0.0, 0.0], expected a unit vector"),
        (|c| c.patches.normal[3] = [f32::NAN, 0.0, 1.0], "patch 3 has normal [NaN, 0.0, 1.0]"),
        (|c| c.patches.position[0][0] = f32::NAN, "patch 0 lies at [NaN"),
        (|c| c.patches.piece_start[2] = 1, "patches: piece_start does not run from 0 to 12 in 6 steps"),
        (|c| c.patches.piece_start[0] = 1, "piece_start does not run from 0 to 12"),
        (|c| c.patches.piece_start[6] = 11, "piece_start does not run from 0 to 12"),
        (|c| c.patches.piece_start[6] = u32::MAX, "piece_start does not run from 0 to 12"),
        (|c| c.patches.piece_start[1] = 0, "patch 0 has no pieces"),
        (|c| c.patches.pieces[7].face = 24, "expected finite corners and a face below 24"),
        (|c| c.patches.pieces[7].corners[2][1] = f32::INFINITY, "patches: piece 7 is "),
        (|c| c.patches.locator.face_start[24] = 11, "face_start does not run from 0 to 12 in 24 steps"),
        (|c| c.patches.locator.face_start.clear(), "expected finite corners and a face below 0"),
        (|c| c.patches.locator.cell_size = 0.0, "voxel grid of cell size 0 at [-0.25, -0.25, -0.25], expected"),
        (|c| c.patches.locator.grid_origin[0] = f32::NAN, "voxel grid of cell size 1.5 at [NaN"),
        (|c| c.patches.locator.cell_patch[9] = 6, "cell 9 names patch 6, there are 6"),
        (
            |c| c.patches.locator.face_start[1..].iter_mut().for_each(|s| *s = (*s + 1).min(12)),
            "the cells of face 0 do not increase"
        ),
        (|c| c.patches.locator.cell_patch[9] = CUT, "cell 9 names cut 0, expected 0 to 0"),
    ]
);

#[test]
fn cuts_that_are_no_trees_are_refused() {
    let cases: &[Case] = &[
        (|c| c.patches.locator.cuts[1].plane[3] = f32::NAN, "cut 1 is the plane [0.0, 1.0, 0.0, NaN], expected finite"),
        (|c| c.patches.locator.cuts[2].child[0] = 6, "patches: cut 2 names patch 6, there are 6"),
        (|c| c.patches.locator.cuts[2].child[0] = CUT | 2, "cut 2 names cut 2, expected 3 to 3"),
        (|c| c.patches.locator.cuts[2].child[1] = CUT, "cut 2 names cut 0, expected 3 to 3"),
        (|c| c.patches.locator.cuts[0].child[0] = CUT | 3, "cut 0 names cut 3, expected 1 to 3"),
        (|c| c.patches.locator.cuts[0].child[1] = u32::MAX, "cut 0 names cut 2147483647, expected 1 to 3"),
        (|c| c.patches.locator.cuts[0].child[1] = CUT | 1, "cut 0 names cut 1, which is named already"),
        (|c| c.patches.locator.cell_patch[0] = CUT, "cell 8 names cut 0, which is named already"),
        (|c| c.patches.locator.cell_patch[9] = 0, "cut 1 is the cut 0 below its cell, expected 1 to 64"),
        (
            |c| {
                let chain =
                    |i: u32| Cut { plane: [1.0, 0.0, 0.0, 0.5], child: [0, if i < 64 { CUT | (i + 1) } else { 1 }] };
                c.patches.locator.cuts = (0..65).map(chain).collect();
                c.patches.locator.cell_patch[9] = 0;
            },
            "cut 64 is the cut 65 below its cell, expected 1 to 64",
        ),
    ];
    for (break_it, said) in cases {
        let mut cube = cube_with_cuts();
        break_it(&mut cube);
        assert_says(Patches::read(&open(&cube.builder())), &[said]);
    }
    assert!(Patches::read(&open(&cube_with_cuts().builder())).is_ok());
}

refuses!(
    form_factors_outside_zero_to_one_are_refused,
    FormFactors,
    &[
        (|c| c.factors.values.to_mut()[8] = -0.1, "form factors: F[1, 2] is -0.1, expected 0 ≤ F ≤ 1"),
        (|c| c.factors.values.to_mut()[35] = 1.5, "F[5, 5] is 1.5"),
        (|c| c.factors.values.to_mut()[0] = f32::NAN, "F[0, 0] is NaN"),
        (|c| c.factors.sky.to_mut()[4] = 1.25, "form factors: sky of patch 4 is 1.25, expected 0..1"),
    ]
);

refuses!(
    an_operator_with_broken_numbers_is_refused,
    Operator,
    &[
        (
            |c| c.operator.values.to_mut()[36 + 7] = -1e-9,
            "operator: K[1, 1] of channel 1 is -0.000000001, expected K ≥ 0"
        ),
        (|c| c.operator.values.to_mut()[71] = f32::INFINITY, "K[5, 5] of channel 1 is inf"),
        (
            |c| {
                c.operator.channels = 2;
                c.operator.values.to_mut().truncate(72);
            },
            "operator: shape [2, 6, 6], expected [1 or 3, n, n]"
        ),
    ]
);

refuses!(
    a_permutation_that_is_none_is_refused,
    Permutation,
    &[(|c| c.order = Permutation::identity(7), "permutation: made for 7 patches, the file holds 6")]
);

refuses!(
    a_packed_operator_with_broken_numbers_is_refused,
    PackedOperator,
    &[
        (|c| c.packed.packing.scale[1] = f32::NAN, "packed operator: illegal packing"),
        (|c| c.packed.packing.map = radfile::ValueMap::Log { shift: 0.0 }, "packed operator: illegal packing"),
        (|c| c.packed.outlier_start.to_mut()[3] = 3, "outlier_start does not run from 0 to 2 in 6 steps"),
        (|c| c.packed.outlier_column.to_mut()[1] = 6, "packed operator: outlier 1 lies in column 6"),
        (|c| c.packed.outlier_value.to_mut()[4] = f32::NAN, "packed operator: outlier value 4 is not finite"),
        (
            |c| {
                c.packed.outlier_start = Cow::Owned(vec![0, 2, 2, 2, 2, 2, 2]);
                c.packed.outlier_column = Cow::Owned(vec![3, 3]);
            },
            "packed operator: the columns of the outliers of row 0 do not increase"
        ),
    ]
);

fn rows(c: &mut Cube) -> &mut Rows {
    match &mut c.transfer.weights {
        Weights::Interpolated(rows) => rows,
        Weights::Gathered(_) => panic!("the cube interpolates"),
    }
}

refuses!(
    a_transfer_with_broken_numbers_is_refused,
    Transfer,
    &[
        (|c| c.transfer.position[2][0] = f32::NAN, "transfer: receiver 2 lies at [NaN"),
        (|c| c.transfer.normal[5] = [0.0; 3], "transfer: receiver 5 has normal [0.0, 0.0, 0.0], expected a unit"),
        (|c| rows(c).row_start[4] = 20, "transfer: row_start does not run from 0 to 46 in 24 steps"),
        (|c| rows(c).sender[3] = 6, "transfer: entry 3 names patch 6, there are 6"),
        (|c| rows(c).weight[1] = -0.5, "transfer: entry 1 has weight -0.5, expected 0..1"),
        (|c| rows(c).weight[1] = f32::NAN, "transfer: entry 1 has weight NaN"),
        (|c| rows(c).weight[2] = 0.25, "transfer: the weights of receiver 1 sum to 0.5, expected 1"),
        (|c| c.transfer.fine.vertex[9][2] = f32::INFINITY, "transfer: fine vertex 9 is "),
        (|c| c.transfer.fine.triangle[1][0] = 24, "transfer: fine triangle 1 names vertices [24, 2, 3], there are 24"),
        (|c| c.transfer.fine.source[8] = 12, "transfer: fine triangle 8 comes from triangle 12, there are 12"),
        (|c| c.transfer.fine.receiver[0][1][2] = 24, "transfer: fine triangle 0 names receivers "),
        (|c| c.transfer.fine.receiver.truncate(11), "section transfer.fine_receiver holds u32 [11, 2, 3], expected"),
    ]
);

#[test]
fn packings_that_cannot_be_are_refused() {
    let cube = cube();
    let with = |edit: fn(&mut Packing)| {
        let mut packing = cube.packed.packing.clone();
        edit(&mut packing);
        let mut builder = cube.builder();
        builder.meta("pack.meta", radfile::FLAG_REQUIRED, &packing);
        open(&builder)
    };
    let edits: [fn(&mut Packing); 6] =
        [|p| p.channels = 2, |p| p.tile = 4, |p| p.tile = 0, |p| p.tiles = 2, |p| p.n = 0, |p| p.n = u32::MAX];
    for edit in edits {
        assert_says(PackedOperator::read(&with(edit)), &["packed operator: illegal packing Packing { n: "]);
    }
    let said = "section pack.blocks holds u8 [3, 32], expected u8 [1, 32]";
    assert_says(PackedOperator::read(&with(|p| p.format = radfile::BlockFormat::Bc1)), &[said]);
}

#[test]
fn a_table_that_is_no_permutation_is_refused() {
    assert_says(Permutation::new(vec![0, 2, 2]), &["permutation: patch 2 is named twice"]);
    assert_says(Permutation::new(vec![0, 3, 1]), &["permutation: entry 1 names patch 3 of 3"]);
    assert_says(Permutation::new(vec![u32::MAX]), &["permutation: entry 0 names patch 4294967295 of 1"]);
    assert!(Permutation::new(vec![]).is_ok());
}

#[test]
fn texture_bytes_that_are_missing_or_left_over_are_refused() {
    let cube = cube();
    let with = |length: usize| {
        let mut builder = cube.builder();
        builder.array("materials.textures", radfile::FLAG_REQUIRED, &[length], vec![0u8; length]);
        open(&builder)
    };
    assert_says(Materials::read(&with(133)), &["materials: texture \"lamp.png\" of 67 bytes is cut short"]);
    assert_says(Materials::read(&with(136)), &["materials: 2 bytes of textures belong to none"]);
}

#[test]
fn the_sky_is_checked_where_the_form_factors_are_gone() {
    let mut cube = cube();
    cube.factors.sky.to_mut()[0] = f32::NAN;
    assert_says(read_sky(&open(&cube.builder())), &["form factors: sky of patch 0 is NaN, expected 0..1"]);
}

#[test]
fn a_corner_that_nobody_sees_is_legal() {
    let mut cube = cube();
    cube.transfer.fine.receiver[0] = [[NO_RECEIVER; 3]; 2];
    assert!(Transfer::read(&open(&cube.builder())).is_ok());
}
