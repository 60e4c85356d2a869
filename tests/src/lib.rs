//! What the whole-pipeline tests share: the program under test, rooms to put it in, reference points,
//! the generators of the bundled scenes, and the stability laboratory.

pub mod apartment;
pub mod bench;
pub mod charts;
pub mod cornell;
pub mod leaks;
pub mod mesh_text;
pub mod patch_light;
pub mod program;
pub mod reference;
pub mod shapes;
pub mod workbench;

use std::{
    io::Write,
    path::{Path, PathBuf},
};

/// Root of the workspace.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ lies in the workspace").to_owned()
}

/// A bundled file as an argument of the program.
pub fn asset(path: &str) -> String {
    text(&root().join("assets").join(path))
}

/// A path as an argument of the program.
pub fn text(path: &Path) -> String {
    path.to_str().expect("UTF-8").to_owned()
}

/// A file of `tests/data`.
pub fn data(name: &str) -> serde_json::Value {
    let text = std::fs::read_to_string(root().join("tests/data").join(name)).expect(name);
    serde_json::from_str(&text).expect("JSON")
}

/// Says that a test is skipped, past the capture of passing tests' output, which swallows what `println!` prints.
pub fn skipped(reason: &str) {
    writeln!(std::io::stderr(), "skipped: {reason}").expect("standard error");
}

/// Every bundled file that is generated: path below the root, contents.
pub fn generated_assets() -> Vec<(String, String)> {
    let room = |folder: &str, mesh: &mesh_text::MeshText| {
        let name = folder.rsplit('/').next().expect("a name");
        [
            (format!("assets/{folder}/{name}.obj"), mesh.obj(&format!("{name}.mtl"))),
            (format!("assets/{folder}/{name}.mtl"), mesh.mtl()),
        ]
    };
    let mut files = [room("cornell", &cornell::scene()), room("apartment", &apartment::scene())].concat();
    for (name, scene, camera) in leaks::sections() {
        let folder = format!("leaks/{name}");
        files.extend(room(&folder, &scene.mesh()));
        files.push((format!("assets/{folder}/lamp.json"), format!("{:#}\n", scene.lights())));
        files.push((format!("assets/{folder}/camera.json"), format!("{camera:#}\n")));
    }
    files
}
