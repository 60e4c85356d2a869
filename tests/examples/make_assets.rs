//! Writes the bundled scenes. A test holds the committed files to what this writes.

fn main() -> std::io::Result<()> {
    for (path, text) in allbounce_tests::generated_assets() {
        std::fs::write(allbounce_tests::root().join(path), text)?;
        println!("{path}");
    }
    Ok(())
}
