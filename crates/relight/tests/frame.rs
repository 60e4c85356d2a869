//! Product, bounces, points and pictures over a cube whose answers are known.

mod common;

use std::f64::consts::PI;

use common::{Cube, Maker, corners_receive, cube, emission, rig, scene};
use glam::Vec3;
use radfile::{BlockFormat, Elements, PackedOperator, Packing, PointRows, Quiet, Rows, Side, ValueMap};
use relight::{
    Frame, Image, Look, Parts, PatchSamples, Receivers, Relighter, Samples, Shown, bounces, light_at_points, render,
    surface_points,
};
use scene::{Camera, LightRig, Rays, hash};

/// A packed operator of noise; textures and outliers both count.
fn noise(n: u32, channels: u32, format: BlockFormat, map: ValueMap) -> PackedOperator<'static> {
    let (tile, tiles) = Packing::tiling(n);
    let packing = Packing { n, channels, bounces: None, format, map, scale: [0.5, 1.0, 2.0], tile, tiles };
    let bytes = packing.tile_count() * packing.tile_bytes();
    let per_row = 2;
    PackedOperator {
        half: None,
        blocks: (0..bytes as u32).map(|i| hash(i, 1) as u8).collect::<Vec<_>>().into(),
        outlier_start: (0..=n).map(|i| i * per_row).collect::<Vec<_>>().into(),
        outlier_column: (0..n).flat_map(|i| [i % (n / 2), n / 2 + i % (n / 2)]).collect::<Vec<_>>().into(),
        outlier_value: (0..n * per_row * channels).map(|i| (hash(i, 2) % 100) as f32).collect::<Vec<_>>().into(),
        packing,
    }
}

fn frame(cube: &Cube, rays: &Rays, rig: &LightRig) -> Frame {
    let bake = cube.relighter(rays);
    bake.frame(&bake.direct_light(rig), &PatchSamples::default(), &Quiet)
}

/// CIE 171:2006 test 5.8. Equal patches, so the mean is that of the patches; 96 × 32 Sobol points
/// of a smooth function carry about 0.1 %.
#[test]
fn in_a_grey_cube_the_mean_irradiance_is_flux_over_surface_over_one_minus_reflectance() {
    let light = rig(r#"{"type":"point","position":[0.4,0.6,0.5],"intensity":[1,2,0]}"#);
    for reflectance in [0.5, 0.9] {
        let cube = cube(4, reflectance, 0.0);
        let frame = frame(&cube, &Rays::new(&cube.scene.mesh), &light);
        let n = cube.patches.len() as f64;
        let mean = |c: usize| {
            (0..frame.direct.len()).map(|i| f64::from(frame.direct[i][c] + frame.indirect[i][c])).sum::<f64>() / n
        };
        let wanted = 4.0 * PI / (6.0 * (1.0 - f64::from(reflectance)));
        assert!((mean(0) / wanted - 1.0).abs() < 5e-3, "{reflectance}: {}, expected {wanted}", mean(0));
        assert!((mean(1) / mean(0) - 2.0).abs() < 1e-5 && mean(2) == 0.0);
    }
}

/// Shares of the light that one and three bounces hold: 1 - ρ and 1 - ρ³ of the sum over all.
#[test]
fn the_first_bounces_are_their_share_of_all() {
    let cube = cube(3, 0.8, 1.0);
    let direct = vec![[2.0, 1.0, 0.0]; cube.patches.len()];
    let all = relight::indirect(&cube.patches, &cube.operator, &direct);
    for (count, share) in [(0, 0.0), (1, 0.2), (3, 0.488), (200, 1.0)] {
        for (first, all) in bounces(&cube.patches, &cube.factors, &direct, count).iter().zip(&all) {
            assert!((first[0] - share * all[0]).abs() < 1e-4 * all[0], "{count}: {first:?} of {all:?}");
            assert!((first[1] - 0.5 * first[0]).abs() < 1e-5 && first[2] == 0.0);
        }
    }
}

/// Every wall emits radiance 1 and reflects ρ: direct π, indirect π ρ / (1 - ρ), at every point.
#[test]
fn points_in_a_furnace_have_the_light_of_the_furnace() {
    let cube = cube(2, 0.5, 1.0);
    let rays = Rays::new(&cube.scene.mesh);
    let bake = cube.relighter(&rays);
    let light = bake.direct_light(&emission());
    let frame = bake.frame(&light, &PatchSamples::default(), &Quiet);
    let points =
        surface_points(&cube.scene.mesh, &[[0.3, 0.0, 0.9], [1.0, 0.01, 0.5]], &[[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
    let rows = Rows { row_start: vec![0, 2, 3], sender: vec![0, 1, 20], weight: vec![0.25, 0.75, 1.0] };
    // Form factors of a point in a closed room sum to 1 as well; they weigh ρ (π + π) = π.
    for rows in [PointRows::Interpolated(rows.clone()), PointRows::Gathered { rows, sky: vec![0.0; 2] }] {
        let found = light_at_points(&bake, &light, &points, &(&rows).into(), &frame, &Samples::default(), &Quiet);
        for e in found.direct.iter().chain(&found.indirect).flatten() {
            assert!((f64::from(*e) / PI - 1.0).abs() < 1e-4, "{found:?}");
        }
    }
}

/// What a camera inside the cube takes.
fn picture(cube: &Cube, rig: &LightRig, look: &Look) -> Image {
    let camera = Camera { origin: [0.1, 0.2, 0.3], target: [0.9, 0.8, 0.6], up: [0.0, 1.0, 0.0], fov_x_deg: 90.0 };
    taken_by(&camera, cube, rig, look)
}

fn taken_by(camera: &Camera, cube: &Cube, rig: &LightRig, look: &Look) -> Image {
    let rays = Rays::new(&cube.scene.mesh);
    let bake = cube.relighter(&rays);
    let light = bake.direct_light(rig);
    let frame = bake.frame(&light, &PatchSamples::default(), &Quiet);
    let (transfer, rows) = corners_receive(&cube.scene.mesh);
    render(
        &Shown {
            bake: &bake,
            transfer: &transfer,
            receivers: &Receivers::Interpolated(&rows),
            light: &light,
            frame: &frame,
        },
        camera,
        look,
        &Quiet,
    )
}

fn small(parts: Parts) -> Look {
    Look { width: 24, height: 16, samples: 2, shadows: Samples { area: 16, sky: 0 }, parts }
}

/// Radiance 1/(1 - ρ) everywhere; its direct part is 1 + ρ, its indirect part ρ²/(1 - ρ).
#[test]
fn a_picture_of_a_furnace_is_one_flat_colour() {
    let cube = cube(2, 0.5, 1.0);
    for (parts, wanted) in [(Parts::All, 2.0), (Parts::DirectOnly, 1.5), (Parts::IndirectOnly, 0.5)] {
        let image = picture(&cube, &emission(), &small(parts));
        assert_eq!(image.pixels.len(), 24 * 16);
        for pixel in image.pixels.as_flattened() {
            assert!((pixel / wanted - 1.0).abs() < 1e-4, "{parts:?}: {pixel}, expected {wanted}");
        }
    }
}

#[test]
fn direct_and_indirect_pictures_add_up_to_the_whole() {
    let cube = cube(3, 0.5, 0.0);
    let light = rig(r#"{"type":"point","position":[0.4,0.6,0.5],"intensity":[1,2,0]}"#);
    let [all, direct, indirect] =
        [Parts::All, Parts::DirectOnly, Parts::IndirectOnly].map(|p| picture(&cube, &light, &small(p)));
    for ((a, d), i) in all.pixels.iter().zip(&direct.pixels).zip(&indirect.pixels) {
        assert!((a[0] - d[0] - i[0]).abs() < 1e-5 * a[0] && d[0] > 0.0 && i[0] > 0.0, "{a:?} {d:?} {i:?}");
    }
}

#[test]
fn a_camera_outside_sees_the_sky_around_the_cube() {
    let mut cube = cube(2, 0.5, 0.0);
    cube.scene.mesh.one_sided = true;
    let camera = Camera { origin: [0.5, 0.5, 3.0], target: [0.5, 0.5, 0.0], up: [0.0, 1.0, 0.0], fov_x_deg: 90.0 };
    let sky = rig(r#"{"type":"sky","radiance":[3,4,5]}"#);
    let image = taken_by(&camera, &cube, &sky, &Look { width: 9, height: 9, ..small(Parts::All) });
    assert_eq!(image.pixels[0], [3.0, 4.0, 5.0], "past the cube");
    assert_eq!(image.pixels[40], [0.0; 3], "the outside of one-sided walls is black");
}

/// A triangle of the floor goes on behind a wall: what its far corners receive is not seen on this side.
#[test]
fn a_picture_shows_no_light_of_receivers_behind_a_wall() {
    let mut maker = Maker::new(1.0);
    maker.sheet(Vec3::new(-1.0, 0.0, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0, [1, 1], &[Side::Front]);
    maker.sheet(Vec3::new(0.0, 0.0, -2.0), Vec3::Y * 2.0, Vec3::Z * 4.0, [1, 1], &[Side::Front]);
    let (mesh, mut patches) = maker.finish();
    let (transfer, mut rows) = corners_receive(&mesh);
    // Receivers beyond x = 0 have the light of patch 1, the others, and what is on the patch itself, that of patch 0.
    for (receiver, position) in transfer.position.iter().enumerate().take(6) {
        rows.sender[receiver] = u32::from(position[0] > 0.0);
    }
    patches.reflectance = vec![[0.5; 3]; 2];
    let scene = scene(mesh, 0.5, [0.0; 3]);
    let rays = Rays::new(&scene.mesh);
    let operator = noise(2, 1, BlockFormat::Bc4, ValueMap::Sqrt).into();
    let elements = Elements::whole(&patches);
    let bake = Relighter::new(&scene, &rays, &patches, &elements, &operator, &[0.0; 2]).unwrap();
    let light = bake.direct_light(&rig(""));
    let frame =
        Frame { element_direct: vec![[0.0; 3]; 2], direct: vec![[0.0; 3]; 2], indirect: vec![[0.0; 3], [100.0; 3]] };
    let shown = Shown {
        bake: &bake,
        transfer: &transfer,
        receivers: &Receivers::Interpolated(&rows),
        light: &light,
        frame: &frame,
    };
    let seen_from = |x: f64| {
        let camera = Camera { origin: [x, 2.0, 0.1], target: [x, 0.0, 0.0], up: [0.0, 0.0, 1.0], fov_x_deg: 20.0 };
        render(&shown, &camera, &Look { width: 16, height: 16, ..small(Parts::All) }, &Quiet)
    };
    assert!(seen_from(-0.5).pixels.iter().all(|p| *p == [0.0; 3]), "the dark side is dark");
    let bright = 0.5 * 100.0 / PI as f32;
    assert!(seen_from(0.5).pixels.iter().all(|p| (p[0] / bright - 1.0).abs() < 1e-5), "the lit side is flat");
}

#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    let cube = cube(2, 0.7, 0.0);
    let light =
        rig(r#"{"type":"quad","corner":[0.2,0.9,0.2],"edge_u":[0.4,0,0],"edge_v":[0,0,0.4],"radiance":[9,8,7]}"#);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        pool.install(|| picture(&cube, &light, &small(Parts::All)))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn parts_of_different_bakes_are_refused() {
    let (small, large) = (cube(1, 0.5, 0.0), cube(2, 0.5, 0.0));
    let rays = Rays::new(&small.scene.mesh);
    let refused = |operator, sky| {
        Relighter::new(&small.scene, &rays, &small.patches, &small.elements, operator, sky)
            .err()
            .expect("6 and 24 differ")
            .to_string()
    };
    let text = refused(&large.operator, &small.factors.sky);
    assert_eq!(text, "the packed operator is for 24 patches, the bake has 6; bake the scene again");
    let text = refused(&small.operator, &large.factors.sky);
    assert_eq!(text, "the sky visibility is for 24 patches, the bake has 6; bake the scene again");
    let bake = small.relighter(&rays);
    let light = bake.direct_light(&rig(""));
    let text = bake.frame_of_bounces(&light, &large.factors, 2, &PatchSamples::default(), &Quiet).unwrap_err();
    assert_eq!(text.to_string(), "the form-factor matrix is for 24 patches, the bake has 6; bake the scene again");
}

#[test]
fn a_texture_that_cannot_be_decoded_is_named() {
    let mut cube = cube(1, 0.5, 0.0);
    let texture = radfile::Texture { name: "wall.png".into(), bytes: vec![1, 2], wrap: [radfile::Wrap::Clamp; 2] };
    cube.scene.materials.textures.push(texture);
    let rays = Rays::new(&cube.scene.mesh);
    let error =
        Relighter::new(&cube.scene, &rays, &cube.patches, &cube.elements, &cube.operator, &cube.factors.sky).err();
    assert!(
        error.expect("two bytes are no picture").to_string().starts_with("wall.png: the texture cannot be decoded")
    );
}
