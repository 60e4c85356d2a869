//! A folder on disk, for the tests and examples of all crates: libraries touch no files, so `scene` offers none.

use std::path::PathBuf;

use scene::Folder;

/// A folder, by its path.
pub struct Disk(pub PathBuf);

impl Folder for Disk {
    fn read(&self, name: &str) -> std::io::Result<Vec<u8>> {
        std::fs::read(self.0.join(name))
    }

    fn list(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.join(folder)).into_iter().flatten().flatten();
        entries.filter_map(|e| e.file_name().into_string().ok()).collect()
    }
}
