//! The bundled scenes are what their generators make, and small.

use allbounce_tests::{generated_assets, root};

#[test]
fn committed_scenes_are_what_the_generators_make() {
    for (path, text) in generated_assets() {
        let committed = std::fs::read_to_string(root().join(&path)).expect(&path);
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

#[test]
fn the_page_of_the_assets_counts_their_triangles_rightly() {
    let page = std::fs::read_to_string(root().join("assets/README.md")).expect("the page");
    for (path, text) in generated_assets().into_iter().filter(|(path, _)| path.ends_with(".obj")) {
        let faces = text.lines().filter(|line| line.starts_with("f "));
        let count: usize = faces.map(|face| face.split(' ').count() - 3).sum();
        let written = if count < 1000 { count.to_string() } else { format!("{},{:03}", count / 1000, count % 1000) };
        assert!(page.contains(&format!(" {written} triangles")), "{path} has {written} triangles");
    }
}
