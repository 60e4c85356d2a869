//! Finding the files that a scene names: paths of other systems, names in the wrong case.

use std::io::{Error, ErrorKind, Result};

use super::{Folder, notes::Notes};

const OTHER_CASE: &str = "files were found only under a name in another case";
const BY_NAME_ALONE: &str = "files were not where the scene says, and were found by their name alone";

/// The folder of the scene.
pub struct Files<'a> {
    folder: &'a dyn Folder,
}

impl<'a> Files<'a> {
    pub fn new(folder: &'a dyn Folder) -> Files<'a> {
        Files { folder }
    }

    /// Reads the file that a scene calls `name`, relative to the folder `base` (`""` or `sub/folder/`) of the file
    /// that names it. Tried in turn: there and in the scene's own folder, the bare file name in either, the same
    /// in another case.
    pub fn find(&self, base: &str, name: &str, notes: &mut Notes) -> Result<Vec<u8>> {
        let name = name.trim().replace('\\', "/");
        let path = name.trim_start_matches("./");
        let bare = path.rsplit('/').next().unwrap_or_default();
        if bare.is_empty() || path.contains('\0') {
            return Err(Error::new(ErrorKind::NotFound, "this is no file name"));
        }
        let said = match is_absolute(path) {
            true => vec![],
            false => vec![format!("{base}{path}"), path.to_owned()],
        };
        let guessed = [format!("{base}{bare}"), bare.to_owned()];
        if let Some(bytes) = said.iter().find_map(|p| self.folder.read(p).ok()) {
            return Ok(bytes);
        }
        if let Some(bytes) = guessed.iter().find_map(|p| self.folder.read(p).ok()) {
            notes.name(BY_NAME_ALONE, &name);
            return Ok(bytes);
        }
        let mut others = said.iter().chain(&guessed).filter_map(|p| self.other_case(p));
        if let Some(bytes) = others.find_map(|p| self.folder.read(&p).ok()) {
            notes.name(OTHER_CASE, &name);
            return Ok(bytes);
        }
        // Asked once more for the reason, which is worth more than "not found" where the file is there.
        self.folder.read(said.first().unwrap_or(&guessed[0]))
    }

    /// The path that equals `path` but for the case of ASCII letters, if there is one.
    fn other_case(&self, path: &str) -> Option<String> {
        let mut found = String::new();
        for part in path.split('/') {
            let here = self.folder.list(found.trim_end_matches('/'));
            let exact = part == ".." || part == "." || here.iter().any(|n| n == part);
            let name = if exact { part } else { here.iter().filter(|n| n.eq_ignore_ascii_case(part)).min()? };
            found = if found.is_empty() { name.to_owned() } else { format!("{found}/{name}") };
        }
        (found != path).then_some(found)
    }
}

/// Whether a path starts at a root, of this or another system. Such paths belong to the machine that wrote the
/// scene, and following them would let a scene name any file of this one.
fn is_absolute(path: &str) -> bool {
    path.starts_with('/') || path.as_bytes().get(1) == Some(&b':')
}

/// Folder part of a path, with its `/`; `""` if there is none.
pub fn folder_of(path: &str) -> &str {
    path.rfind(['/', '\\']).map(|at| &path[..=at]).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Few(&'static [&'static str]);

    impl Folder for Few {
        fn read(&self, name: &str) -> Result<Vec<u8>> {
            self.0.contains(&name).then(|| name.as_bytes().to_vec()).ok_or(ErrorKind::NotFound.into())
        }

        fn list(&self, folder: &str) -> Vec<String> {
            let prefix = if folder.is_empty() { String::new() } else { format!("{folder}/") };
            let inside = self.0.iter().filter_map(|n| n.strip_prefix(prefix.as_str()));
            inside.map(|n| n.split('/').next().unwrap().to_owned()).collect()
        }
    }

    const FEW: Few = Few(&["a.png", "Maps/Sky.JPG", "lib/b.png"]);

    fn find(base: &str, name: &str) -> (Option<String>, Vec<String>) {
        let mut notes = Notes::default();
        let found = Files::new(&FEW).find(base, name, &mut notes).ok();
        (found.map(|b| String::from_utf8(b).unwrap()), notes.into_warnings())
    }

    #[test]
    fn files_are_found_where_the_scene_says_without_a_word() {
        assert_eq!(find("", "a.png"), (Some("a.png".into()), vec![]));
        assert_eq!(find("lib/", "b.png"), (Some("lib/b.png".into()), vec![]));
        assert_eq!(find("lib/", "a.png"), (Some("a.png".into()), vec![]));
        assert_eq!(find("", r".\Maps\Sky.JPG"), (Some("Maps/Sky.JPG".into()), vec![]));
    }

    #[test]
    fn the_wrong_case_of_any_part_is_forgiven_and_reported() {
        let (found, said) = find("", "maps/SKY.jpg");
        assert_eq!(found.as_deref(), Some("Maps/Sky.JPG"));
        assert_eq!(said, ["files were found only under a name in another case: maps/SKY.jpg"]);
    }

    #[test]
    fn paths_of_another_machine_are_tried_by_their_name_alone() {
        for name in [r"C:\art\a.png", "/home/someone/a.png", "textures/a.png"] {
            let (found, said) = find("", name);
            assert_eq!(found.as_deref(), Some("a.png"), "{name}");
            assert_eq!(said.len(), 1, "{name}");
            assert!(said[0].starts_with(BY_NAME_ALONE), "{said:?}");
        }
    }

    #[test]
    fn what_is_not_there_is_an_error() {
        for name in ["b.jpg", "", "/", "..", "maps/", "a\0.png"] {
            assert_eq!(find("", name), (None, vec![]), "{name:?}");
        }
    }
}
