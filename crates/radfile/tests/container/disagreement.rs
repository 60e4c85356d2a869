//! Records of one file that do not belong together are refused, whichever of them is read.

use radfile::{
    Builder, Container, FLAG_PATCH_ORDER, FLAG_REQUIRED, FormFactors, Mesh, Operator, PackedOperator, Patches,
    Permutation, Record, Transfer, read_sky,
};

use crate::{
    assert_says,
    fixture::{cube, open},
};

/// The cube with one section replaced.
fn with(edit: impl FnOnce(&mut Builder)) -> Container {
    let cube = cube();
    let mut builder = cube.builder();
    edit(&mut builder);
    open(&builder)
}

const FLAGS: u32 = FLAG_REQUIRED | FLAG_PATCH_ORDER;

#[test]
fn whatever_counts_patches_must_count_the_patches_of_the_file() {
    let c = with(|b| b.array("patches.area", FLAGS, &[5], vec![1.0f32; 5]));
    let stale = "made for 6 patches, the file holds 5; run its stage again";
    assert_says(FormFactors::read(&c), &["form factors: ", stale]);
    assert_says(read_sky(&c), &["form factors: ", stale]);
    assert_says(Operator::read(&c), &["operator: ", stale]);
    assert_says(PackedOperator::read(&c), &["packed operator: ", stale]);
    assert_says(Permutation::read(&c), &["permutation: ", stale]);
    assert_says(Transfer::read(&c), &["transfer: ", "names patch 5, there are 5"]);
    assert_says(Patches::read(&c), &["section patches.position holds f32 [6, 3], expected f32 [5, 3]"]);
}

#[test]
fn without_patches_in_the_file_a_record_stands_alone() {
    let cube = cube();
    let mut builder = Builder::new();
    cube.operator.write(&mut builder);
    cube.packed.write(&mut builder);
    let c = open(&builder);
    assert!(Operator::read(&c).is_ok() && PackedOperator::read(&c).is_ok());
    assert_says(Transfer::read(&c), &["section transfer.position is missing"]);
}

#[test]
fn patches_must_be_made_for_the_faces_of_the_mesh() {
    let c = with(|b| b.array("mesh.triangles", FLAG_REQUIRED, &[1, 3], vec![0u32, 1, 2]));
    assert_says(Patches::read(&c), &["patches: made for 24 faces, the mesh has 1 triangles with two each"]);
    assert_says(Transfer::read(&c), &["fine triangle 1 comes from triangle 1, there are 1"]);
}

#[test]
fn a_mesh_with_an_absurd_shape_and_no_bytes_is_refused() {
    let c = with(|b| b.array::<u32>("mesh.triangles", FLAG_REQUIRED, &[1 << 61, 0], vec![]));
    let said = "section mesh.triangles holds u32 [2305843009213693952, 0], expected u32 [any, 3]";
    assert_says(Mesh::read(&c), &[said]);
    assert_says(Patches::read(&c), &[said]);
    assert_says(Transfer::read(&c), &[said]);
}

#[test]
fn triangles_must_name_materials_of_the_file() {
    let mut cube = cube();
    cube.mesh.triangle_material[7] = 4;
    assert_says(Mesh::read(&open(&cube.builder())), &["mesh: triangle 7 has material 4, there are 4"]);
}
