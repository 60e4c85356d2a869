//! Containers that the stage reads, and the stage run in memory.
#![allow(dead_code, reason = "every test file uses a part of it")]

use radfile::{Builder, Container, Material, Materials, Mesh, Patches, Quiet, Record, Step};
use scene::Scene;
use transfer::{Error, Params, Report, run};

/// One grey material for the mesh.
pub fn grey(mesh: Mesh) -> Scene {
    let material = Material {
        name: "grey".into(),
        reflectance: [0.5; 3],
        reflectance_texture: None,
        emission: [0.0; 3],
        emission_texture: None,
    };
    Scene { mesh, materials: Materials { materials: vec![material], textures: vec![] }, ..Scene::default() }
}

/// What stages before this one leave of a grey scene.
pub fn container((mesh, patches): (Mesh, Patches)) -> Container {
    let scene = grey(mesh);
    let mut builder = Builder::new();
    scene.write(&mut builder);
    patches.write(&mut builder);
    builder.finish().expect("legal")
}

/// Runs the stage on a container.
pub fn again(input: &Container, params: &Params) -> Result<(Container, Report), Error> {
    let step = Step { stage: "transfer".into(), version: "0".into(), options: String::new(), inputs: vec![] };
    let mut made = None;
    let report = run(input, params, step, &Quiet, &mut |b| {
        made = Some(b.finish()?);
        Ok(())
    })?;
    Ok((made.expect("the sink was called"), report))
}
