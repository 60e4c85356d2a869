//! Files: reading whole texts, writing by way of a temporary file, folders of scenes.

use std::path::{Path, PathBuf};

use anyhow::Context;
use radfile::Container;

/// Opens a container; the message names the file.
pub fn open(path: &Path) -> anyhow::Result<Container> {
    Container::open(path).map_err(|error| named(path, error))
}

/// Puts the file's name before an error that does not have it.
fn named(path: &Path, error: radfile::Error) -> anyhow::Error {
    match error {
        radfile::Error::Io { .. } => error.into(),
        other => anyhow::Error::new(other).context(path.display().to_string()),
    }
}

/// Reads a text file.
pub fn text(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path).with_context(|| path.display().to_string())
}

/// Writes a file completely or not at all.
pub fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_with(path, |file| std::io::Write::write_all(file, bytes).map_err(Into::into))
}

/// Lets `fill` write a temporary file beside `path` and renames it.
pub fn write_with(path: &Path, fill: impl FnOnce(&mut std::fs::File) -> anyhow::Result<()>) -> anyhow::Result<()> {
    let name = || path.display().to_string();
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder).with_context(name)?;
    fill(file.as_file_mut()).with_context(name)?;
    readable(file.as_file()).with_context(name)?;
    file.persist(path).map_err(|e| e.error).with_context(name)?;
    Ok(())
}

#[cfg(unix)]
fn readable(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable(_file: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}

/// The folder that a scene file lies in.
pub struct DiskFolder(PathBuf);

impl DiskFolder {
    /// Folder and file name of a scene.
    pub fn of(scene: &Path) -> anyhow::Result<(DiskFolder, String)> {
        let name = scene
            .file_name()
            .and_then(|n| n.to_str())
            .with_context(|| format!("{}: expected the path of a scene file (.obj, .gltf, .glb)", scene.display()))?;
        let folder = scene.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Ok((DiskFolder(folder.to_owned()), name.to_owned()))
    }
}

impl scene::Folder for DiskFolder {
    fn read(&self, name: &str) -> std::io::Result<Vec<u8>> {
        let path = self.0.join(name);
        if !std::fs::metadata(&path)?.is_file() {
            return Err(std::io::Error::other("is no regular file")); // a device might never end
        }
        std::fs::read(path)
    }

    fn list(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.join(folder)).into_iter().flatten().flatten();
        let mut names: Vec<String> = entries.filter_map(|e| e.file_name().into_string().ok()).collect();
        names.sort();
        names
    }
}
