//! The bundled scenes are what their generators make, and small.

use allbounce_tests::{generated_assets, root};

#[test]
fn committed_scenes_are_what_the_generators_make() {
    for (path, text) in generated_assets() {
        let committed = std::fs::read_to_string(root().join(path)).expect(path);
        assert!(
            committed == text,
            "{path} differs; run `cargo run --release -p allbounce-tests --example make_assets`"
        );
    }
}

#[test]
fn no_bundled_file_is_larger_than_two_mebibytes() {
    let mut folders = vec![root().join("assets")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("assets").flatten() {
            let kind = entry.metadata().expect("metadata");
            match kind.is_dir() {
                true => folders.push(entry.path()),
                false => assert!(kind.len() < 2 << 20, "{} has {} bytes", entry.path().display(), kind.len()),
            }
        }
    }
}
