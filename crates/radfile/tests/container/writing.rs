//! Writing: the same contents give the same bytes, and no half-written file is left behind.

use std::path::Path;

use radfile::{Builder, Container, FLAG_PATCH_ORDER, FLAG_REQUIRED};

use crate::{
    assert_says,
    fixture::{cube, every_feature, minimal, open},
};

#[test]
fn the_same_contents_give_the_same_bytes() {
    let (a, b) = (cube(), cube());
    assert_eq!(a.builder().to_bytes(), b.builder().to_bytes());
    assert_eq!(a.builder().finish().expect("legal").as_bytes(), a.builder().to_bytes());
}

#[test]
fn a_copied_container_has_the_same_bytes_unknown_sections_included() {
    let input = open(&every_feature());
    let copy = Builder::from_input(&input, |_| true);
    assert_eq!(copy.to_bytes(), input.as_bytes());
    let note: String = open(&copy).meta("x-note").expect("handed through");
    assert_eq!(note, "a section that no version knows");
    let section = open(&copy).section("x-rank.3").expect("handed through").clone();
    assert_eq!((section.flags, section.shape), (FLAG_PATCH_ORDER, vec![1, 2, 2]));
}

#[test]
fn a_stage_replaces_its_section_and_drops_what_it_does_not_keep() {
    let input = open(&every_feature());
    let mut builder = Builder::from_input(&input, |s| !s.name.starts_with("x-rank"));
    builder.array::<u32>("permute.new_to_old", FLAG_REQUIRED, &[2], vec![1, 0]);
    let output = open(&builder);
    assert!(!output.has("x-rank.1") && output.has("x-scalar"));
    assert_eq!(output.array::<u32>("permute.new_to_old", 1).expect("replaced").0, [1, 0]);
    assert_eq!(output.sections().iter().filter(|s| s.name == "permute.new_to_old").count(), 1);
}

#[test]
fn an_empty_container_is_a_container() {
    assert_eq!(open(&Builder::new()).as_bytes().len(), 64);
}

#[test]
fn arrays_are_views_into_the_file_mapped_or_in_memory() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("all.rad");
    every_feature().write_file(&path).expect("written");
    for container in [Container::open(&path).expect("mapped"), open(&every_feature())] {
        let file = container.as_bytes().as_ptr_range();
        let (values, shape) = container.array::<u64>("x-rank.4", 4).expect("it was written");
        assert_eq!((values, shape), (&[0, 1, u64::MAX, 1 << 63][..], &[2, 1, 1, 2][..]));
        assert!(file.contains(&values.as_ptr().cast()), "the array was copied");
        assert_eq!(container.array::<f64>("x-scalar", 0).expect("written").0, [-0.5]);
        assert_eq!(container.array::<f32>("x-empty.rows", 2).expect("written").1, [0, 3]);
        assert_eq!(container.array::<u16>("x-rank.1", 1).expect("written").0, [1, 65535]);
    }
}

fn entries(folder: &Path) -> Vec<String> {
    let names = std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").file_name());
    let mut names: Vec<String> = names.map(|n| n.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_file_is_replaced_whole_and_nothing_else_is_left() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.rad");
    minimal().write_file(&path).expect("written");
    let old = Container::open(&path).expect("a container");
    every_feature().write_file(&path).expect("written over it");
    assert_eq!(old.as_bytes(), minimal().to_bytes(), "a reader of the old file is not disturbed");
    assert_eq!(std::fs::read(&path).expect("readable"), every_feature().to_bytes());
    assert_eq!(entries(folder.path()), ["a.rad"]);
}

#[test]
fn a_missing_folder_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let missing = folder.path().join("out");
    let want = format!("the folder {} does not exist; create it first", missing.display());
    assert_says(minimal().write_file(&missing.join("a.rad")), &[&want]);
    assert_eq!(entries(folder.path()), [""; 0]);
}

#[test]
fn an_output_that_is_a_folder_is_refused_and_stays() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let target = folder.path().join("a.rad");
    std::fs::create_dir(&target).expect("created");
    assert_says(minimal().write_file(&target), &["is a folder, expected a file name"]);
    assert_eq!(entries(folder.path()), ["a.rad"]);
}

#[cfg(unix)]
#[test]
fn a_device_is_never_replaced_by_a_file() {
    assert_says(minimal().write_file(Path::new("/dev/null")), &["/dev/null", "is a pipe or a device"]);
}

#[cfg(unix)]
#[test]
fn new_files_have_the_rights_that_other_new_files_have() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (ours, plain) = (folder.path().join("a.rad"), folder.path().join("b"));
    minimal().write_file(&ours).expect("written");
    std::fs::write(&plain, b"").expect("written");
    let mode = |p: &Path| std::fs::metadata(p).expect("it is there").permissions().mode();
    assert_eq!(mode(&ours), mode(&plain));
}

#[test]
fn metadata_that_no_reader_would_take_is_not_written() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut builder = Builder::new();
    builder.meta("x-note", 0, &"a".repeat(65 << 20));
    let parts = ["metadata of x-note", "it would hold 68157448 bytes, at most 67108864 can be read"];
    assert_says(builder.write_file(&folder.path().join("a.rad")), &parts);
    assert_says(builder.finish(), &parts);
    assert_eq!(entries(folder.path()), [""; 0]);
}

#[test]
#[should_panic(expected = "section name \"Patches\" is not 1 to 32 of a-z 0-9 . _ -")]
fn an_illegal_name_is_a_bug_of_the_caller() {
    Builder::new().array::<u8>("Patches", 0, &[0], vec![]);
}

#[test]
#[should_panic(expected = "shape [2, 3] of section x")]
fn a_wrong_shape_is_a_bug_of_the_caller() {
    Builder::new().array::<u8>("x", 0, &[2, 3], vec![0; 5]);
}

#[test]
#[should_panic(expected = "section x has more than 4 dimensions")]
fn a_fifth_dimension_is_a_bug_of_the_caller() {
    Builder::new().array::<u8>("x", 0, &[1, 1, 1, 1, 1], vec![0]);
}
