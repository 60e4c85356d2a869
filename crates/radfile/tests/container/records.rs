//! Every record comes back as it was written, and the large ones stay views into the file.

use std::borrow::Cow;

use radfile::{
    Certificate, FormFactors, HierarchicalOperator, Materials, Mesh, Operator, PackedOperator, Patches, Permutation,
    Provenance, Record, Transfer, read_sky,
};

use crate::{
    assert_says,
    fixture::{Extras, cube, cube_with_cuts, every_feature, hierarchical, minimal, open, step},
};

#[test]
fn every_record_comes_back_as_it_was_written() {
    let cube = cube();
    let c = open(&cube.builder());
    assert_eq!(Mesh::read(&c).expect("legal"), cube.mesh);
    assert_eq!(Materials::read(&c).expect("legal"), cube.materials);
    assert_eq!(c.meta::<Extras>("scene.extras").expect("legal"), cube.extras);
    assert_eq!(Patches::read(&c).expect("legal"), cube.patches);
    assert_eq!(FormFactors::read(&c).expect("legal"), cube.factors);
    assert_eq!(read_sky(&c).expect("legal"), &cube.factors.sky[..]);
    assert_eq!(Operator::read(&c).expect("legal"), cube.operator);
    assert_eq!(Permutation::read(&c).expect("legal"), cube.order);
    assert_eq!(PackedOperator::read(&c).expect("legal"), cube.packed);
    assert_eq!(Transfer::read(&c).expect("legal"), cube.transfer);
    assert_eq!(Provenance::read(&c).expect("legal").steps, [step("voxel-simplify")]);
}

#[test]
fn a_hierarchical_operator_comes_back_and_makes_version_1_2() {
    let (cube, hierarchical) = (cube(), hierarchical());
    let mut builder = cube.builder();
    hierarchical.write(&mut builder);
    let c = open(&builder);
    assert_eq!(c.version(), (1, 2));
    let read = HierarchicalOperator::read(&c).expect("legal");
    assert_eq!(read, hierarchical);
    assert!(matches!(read.blocks, Cow::Borrowed(_)));
}

#[test]
fn an_illegal_certificate_of_a_hierarchical_operator_is_refused() {
    type Break = fn(&mut Certificate);
    let breaks: [(Break, &str); 4] = [
        (|k| k.n = 5, "made for 5 patches, the file holds 6"),
        (|k| k.channels = 2, "illegal certificate"),
        (|k| k.l2_mean = f64::NAN, "illegal certificate"),
        (|k| k.vis99 = -0.1, "illegal certificate"),
    ];
    for (break_it, sentence) in breaks {
        let (cube, mut broken) = (cube(), hierarchical());
        break_it(&mut broken.certificate);
        let mut builder = cube.builder();
        broken.write(&mut builder);
        assert_says(HierarchicalOperator::read(&open(&builder)), &[sentence]);
    }
}

#[test]
fn matrices_are_views_and_not_copies() {
    let c = open(&cube().builder());
    let factors = FormFactors::read(&c).expect("legal");
    let operator = Operator::read(&c).expect("legal");
    let packed = PackedOperator::read(&c).expect("legal");
    assert!(matches!((&factors.values, &factors.sky), (Cow::Borrowed(_), Cow::Borrowed(_))));
    assert!(matches!(&operator.values, Cow::Borrowed(_)));
    assert!(matches!((&packed.blocks, &packed.outlier_value), (Cow::Borrowed(_), Cow::Borrowed(_))));
    assert!(matches!((&packed.outlier_start, &packed.outlier_column), (Cow::Borrowed(_), Cow::Borrowed(_))));
}

#[test]
fn a_file_is_of_version_1_1_only_where_a_face_is_cut() {
    let (plain, cut) = (cube(), cube_with_cuts());
    let c = open(&cut.builder());
    assert_eq!((c.version(), open(&plain.builder()).version()), ((1, 1), (1, 0)));
    assert!(!open(&plain.builder()).has("patches.cut_plane"));
    assert_eq!(Patches::read(&c).expect("legal"), cut.patches);
    assert_eq!(radfile::Builder::from_input(&c, |_| true).to_bytes(), c.as_bytes(), "it is handed through as it is");
    let half = radfile::Builder::from_input(&c, |s| s.name != "patches.cut_plane");
    assert_says(Patches::read(&open(&half)), &["section patches.cut_plane is missing"]);
    let half = radfile::Builder::from_input(&c, |s| s.name != "patches.cut_child");
    assert_says(Patches::read(&open(&half)), &["section patches.cut_child is missing"]);
}

#[test]
fn a_mesh_without_texture_coordinates_has_no_sections_for_them() {
    let mut cube = cube();
    (cube.mesh.uv, cube.mesh.emission_uv) = (vec![], vec![]);
    let c = open(&cube.builder());
    assert!(!c.has("mesh.uv") && !c.has("mesh.emission_uv"));
    assert_eq!(Mesh::read(&c).expect("legal"), cube.mesh);
}

#[test]
fn a_missing_section_names_the_stage_that_writes_it() {
    let c = open(&minimal());
    assert_says(Patches::read(&c), &["section patches.area is missing; it is written by `allbounce voxel-simplify`"]);
    assert_says(FormFactors::read(&c), &["section formfactor.sky is missing; it is written by `allbounce formfactor`"]);
    assert_says(c.section("x-unheard"), &["section x-unheard is missing", "(no stage of this version)"]);
}

#[test]
fn a_file_without_provenance_has_no_steps() {
    assert_eq!(Provenance::read(&open(&radfile::Builder::new())).expect("legal"), Provenance::default());
}

#[test]
fn provenance_grows_by_one_line_a_stage() {
    let input = open(&minimal());
    let mut builder = radfile::Builder::from_input(&input, |_| true);
    builder.provenance(Some(&input), step("dxt-pack")).expect("readable");
    let stages: Vec<String> =
        Provenance::read(&open(&builder)).expect("legal").steps.into_iter().map(|s| s.stage).collect();
    assert_eq!(stages, ["permute", "dxt-pack"]);
}

#[test]
fn asking_for_another_type_or_shape_says_what_is_there() {
    let c = open(&every_feature());
    let said = "section x-rank.2 holds u32 [2, 3], expected f32 with 2 dimensions";
    assert_says(c.array::<f32>("x-rank.2", 2), &[said]);
    assert_says(c.array::<u32>("x-rank.2", 1), &["expected u32 with 1 dimension"]);
    assert_says(c.array_of::<u32>("x-rank.2", &[None, Some(2)]), &["holds u32 [2, 3], expected u32 [any, 2]"]);
    assert_says(c.meta::<String>("x-rank.2"), &["section x-rank.2 holds u32 [2, 3], expected metadata"]);
    assert_says(c.array::<u8>("x-note", 1), &["section x-note holds meta [39], expected u8 with 1 dimension"]);
}

#[test]
fn the_digest_is_blake3_in_hexadecimal() {
    // First test vector of the BLAKE3 paper: no input.
    let empty = "af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262";
    assert_eq!(radfile::digest(b""), empty);
}
