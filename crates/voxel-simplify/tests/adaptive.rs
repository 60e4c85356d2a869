//! Adaptive patches: as many as wanted, where light changes, never through a wall.

mod common;

use common::{Build, at_voxel, furnished, v};
use glam::Vec3;
use radfile::{Builder, Container, Operator, Patches, Piece, Quiet, Record, face_id};
use scene::{PatchSampler, Rays, Scene, Sobol, cosine_direction, hash};
use voxel_simplify::{Error, Mode, Params, Pilot, Report, Resolution, adaptive, voxel_simplify};

fn wanted(patches: u32) -> Params {
    Params { resolution: Resolution::Patches(patches), ..Params::default() }
}

/// K of a few bounces by rays: rough, but light goes where it can and nowhere else.
fn operator(scene: &Scene, patches: &Patches) -> Operator<'static> {
    const RAYS: u32 = 256;
    let n = patches.len();
    let (rays, sampler) = (Rays::new(&scene.mesh), PatchSampler::new(patches));
    let mut exchange = vec![0.0f32; n * n];
    for i in 0..n {
        let sobol = Sobol::new(hash(3, i as u32));
        for k in 0..RAYS {
            let [x, y, z, w] = sobol.sample(k);
            let point = sampler.point(i, x, y);
            let (origin, direction) =
                (rays.off_surface(point.position, point.normal), cosine_direction(point.normal, z, w));
            let Some(hit) = rays.closest(origin, direction, f32::INFINITY, point.triangle) else { continue };
            let place = (origin + hit.t * direction).to_array();
            if let Some(j) = patches.locator.patch_at(face_id(hit.triangle, hit.side), place) {
                exchange[i * n + j as usize] += 0.5 * patches.area[i] / RAYS as f32;
                exchange[j as usize * n + i] += 0.5 * patches.area[i] / RAYS as f32;
            }
        }
    }
    let root: Vec<f32> = patches.area.iter().map(|a| a.sqrt()).collect();
    let w: Vec<f32> = (0..n * n).map(|at| exchange[at] / (root[at / n] * root[at % n])).collect();
    let mut values = w.clone();
    for _ in 0..3 {
        let product = |at: usize| (0..n).map(|k| w[at / n * n + k] * 0.5 * values[k * n + at % n]).sum::<f32>();
        values = (0..n * n).map(|at| w[at] + product(at)).collect();
    }
    Operator { n, channels: 1, bounces: None, values: values.into() }
}

/// A container with the scene, patches of this voxel size and, if wanted, their operator.
fn container(
    scene: &Scene,
    voxel: f32,
    change: impl FnOnce(Operator<'static>) -> Option<Operator<'static>>,
) -> Container {
    let (patches, _) = voxel_simplify(scene, &at_voxel(voxel), &Quiet).expect("sound");
    let operator = change(operator(scene, &patches));
    let mut builder = Builder::new();
    scene.write(&mut builder);
    patches.write(&mut builder);
    operator.iter().for_each(|o| o.write(&mut builder));
    builder.finish().expect("sections fit")
}

fn adapted(scene: &Scene, pilot: &Container, patches: u32) -> (Patches, Report) {
    let pilot = Pilot::read(pilot).expect("a pilot");
    let found = adaptive(scene, &wanted(patches), &pilot, &Quiet).expect("sound");
    found.0.check().expect("patches obey the format");
    found
}

/// Points on a patch.
fn points(sampler: &PatchSampler, patch: usize, count: u32) -> impl Iterator<Item = scene::SurfacePoint> {
    let sobol = Sobol::new(hash(9, patch as u32));
    (0..count).map(move |k| {
        let [x, y, ..] = sobol.sample(k);
        sampler.point(patch, x, y)
    })
}

#[test]
fn the_number_is_met_and_area_and_lookups_are_kept() {
    let scene = furnished().scene();
    let pilot = container(&scene, 0.8, Some);
    for count in [120, 300] {
        let (patches, report) = adapted(&scene, &pilot, count);
        assert_eq!(patches.len(), count as usize);
        assert!(report.area_error < 1e-6, "{}", report.area_error);
        assert!((report.patch_flux[0] - report.scene_flux[0]).abs() < 1e-3 * report.scene_flux[0], "{report:?}");
        let centre = |p: &Piece| p.corners.map(Vec3::from).iter().sum::<Vec3>() / 3.0;
        for patch in 0..patches.len() {
            for piece in patches.pieces_of(patch) {
                let found = patches.locator.patch_at(piece.face, centre(piece).to_array());
                assert_eq!(found, Some(patch as u32), "a piece at {}", centre(piece));
            }
        }
        let levels: usize = report.adaptive.expect("adaptive").levels.iter().map(|l| l.patches).sum();
        assert_eq!(levels, count as usize);
    }
}

/// Squares too far apart and too small to be cut or joined by anybody.
fn flakes() -> Build {
    let mut build = Build::new();
    for k in 0..40u32 {
        let [x, y, z, _] = Sobol::new(7).sample(k);
        let low = 10.0 * v(x, y, z);
        let [a, b] = [v(0.2, 0.0, 0.0), v(0.0, 0.14, 0.14)];
        build.quad([low, low + a, low + a + b, low + b], 0);
    }
    build
}

#[test]
fn without_joining_the_patches_are_those_of_uniform_voxels() {
    let scene = flakes().scene();
    let keep_all = |resolution| Params { resolution, visibility_rays: 0, ..Params::default() };
    let pilot = container(&scene, 20.0, Some);
    let pilot = Pilot::read(&pilot).expect("a pilot");
    // More than there are fine patches, so none is joined.
    let (patches, report) = adaptive(&scene, &keep_all(Resolution::Patches(300)), &pilot, &Quiet).expect("sound");
    assert!(report.patches < 300 && report.adaptive.is_some_and(|a| a.fine_patches == report.patches));
    let (uniform, _) = voxel_simplify(&scene, &keep_all(Resolution::Voxel(report.voxel)), &Quiet).expect("sound");
    assert_eq!(patches, uniform);
    assert!(report.warnings.iter().any(|w| w.contains("300 patches were asked for")), "{:?}", report.warnings);
}

#[test]
fn the_same_for_any_number_of_threads() {
    let scene = furnished().scene();
    let pilot = container(&scene, 0.8, Some);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| adapted(&scene, &pilot, 150))
    };
    assert_eq!(with(1), with(3));
}

/// Two rooms on one floor, a single sheet between them. Patches may get as large as they like, but none is in both rooms.
#[test]
fn no_patch_passes_a_wall() {
    for (wall, count) in [(1.9, 30), (2.0, 60), (2.137, 200)] {
        let mut build = Build::new();
        build.room(v(0.0, 0.0, 0.0), v(4.0, 3.0, 2.5), 0);
        build.quad([v(wall, 0.0, 0.0), v(wall, 3.0, 0.0), v(wall, 3.0, 2.5), v(wall, 0.0, 2.5)], 0);
        let scene = build.scene();
        let pilot = container(&scene, 0.7, Some);
        let (patches, _) = adapted(&scene, &pilot, count);
        let sampler = PatchSampler::new(&patches);
        for patch in 0..patches.len() {
            // On the sheet itself the side tells the room.
            let room = |p: scene::SurfacePoint| (p.position + 0.01 * p.normal).x > wall;
            let rooms: Vec<bool> = points(&sampler, patch, 64).map(room).collect();
            let right = rooms.iter().filter(|&&r| r).count();
            assert!(right == 0 || right == 64, "patch {patch} of {count} is {right}/64 beyond the wall at {wall}");
        }
    }
}

/// A kerb along a wide floor. What the floor receives from it falls off within its height: with distance x from a long
/// wall of height h and radiosity 1 it is (1 − x / √(x² + h²)) / 2.
#[test]
fn patches_go_where_light_changes() {
    const HEIGHT: f32 = 0.25;
    let mut build = Build::new();
    build.quad([v(0.0, 0.0, 0.0), v(4.0, 0.0, 0.0), v(4.0, 4.0, 0.0), v(0.0, 4.0, 0.0)], 0);
    build.quad([v(0.0, 0.0, 0.0), v(0.0, 4.0, 0.0), v(0.0, 4.0, HEIGHT), v(0.0, 0.0, HEIGHT)], 0);
    let scene = build.scene();
    let light = |x: f32| f64::from(0.5 * (1.0 - x / (x * x + HEIGHT * HEIGHT).sqrt()));
    let error = |patches: &Patches| {
        let sampler = PatchSampler::new(patches);
        let floor = (0..patches.len()).filter(|&p| patches.normal[p][2] > 0.9);
        let [mut lost, mut whole] = [0.0; 2];
        for patch in floor {
            let values: Vec<f64> = points(&sampler, patch, 256).map(|p| light(p.position.x)).collect();
            let mean = values.iter().sum::<f64>() / 256.0;
            let area = f64::from(patches.area[patch]) / 256.0;
            lost += area * values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
            whole += area * values.iter().map(|v| v * v).sum::<f64>();
        }
        (lost / whole).sqrt()
    };
    let pilot = container(&scene, 0.5, Some);
    let (patches, report) = adapted(&scene, &pilot, 150);
    let (uniform, _) = voxel_simplify(&scene, &wanted(150), &Quiet).expect("sound");
    let (ours, theirs) = (error(&patches), error(&uniform));
    assert!(ours < 0.85 * theirs, "{} patches: {ours}, {} uniform: {theirs}", patches.len(), uniform.len());
    for row in report.adaptive.expect("adaptive").expected {
        assert!(row.uniform.is_none_or(|uniform| row.adaptive < uniform), "{row:?}");
    }
}

#[test]
fn pilots_that_do_not_fit_are_refused() {
    let scene = furnished().scene();
    let unread = |voxel: f32, change: fn(Operator<'static>) -> Option<Operator<'static>>| {
        Pilot::read(&container(&scene, voxel, change)).map(drop).expect_err("a broken pilot")
    };
    assert!(matches!(unread(0.8, |_| None), Error::PilotUnsolved));
    let cut = |o: Operator<'static>| Some(Operator { bounces: Some(2), ..o });
    assert!(matches!(unread(0.8, cut), Error::PilotBounces { bounces: 2 }));

    let pilot = container(&scene, 0.8, Some);
    let pilot = Pilot::read(&pilot).expect("a pilot");
    let refused = |scene: &Scene, params: &Params| adaptive(scene, params, &pilot, &Quiet).expect_err("no patches");
    let mut other = furnished();
    other.mesh.positions[3][1] += 0.001;
    assert!(matches!(refused(&other.scene(), &wanted(100)), Error::PilotOfAnother { .. }));
    let mut one_sided = furnished().scene();
    one_sided.mesh.one_sided = true;
    assert!(matches!(refused(&one_sided, &wanted(100)), Error::PilotOfAnother { .. }));
    assert!(matches!(refused(&scene, &at_voxel(0.5)), Error::NotAdaptive));
    assert!(matches!(refused(&scene, &Params { mode: Mode::Faces, ..wanted(100) }), Error::NotAdaptive));
    assert!(matches!(refused(&scene, &wanted(0)), Error::NoPatchesWanted));
}

#[test]
fn a_scene_of_few_patches_is_no_pilot() {
    let mut build = Build::new();
    build.room(v(0.0, 0.0, 0.0), v(4.0, 3.0, 2.5), 0);
    let pilot = container(&build.scene(), 20.0, Some);
    assert!(matches!(Pilot::read(&pilot).map(drop), Err(Error::PilotTooSmall { found: 6, .. })));
}
