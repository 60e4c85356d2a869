//! Which patches are kept, how many there are, and that points find them again.

mod common;

use common::{Build, at_voxel, furnished, simplify, v};
use glam::Vec3;
use radfile::{Patches, Quiet};
use scene::Scene;
use voxel_simplify::{Mode, Params, Report, Resolution, voxel_simplify};

fn wanted(patches: u32) -> Params {
    Params { resolution: Resolution::Patches(patches), ..Params::default() }
}

fn count(scene: &Scene, patches: u32) -> (Patches, Report) {
    let found = voxel_simplify(scene, &wanted(patches), &Quiet).expect("sound");
    found.0.check().expect("patches obey the format");
    found
}

#[test]
fn the_outside_of_a_room_is_dropped_and_the_inside_kept() {
    let mut build = Build::new();
    build.room(v(0.0, 0.0, 0.0), v(4.0, 3.0, 2.5), 0);
    let (patches, report) = simplify(&build.scene(), 0.5);
    let inside = 2.0 * (12.0 + 10.0 + 7.5);
    assert!((report.patch_area - inside).abs() < 1e-4 && (report.dropped_area - inside).abs() < 1e-4, "{report:?}");
    assert_eq!(report.patches, report.dropped);
    let centre = v(2.0, 1.5, 1.25);
    for p in 0..patches.len() {
        let inward = (centre - Vec3::from(patches.position[p])).dot(Vec3::from(patches.normal[p]));
        assert!(inward > 0.0, "patch {p} faces outwards");
    }
    let outer = patches.locator.patch_at(1, [1.0, 1.0, 0.0]);
    assert_eq!(outer, None, "a dropped face still names a patch");
}

#[test]
fn a_box_in_a_room_keeps_its_outside_and_its_inside() {
    let mut build = Build::new();
    build.room(v(0.0, 0.0, 0.0), v(4.0, 4.0, 4.0), 0);
    build.solid(v(1.5, 1.5, 1.5), v(2.5, 2.5, 2.5), 0);
    let (_, report) = simplify(&build.scene(), 0.5);
    // The room's inside 96 m², the box 6 m² outside and 6 m² inside: both sides can be seen.
    assert!((report.patch_area - 108.0).abs() < 1e-3, "{} m²", report.patch_area);
    assert!((report.dropped_area - 96.0).abs() < 1e-3, "{} m²", report.dropped_area);
}

/// A small square over a wide floor in free space. Hardly a ray of the floor's far patches meets the square, and yet
/// together they see a good part of its light.
#[test]
fn who_sees_little_of_a_small_thing_is_kept() {
    let mut build = Build::new();
    let flat = |low: Vec3, size: f32| [low, low + v(size, 0.0, 0.0), low + v(size, size, 0.0), low + v(0.0, size, 0.0)];
    build.quad(flat(v(-1.0, -1.0, 0.0), 2.0), 0);
    build.quad(flat(v(-0.125, -0.125, 0.5), 0.25), 0);
    let scene = build.scene();
    let centre = v(0.0, 0.0, 0.5);
    let received = |params: &Params| -> f32 {
        let (patches, _) = voxel_simplify(&scene, params, &Quiet).expect("sound");
        let floor = (0..patches.len()).filter(|&p| patches.position[p][2] < 0.25 && patches.normal[p][2] > 0.5);
        let kernel = |p: usize| {
            let way = Vec3::from(patches.position[p]) - centre;
            patches.area[p] * way.z * way.z / way.length_squared().powi(2)
        };
        floor.map(kernel).sum()
    };
    let kept = received(&at_voxel(0.25)) / received(&Params { visibility_rays: 0, ..at_voxel(0.25) });
    assert!(kept > 0.94, "the floor that is kept receives {kept} of the square's light");
}

#[test]
fn no_visibility_rays_keep_every_patch() {
    let params = Params { visibility_rays: 0, ..at_voxel(0.5) };
    let (_, report) = voxel_simplify(&furnished().scene(), &params, &Quiet).expect("sound");
    assert_eq!((report.dropped, report.rays), (0, 0));
}

#[test]
fn light_of_a_lamp_that_faces_away_from_everything_is_reported() {
    let mut build = Build::new();
    let lamp = build.material([0.0; 3], [2.0; 3]);
    build.room(v(0.0, 0.0, 0.0), v(2.0, 2.0, 2.0), 0);
    build.quad([v(0.5, 0.5, 3.0), v(1.5, 0.5, 3.0), v(1.5, 1.5, 3.0), v(0.5, 1.5, 3.0)], lamp);
    let (_, report) = simplify(&build.scene(), 0.5);
    assert!((report.dropped_flux[0] - 2.0 * std::f64::consts::PI).abs() < 1e-4, "{:?}", report.dropped_flux);
    assert!(report.warnings.iter().any(|w| w.contains("see nothing and were dropped")), "{:?}", report.warnings);
}

#[test]
fn as_many_patches_are_found_as_were_asked_for() {
    let mut cube = Build::new();
    cube.room(v(-1.0, -1.0, -1.0), v(1.0, 1.0, 1.0), 0);
    let mut ball = Build::new();
    ball.room(v(-2.0, -2.0, -2.0), v(2.0, 2.0, 2.0), 0);
    ball.ball(v(0.2, 0.1, 0.0), 1.0, 24, 0);
    let scenes = [("cube", cube), ("ball", ball), ("furnished", furnished()), ("tilted", furnished().tilted())];
    for (name, build) in scenes {
        let scene = build.scene();
        for patches in [150, 500, 1200, 3000] {
            let (_, report) = count(&scene, patches);
            let off = report.patches as f64 / f64::from(patches) - 1.0;
            assert!(off.abs() <= 0.1, "{name}: {} patches of {patches}, tried {:?}", report.patches, report.attempts);
            assert!(report.warnings.iter().all(|w| !w.contains("asked for")), "{name}: {:?}", report.warnings);
            assert!(report.area_error < 1e-6);
        }
    }
}

#[test]
fn a_count_that_cannot_be_met_is_said_to_be_so() {
    let (_, report) = count(&furnished().scene(), 3);
    assert!(report.patches > 3);
    let warning = report.warnings.iter().find(|w| w.starts_with("3 patches were asked for")).expect("a warning");
    assert!(warning.contains("separate parts and facings"), "{warning}");
    let mut cube = Build::new();
    cube.room(v(-1.0, -1.0, -1.0), v(1.0, 1.0, 1.0), 0);
    let (_, report) = count(&cube.scene(), 13);
    assert!(report.warnings.iter().any(|w| w.contains("jumps over")), "{report:?}");
}

#[test]
fn points_of_a_patch_find_it_again() {
    for scene in [furnished().scene(), furnished().tilted().scene()] {
        for voxel in [0.13, 0.4, 1.1] {
            let (patches, _) = simplify(&scene, voxel);
            let (mut asked, mut strangers, mut wrong) = (0, 0, 0);
            for patch in 0..patches.len() {
                for i in 0..64 {
                    let sample = scene::Sobol::new(patch as u32).sample(i);
                    let pieces = patches.pieces_of(patch);
                    let piece = &pieces[(sample[2] * pieces.len() as f32) as usize];
                    let (s, t) = scene::square_to_triangle(sample[0], sample[1]);
                    let [a, b, c] = piece.corners.map(Vec3::from);
                    let point = a + s * (b - a) + t * (c - a);
                    let found = patches.locator.patch_at(piece.face, point.to_array());
                    asked += 1;
                    wrong += u32::from(found != Some(patch as u32));
                    let same_face = |p: u32| patches.pieces_of(p as usize).iter().any(|q| q.face == piece.face);
                    strangers += u32::from(!found.is_some_and(same_face));
                }
            }
            assert_eq!(strangers, 0, "points that found a patch without a piece of their face");
            assert!(f64::from(wrong) <= 1e-4 * f64::from(asked), "{wrong} of {asked} points found another patch");
        }
    }
}

#[test]
fn sides_of_voxels_face_along_the_axes_and_lie_off_the_surface() {
    let scene = furnished().scene();
    let params = Params { mode: Mode::Faces, ..at_voxel(0.25) };
    let (patches, report) = voxel_simplify(&scene, &params, &Quiet).expect("sound");
    patches.check().expect("patches obey the format");
    assert!(patches.len() > 500);
    for p in 0..patches.len() {
        assert_eq!(patches.area[p], 0.0625);
        let normal = Vec3::from(patches.normal[p]);
        assert_eq!(normal.abs().element_sum(), 1.0);
        let sampler = scene::PatchSampler::new(&patches);
        assert!(sampler.point(p, 0.3, 0.6).normal.dot(normal) > 0.999, "pieces of patch {p} face elsewhere");
    }
    // The floor's own height is 0; the sides of its voxels stand above it, by less than a voxel.
    let above = scene.mesh.triangles.iter().position(|t| t.iter().all(|&i| scene.mesh.positions[i as usize][2] == 0.0));
    let face = 2 * above.expect("a floor") as u32;
    let patch = patches.locator.patch_at(face, [0.5, 0.5, 0.0]).expect("the floor has patches") as usize;
    assert!(patches.position[patch][2] > 0.0 && patches.position[patch][2] < 0.25, "{:?}", patches.position[patch]);
    assert!(report.warnings.iter().all(|w| !w.contains("asked")));
}

#[test]
fn sides_of_voxels_take_the_colour_of_what_faces_them() {
    let mut build = Build::new();
    let red = build.material([0.6, 0.0, 0.0], [0.0; 3]);
    build.room(v(0.0, 0.0, 0.0), v(2.0, 2.0, 2.0), red);
    let params = Params { mode: Mode::Faces, ..at_voxel(0.3) };
    let (patches, _) = voxel_simplify(&build.scene(), &params, &Quiet).expect("sound");
    for r in &patches.reflectance {
        assert!((r[0] - 0.6).abs() < 1e-6 && r[1] == 0.0 && r[2] == 0.0, "{r:?}");
    }
}
