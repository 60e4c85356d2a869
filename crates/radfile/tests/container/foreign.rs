//! Files of other programs: each is told apart from a damaged container, with a hint.

use std::path::Path;

use radfile::{Container, Error};

use crate::{assert_says, fixture::minimal, refusal};

#[test]
fn files_of_other_programs_are_refused_with_a_hint() {
    let cases: &[(&[u8], &str)] = &[
        (b"", "starts with nothing, it is empty"),
        (b"hello world", "(it is text; Radiance scenes also end in .rad, but they are another format)"),
        ("ein Würfel".as_bytes(), "(it is text"),
        (b"# Cornell box\n\nvoid plastic white\n0\n0\n5 .7 .7 .7 0 0\n", "(it is a Radiance file"),
        (b"!xform -rz 90 chair.rad", "(it is a Radiance file"),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", "(it is a Radiance file"),
        (b"white polygon floor\n0\n0\n12", "(it is a Radiance file"),
        (b"# Blender\nmtllib box.mtl\nv 0 0 0\n", "(it is a Wavefront OBJ mesh; a scene goes to `allbounce voxel-"),
        (b"{\n  \"asset\": {\"version\": \"2.0\"}}", "(it is JSON, perhaps a glTF scene"),
        (b"glTF\x02\0\0\0\x10\0\0\0", "(it is a binary glTF file; a scene goes to"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "(it is a PNG picture)"),
        (b"\x76\x2f\x31\x01\x02\0\0\0", "(it is an OpenEXR picture)"),
        (b"\x8dRAD\n\x1a\n", "(it was one: newlines or the eighth bit were converted in transfer"),
        (b"\rRAD\r\n\x1a\n", "(it was one: newlines or the eighth bit"),
        (b"\0\x01\x02\x03\xff", "expected the identifier 8D 52 41 44 0D 0A 1A 0A"),
    ];
    for (bytes, hint) in cases {
        let said = refusal(bytes);
        assert!(said.starts_with("this is no Allbounce container: it starts with "), "{said}");
        assert!(said.contains(hint), "{said:?} does not say {hint:?}");
    }
}

#[test]
fn a_cut_character_at_the_end_of_the_window_is_still_text() {
    let text = "ü".repeat(3000);
    assert!(refusal(&text.as_bytes()[..4095]).contains("(it is text"));
    assert!(refusal(text.as_bytes()).contains("(it is text"));
}

#[test]
fn a_folder_and_a_missing_file_are_refused_as_such() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    assert_says(Container::open(folder.path()), &["is a folder, expected a .rad file"]);
    let missing = folder.path().join("missing.rad");
    let error = Container::open(&missing).err().expect("it is not there");
    assert!(
        matches!(&error, Error::Io { path, source } if *path == missing && source.kind() == std::io::ErrorKind::NotFound)
    );
    assert!(error.to_string().starts_with(&missing.display().to_string()), "{error}");
}

#[test]
fn an_empty_file_and_a_container_are_told_apart_on_disk() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.rad");
    std::fs::write(&path, b"").expect("written");
    assert_says(Container::open(&path), &["it is empty"]);
    minimal().write_file(&path).expect("written");
    assert_eq!(Container::open(&path).expect("a container").as_bytes(), minimal().to_bytes());
}

#[cfg(unix)]
#[test]
fn a_device_is_no_container_and_is_not_waited_for() {
    assert_says(Container::open(Path::new("/dev/zero")), &["/dev/zero", "is a pipe or a device"]);
}
