//! Files: reading whole texts, writing by way of a temporary file, folders of scenes.

use std::{
    cell::RefCell,
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::{Context, anyhow, bail};
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
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        anyhow!("{}: byte {at} is not UTF-8 text; save the file as UTF-8", path.display())
    })
}

/// Refuses outputs that could not be written or would destroy what they are made from, before any work is done.
///
/// `outputs` and `inputs` are options as people know them, with the path given for each.
pub fn check_outputs(outputs: &[(&str, &Path)], inputs: &[(&str, &Path)]) -> anyhow::Result<()> {
    for (number, (option, path)) in outputs.iter().enumerate() {
        let folder = folder_of(path);
        if !folder.is_dir() {
            let missing = std::io::Error::from(std::io::ErrorKind::NotFound);
            let what = format!("{}: the folder {} does not exist; create it first", path.display(), folder.display());
            return Err(anyhow::Error::new(missing).context(what));
        }
        if path.exists() && !path.is_file() {
            bail!("{}: {option} names a folder or device, expected a file", path.display());
        }
        for (other, input) in inputs.iter().chain(&outputs[..number]) {
            if same_file(path, input) {
                bail!("{}: {option} would overwrite {other}; choose another name", path.display());
            }
        }
    }
    Ok(())
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Whether two paths name one file, which need not exist yet.
fn same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| Some((folder_of(path).canonicalize().ok()?, path.file_name()?.to_owned()));
    let whole = |path: &Path| path.canonicalize().ok();
    place(a).is_some_and(|p| Some(p) == place(b)) || whole(a).is_some_and(|p| Some(p) == whole(b))
}

/// Writes a file completely or not at all, by way of a temporary file that is renamed.
pub fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let name = || path.display().to_string();
    let mut file = tempfile::NamedTempFile::new_in(folder_of(path)).with_context(name)?;
    file.write_all(bytes).with_context(name)?;
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

/// Writes to standard output; a reader that has gone away is no error.
pub fn print(text: &str) -> anyhow::Result<()> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        other => other.context("standard output"),
    }
}

/// The folder that a scene file lies in; remembers what was read from it.
pub struct DiskFolder {
    folder: PathBuf,
    /// Name and digest of every file that was read, in order.
    read: RefCell<Vec<(String, String)>>,
}

impl DiskFolder {
    /// Folder and file name of a scene.
    pub fn of(scene: &Path) -> anyhow::Result<(DiskFolder, String)> {
        let name = scene
            .file_name()
            .and_then(|n| n.to_str())
            .with_context(|| format!("{}: expected the path of a scene file (.obj, .gltf, .glb)", scene.display()))?;
        let folder = DiskFolder { folder: folder_of(scene).to_owned(), read: RefCell::default() };
        Ok((folder, name.to_owned()))
    }

    /// Name and digest of every file that was read, in order.
    pub fn inputs(self) -> Vec<(String, String)> {
        self.read.into_inner()
    }
}

impl scene::Folder for DiskFolder {
    fn read(&self, name: &str) -> std::io::Result<Vec<u8>> {
        let path = self.folder.join(name);
        if !std::fs::metadata(&path)?.is_file() {
            return Err(std::io::Error::other("is no regular file")); // a device might never end
        }
        let bytes = std::fs::read(path)?;
        self.read.borrow_mut().push((name.to_owned(), radfile::digest(&bytes)));
        Ok(bytes)
    }

    fn list(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.join(folder)).into_iter().flatten().flatten();
        let mut names: Vec<String> = entries.filter_map(|e| e.file_name().into_string().ok()).collect();
        names.sort();
        names
    }
}
