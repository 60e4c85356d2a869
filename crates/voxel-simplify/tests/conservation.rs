//! Cutting and grouping lose neither surface nor light, and colours are those of the surface.

mod common;

use std::f64::consts::PI;

use common::{Build, at_voxel, furnished, simplify, v};
use radfile::{Quiet, Texture, Wrap};
use scene::Scene;
use voxel_simplify::{Params, voxel_simplify};

/// f64 clipping loses nothing; areas are stored in f32, each to 6e-8, so the sum holds to 1e-6.
const TOLERANCE: f64 = 1e-6;

#[test]
fn every_square_metre_is_in_a_patch_at_any_voxel_size() {
    for scene in [furnished().scene(), furnished().tilted().scene()] {
        let whole: f64 = (0..scene.mesh.triangles.len()).map(|t| 2.0 * area(&scene, t)).sum();
        for voxel in [0.07, 0.25, 0.5, 1.3, 20.0] {
            let (patches, report) = simplify(&scene, voxel);
            assert!((report.scene_area / whole - 1.0).abs() < TOLERANCE, "{} m², expected {whole}", report.scene_area);
            assert!(report.area_error < TOLERANCE, "voxel {voxel}: {}", report.area_error);
            let pieces: f64 = patches.pieces.iter().map(|p| triangle_area(p.corners)).sum();
            // Corners of pieces are rounded to f32: 2e-7 m on pieces of centimetres.
            assert!(
                (pieces / report.patch_area - 1.0).abs() < 1e-5,
                "pieces hold {pieces} m² of {}",
                report.patch_area
            );
        }
    }
}

#[test]
fn every_piece_lies_in_the_cells_of_its_patch_and_faces_its_side() {
    let scene = furnished().tilted().scene();
    let (patches, _) = simplify(&scene, 0.3);
    for patch in 0..patches.len() {
        let normal = glam::Vec3::from(patches.normal[patch]);
        for piece in patches.pieces_of(patch) {
            let [a, b, c] = piece.corners.map(glam::Vec3::from);
            let front = (b - a).cross(c - a).normalize();
            let facing = if piece.face % 2 == 0 { front } else { -front };
            // Sheets grow within 35° of a mean, small ones join within 50°.
            assert!(facing.dot(normal) > 0.5, "patch {patch} has a piece that faces {facing}, the patch {normal}");
        }
        let spread = patches.pieces_of(patch).iter().flat_map(|p| p.corners.map(glam::Vec3::from));
        let spread = spread.fold(0.0f32, |far, p| far.max(p.distance(glam::Vec3::from(patches.position[patch]))));
        assert!(spread < 2.5 * 0.3 * 3f32.sqrt(), "patch {patch} reaches {spread} m");
    }
}

#[test]
fn the_position_of_a_patch_lies_on_one_of_its_pieces() {
    let scene = furnished().scene();
    let (patches, _) = simplify(&scene, 0.6);
    for patch in 0..patches.len() {
        let p = glam::Vec3::from(patches.position[patch]).as_dvec3();
        let off = patches.pieces_of(patch).iter().map(|piece| {
            let [a, b, c] = piece.corners.map(|c| glam::Vec3::from(c).as_dvec3());
            // A point of a triangle splits it into three that hold the same area.
            let parts = (a - p).cross(b - p).length() + (b - p).cross(c - p).length() + (c - p).cross(a - p).length();
            parts - (b - a).cross(c - a).length()
        });
        let least = off.fold(f64::INFINITY, f64::min);
        assert!(least < 1e-6, "patch {patch} at {p} is off its pieces by {least} m²");
    }
}

#[test]
fn emitted_flux_is_kept_and_leaves_the_front_only() {
    for voxel in [0.1, 0.35, 1.0, 9.0] {
        let (patches, report) = simplify(&furnished().scene(), voxel);
        // One square decimetre short of nothing: the panel is 1.0 × 0.6 m, exitance is π times radiance.
        for (c, radiance) in [5.0, 4.0, 3.0].into_iter().enumerate() {
            let expected = 0.6 * PI * radiance;
            assert!((report.scene_flux[c] / expected - 1.0).abs() < 1e-5, "{:?}", report.scene_flux);
            assert!((report.patch_flux[c] / expected - 1.0).abs() < 1e-5, "voxel {voxel}: {:?}", report.patch_flux);
        }
        assert_eq!(report.dropped_flux, [0.0; 3]);
        for patch in (0..patches.len()).filter(|&p| patches.emission[p][0] > 0.0) {
            assert!(patches.normal[patch][2] < -0.99, "light leaves towards {:?}", patches.normal[patch]);
        }
    }
}

#[test]
fn a_lamp_does_not_spread_over_the_ceiling_that_it_is_set_in() {
    let mut build = Build::new();
    let lamp = build.material([0.0; 3], [1.0; 3]);
    build.room(v(0.0, 0.0, 0.0), v(2.0, 2.0, 2.0), 0);
    let ceiling = [(0.0, 0.9, 0), (0.9, 1.1, lamp), (1.1, 2.0, 0)];
    for (low, high, material) in ceiling {
        build.quad([v(low, 0.0, 1.9), v(low, 2.0, 1.9), v(high, 2.0, 1.9), v(high, 0.0, 1.9)], material);
    }
    let (patches, _) = simplify(&build.scene(), 0.7);
    for emission in &patches.emission {
        let pi = std::f32::consts::PI;
        assert!(emission[0] == 0.0 || (emission[0] - pi).abs() < 1e-5, "{emission:?} is neither lamp nor ceiling");
    }
}

#[test]
fn reflectance_is_the_mean_of_the_texels_under_a_patch() {
    let scene = two_coloured();
    let (patches, _) = simplify(&scene, 0.5);
    let floor: Vec<usize> =
        (0..patches.len()).filter(|&p| patches.normal[p][2] > 0.9 && patches.position[p][2] < 0.1).collect();
    let total: f64 = floor.iter().map(|&p| f64::from(patches.area[p])).sum();
    let mean: [f64; 3] = std::array::from_fn(|c| {
        floor.iter().map(|&p| f64::from(patches.area[p]) * f64::from(patches.reflectance[p][c])).sum::<f64>() / total
    });
    assert!((total - 4.0).abs() < 1e-5, "{total} m² of floor");
    // Half red, half blue. Only the column of patches over the border mixes them, from 64 points each: 1/64 of 1/5.
    assert!((mean[0] - 0.4).abs() < 0.005 && mean[1] == 0.0 && (mean[2] - 0.4).abs() < 0.005, "{mean:?}");
    let pure = floor.iter().filter(|&&p| patches.reflectance[p] == [0.8, 0.0, 0.0]).count();
    assert!(pure * 3 > floor.len(), "{pure} of {} patches are purely red", floor.len());
}

#[test]
fn the_mean_over_a_patch_does_not_depend_on_how_it_was_cut() {
    let scene = two_coloured();
    // One cell: the whole floor is one patch.
    let (patches, _) = simplify(&scene, 9.0);
    let floor = (0..patches.len()).find(|&p| patches.normal[p][2] > 0.9 && patches.area[p] == 4.0).expect("the floor");
    let [r, g, b] = patches.reflectance[floor];
    // 64 stratified points on two triangles that each hold both colours.
    assert!((r - 0.4).abs() < 0.03 && g == 0.0 && (b - 0.4).abs() < 0.03, "{:?}", patches.reflectance[floor]);
}

#[test]
fn another_seed_samples_other_texels_but_cuts_the_same_patches() {
    let scene = two_coloured();
    let other = Params { seed: 7, ..at_voxel(0.5) };
    let (a, _) = simplify(&scene, 0.5);
    let (b, _) = voxel_simplify(&scene, &other, &Quiet).expect("sound");
    assert_eq!(a.pieces, b.pieces);
    assert_ne!(a.reflectance, b.reflectance);
}

/// A 2 m room; the left half of the floor's texture is red, the right half blue.
fn two_coloured() -> Scene {
    let mut build = Build::new();
    let tiles = build.material([0.8; 3], [0.0; 3]);
    build.materials[tiles as usize].reflectance_texture = Some(0);
    build.room(v(0.0, 0.0, 0.0), v(2.0, 2.0, 2.0), 0);
    for triangle in 0..build.mesh.triangles.len() {
        if build.mesh.triangles[triangle].iter().all(|&i| build.mesh.positions[i as usize][2] == 0.0) {
            build.mesh.triangle_material[triangle] = tiles;
        }
    }
    build.mesh.uv = build.mesh.positions.iter().map(|p| [p[0] / 2.0, p[1] / 2.0]).collect();
    let image = image::RgbImage::from_fn(256, 4, |x, _| image::Rgb(if x < 128 { [255, 0, 0] } else { [0, 0, 255] }));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).expect("writing to memory");
    let mut scene = build.scene();
    let wrap = [Wrap::Clamp, Wrap::Clamp];
    scene.materials.textures.push(Texture { name: "tiles".into(), bytes: bytes.into_inner(), wrap });
    scene
}

fn area(scene: &Scene, triangle: usize) -> f64 {
    triangle_area(scene.mesh.corners(triangle))
}

fn triangle_area(corners: [[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| glam::Vec3::from(p).as_dvec3());
    0.5 * (b - a).cross(c - a).length()
}
