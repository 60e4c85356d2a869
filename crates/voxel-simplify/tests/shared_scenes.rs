//! The scenes that developers share: counts, conservation and cost.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use radfile::Quiet;
use scene::{Folder, ImportOptions, Scene, import};
use voxel_simplify::{Params, Resolution, voxel_simplify};

struct Disk(PathBuf);

impl Folder for Disk {
    fn read(&self, name: &str) -> std::io::Result<Vec<u8>> {
        std::fs::read(self.0.join(name))
    }

    fn list(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.join(folder)).into_iter().flatten().flatten();
        entries.filter_map(|e| e.file_name().into_string().ok()).collect()
    }
}

fn shared(name: &str) -> Option<Scene> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes").join(name);
    if !path.exists() {
        // Not eprintln!, whose lines are swallowed when a test passes.
        writeln!(std::io::stderr(), "skipped: the reference data {name} is not beside this checkout")
            .expect("standard error");
        return None;
    }
    let folder = Disk(path.parent().expect("in a folder").to_owned());
    let file = path.file_name().and_then(|n| n.to_str()).expect("a name");
    Some(import(file, &folder, ImportOptions::default()).expect("a sound scene").0)
}

fn check(name: &str, wanted: u32) {
    let Some(scene) = shared(name) else { return };
    let params = Params { resolution: Resolution::Patches(wanted), ..Params::default() };
    let start = std::time::Instant::now();
    let (patches, report) = voxel_simplify(&scene, &params, &Quiet).expect("a room");
    eprintln!(
        "{name}: {} patches of {} m in {:.2} s, {} attempts, dropped {}, gathered {}",
        report.patches,
        report.voxel,
        start.elapsed().as_secs_f64(),
        report.attempts.len(),
        report.dropped,
        report.gathered
    );
    patches.check().expect("patches obey the format");
    let off = report.patches as f64 / f64::from(wanted) - 1.0;
    assert!(off.abs() <= 0.1, "{name}: {} patches of {wanted}", report.patches);
    // Areas are stored in f32.
    assert!(report.area_error < 1e-5, "{name}: area is off by {}", report.area_error);
    for c in 0..3 {
        let flux = report.patch_flux[c] + report.dropped_flux[c];
        assert!((flux - report.scene_flux[c]).abs() <= 1e-5 * report.scene_flux[c], "{name}: {:?}", report.patch_flux);
    }
}

#[test]
fn the_cornell_box_gives_2500_patches() {
    check("cornell_box/cornell_box.glb", 2500);
}

#[test]
fn sponza_gives_3000_patches() {
    check("sponza/sponza.glb", 3000);
}

#[test]
fn rooms_and_furnace_give_as_many_patches_as_asked_for() {
    check("rooms/rooms.glb", 2000);
    check("rooms/corridor.glb", 1000);
    check("furnace/furnace_50.glb", 700);
}

/// The wall between rooms 2 and 3 is 15 cm thick; no patch may reach through it at any size.
#[test]
fn no_patch_reaches_into_the_sealed_room() {
    let Some(scene) = shared("rooms/rooms.glb") else { return };
    for voxel in [0.3, 1.0, 5.0] {
        let params = Params { resolution: Resolution::Voxel(voxel), ..Params::default() };
        let (patches, _) = voxel_simplify(&scene, &params, &Quiet).expect("a room");
        for patch in 0..patches.len() {
            let z = || patches.pieces_of(patch).iter().flat_map(|p| p.corners).map(|c| c[2]);
            let (low, high) = (z().fold(f32::INFINITY, f32::min), z().fold(f32::NEG_INFINITY, f32::max));
            assert!(!(low < -11.25 && high > -11.15), "patch {patch} reaches from z = {low} to {high}");
        }
    }
}
