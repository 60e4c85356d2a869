//! Writes the bundled scenes. A test holds the committed files to what this writes.

fn main() -> std::io::Result<()> {
    for (path, text) in allbounce_tests::generated_assets() {
        let file = allbounce_tests::root().join(&path);
        std::fs::create_dir_all(file.parent().expect("a folder"))?;
        std::fs::write(file, text)?;
        println!("{path}");
    }
    Ok(())
}
