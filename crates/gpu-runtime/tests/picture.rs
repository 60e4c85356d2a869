//! Pictures against radiance that is known in closed form.

mod common;

use std::f32::consts::PI;

use common::{Room, cornell, diagonal_operator, gpu, room, wall};
use glam::Vec3;
use gpu_runtime::{Gpu, GpuRuntime, Params, Parts};
use radfile::{NO_RECEIVER, Texture, Wrap};
use scene::{Camera, Light, LightRig};

const DIRECT: Parts = Parts { direct: true, indirect: false };
const INDIRECT: Parts = Parts { direct: false, indirect: true };
const SIZE: [u32; 2] = [70, 50];

fn runtime(gpu: &Gpu, room: &Room, factor: f32) -> GpuRuntime {
    let packed = diagonal_operator(room.patches.len() as u32, factor);
    let params = Params { patch_samples: 16, pixel_detail: 1, ..Params::default() };
    GpuRuntime::new(gpu, &room.bake(), &packed, &params).expect("it fits")
}

/// A floor of 4 m by 4 m around a far origin, and a camera above that sees its border.
fn floor() -> Room {
    let mut walls = [wall([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [4, 4])];
    walls[0].reflectance = [0.8, 0.4, 0.2];
    let mut room = room(&walls);
    room.scene.mesh.origin = [1e5, 0.0, 0.0];
    room
}

fn camera() -> Camera {
    Camera { origin: [1e5, -1.5, 2.5], target: [1e5, 0.5, 0.0], up: [0.0, 0.0, 1.0], fov_x_deg: 75.0 }
}

fn lamp() -> LightRig {
    let light = Light::Point { position: [1e5 + 0.5, 0.25, 1.5], intensity: [6.0, 3.0, 1.0] };
    LightRig { lights: vec![light], ..LightRig::default() }
}

/// Where the centre of a pixel meets the floor, local axes.
fn on_floor(x: u32, y: u32) -> Vec3 {
    let (eye, target) = (Vec3::new(0.0, -1.5, 2.5), Vec3::new(0.0, 0.5, 0.0));
    let forward = (target - eye).normalize();
    let right = forward.cross(Vec3::Z).normalize();
    let half = 37.5f32.to_radians().tan();
    let (s, t) = ((2.0 * x as f32 + 1.0) / 70.0 - 1.0, 1.0 - (2.0 * y as f32 + 1.0) / 50.0);
    let way = forward + half * (s * right + 50.0 / 70.0 * t * right.cross(forward));
    eye - way * (eye.z / way.z)
}

fn is_inside(p: Vec3) -> bool {
    p.z.abs() < 1e-3 && p.x.abs() < 2.0 && p.y.abs() < 2.0
}

/// Calls `check` with every pixel that sees the floor, away from its border; says how many those are.
fn pixels_of_the_floor(mut check: impl FnMut(usize, Vec3)) -> usize {
    let mut count = 0;
    for (i, (x, y)) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))).enumerate() {
        let p = on_floor(x, y);
        let well_inside = p.x.abs() < 1.95 && p.y.abs() < 1.95;
        if is_inside(p) && well_inside {
            check(i, p);
            count += 1;
        }
    }
    count
}

/// L = ρ I cos / (π d²) in every pixel; position and comparison with the shadow map in single precision.
#[test]
fn direct_light_of_a_lamp_over_a_floor_has_its_radiance() {
    let Some(gpu) = gpu() else { return };
    let picture = runtime(&gpu, &floor(), 0.5).render(&lamp(), &camera(), SIZE[0], SIZE[1], DIRECT).unwrap();
    let seen = pixels_of_the_floor(|i, p| {
        let d2 = (p - Vec3::new(0.5, 0.25, 1.5)).length_squared();
        let expected = 0.8 / PI * 6.0 * 1.5 / (d2 * d2.sqrt());
        let found = picture[i][0];
        assert!((found - expected).abs() < 1e-3 * expected, "pixel {i} at {p}: {found}, expected {expected}");
        assert!((picture[i][2] - found / 24.0).abs() < 1e-4 * found, "blue is a sixth of it, and reflects a quarter");
    });
    assert!(seen > 1000, "{seen} pixels see the floor");
}

/// The operator of this room sends half of what a patch reflects back to it: L = ρ (ρ H⁰ / 2) / π.
#[test]
fn indirect_light_is_that_of_the_receivers() {
    let Some(gpu) = gpu() else { return };
    let room = floor();
    let runtime = runtime(&gpu, &room, 0.5);
    let h = runtime.relight(&lamp()).unwrap().indirect;
    let picture = runtime.render(&lamp(), &camera(), SIZE[0], SIZE[1], INDIRECT).unwrap();
    let seen = pixels_of_the_floor(|i, p| {
        let cell = |x: f32| (x + 2.0).floor() as usize;
        let expected = 0.8 / PI * h[4 * cell(p.y) + cell(p.x)][0];
        let border = |x: f32| (x - x.round()).abs() < 1e-3;
        if !border(p.x) && !border(p.y) {
            assert!((picture[i][0] - expected).abs() < 1e-4 * expected, "pixel {i}: {:?}, {expected}", picture[i]);
        }
    });
    assert!(seen > 1000);
    let both = runtime.render(&lamp(), &camera(), SIZE[0], SIZE[1], Parts::default()).unwrap();
    let direct = runtime.render(&lamp(), &camera(), SIZE[0], SIZE[1], DIRECT).unwrap();
    for ((b, d), i) in both.as_flattened().iter().zip(direct.as_flattened()).zip(picture.as_flattened()) {
        assert!((b - d - i).abs() <= 1e-5 * b, "{b} is not {d} + {i}");
    }
}

/// Corners without receiver do not count; where a side has none, the patch below answers.
#[test]
fn missing_receivers_leave_no_dark_spots() {
    let Some(gpu) = gpu() else { return };
    let mut room = floor();
    for (t, receiver) in room.transfer.fine.receiver.iter_mut().enumerate() {
        match t % 3 {
            0 => receiver[0] = [NO_RECEIVER; 3],
            1 => receiver[0][1] = NO_RECEIVER,
            _ => {}
        }
    }
    let take = |room: &Room| {
        runtime(&gpu, room, 0.5).render(&lamp(), &camera(), SIZE[0], SIZE[1], INDIRECT).expect("a picture")
    };
    let (found, whole) = (take(&room), take(&floor()));
    for (f, w) in found.as_flattened().iter().zip(whole.as_flattened()) {
        assert!((f - w).abs() <= 1e-4 * w, "{f} instead of {w}");
    }
}

#[test]
fn the_sky_fills_the_background_and_lights_by_what_is_seen_of_it() {
    let Some(gpu) = gpu() else { return };
    let mut room = floor();
    room.sky.fill(1.0);
    let rig = LightRig { lights: vec![Light::Sky { radiance: [1.0, 2.0, 3.0] }], ..LightRig::default() };
    let runtime = runtime(&gpu, &room, 0.5);
    let picture = runtime.render(&rig, &camera(), SIZE[0], SIZE[1], DIRECT).unwrap();
    assert_eq!(picture[0], [1.0, 2.0, 3.0], "the upper corner sees the sky");
    pixels_of_the_floor(|i, _| assert!((picture[i][1] - 0.4 * 2.0).abs() < 1e-5, "L = rho L_sky: {:?}", picture[i]));
    let dark = runtime.render(&rig, &camera(), SIZE[0], SIZE[1], INDIRECT).unwrap();
    assert_eq!(dark[0], [0.0; 3], "the sky is direct light");
}

#[test]
fn emission_leaves_the_front_and_only_when_asked() {
    let Some(gpu) = gpu() else { return };
    let mut panel = wall([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [4, 4]);
    panel.emission = [3.0, 2.0, 1.0];
    let front = room(&[panel]);
    (panel.u, panel.v) = (panel.v, panel.u);
    let back = room(&[panel]);
    let camera = Camera { origin: [0.0, -1.5, 2.5], target: [0.0, 0.5, 0.0], ..camera() };
    let take = |room: &Room, use_scene_emission, parts| {
        let rig = LightRig { use_scene_emission, ..LightRig::default() };
        runtime(&gpu, room, 0.0).render(&rig, &camera, SIZE[0], SIZE[1], parts).expect("a picture")[25 * 70 + 35]
    };
    assert_eq!(take(&front, true, DIRECT), [3.0, 2.0, 1.0]);
    assert_eq!(take(&front, false, DIRECT), [0.0; 3]);
    assert_eq!(take(&front, true, INDIRECT), [0.0; 3]);
    assert_eq!(take(&back, true, DIRECT), [0.0; 3]);
}

/// A texture that is black to the left and white to the right, over the whole floor.
#[test]
fn textures_colour_what_is_seen() {
    let Some(gpu) = gpu() else { return };
    let mut room = floor();
    let mut bytes = Vec::new();
    let image = image::GrayImage::from_raw(2, 1, vec![0, 255]).unwrap();
    image.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).unwrap();
    room.scene.materials.textures.push(Texture { name: "halves.png".into(), bytes, wrap: [Wrap::Clamp; 2] });
    room.scene.materials.materials[0].reflectance_texture = Some(0);
    room.scene.mesh.uv = room.scene.mesh.positions.iter().map(|p| [(p[0] + 2.0) / 4.0, (p[1] + 2.0) / 4.0]).collect();
    room.sky.fill(1.0);
    let rig = LightRig { lights: vec![Light::Sky { radiance: [1.0; 3] }], ..LightRig::default() };
    let picture = runtime(&gpu, &room, 0.5).render(&rig, &camera(), SIZE[0], SIZE[1], DIRECT).unwrap();
    let surfaces = scene::Surfaces::new(&room.scene.mesh, &room.scene.materials).unwrap();
    pixels_of_the_floor(|i, p| {
        // Patch of the cell, its first triangle, whose plane of coordinates is that of the whole floor.
        let cell = |x: f32| (x + 2.0).floor();
        let triangle = 2 * (4.0 * cell(p.y) + cell(p.x)) as u32;
        let v = p.y + 2.0 - cell(p.y);
        let expected = surfaces.reflectance(triangle, p.x + 2.0 - cell(p.x) - v, v)[0];
        // Hardware mixes texels with 8 bits of the way between them.
        assert!((picture[i][0] - expected).abs() < 0.01, "pixel {i} at {p}: {} {expected}", picture[i][0]);
    });
    room.scene.materials.textures[0].bytes.truncate(30);
    let packed = diagonal_operator(room.patches.len() as u32, 0.5);
    let params = Params::default();
    let error = GpuRuntime::new(&gpu, &room.bake(), &packed, &params).err().unwrap();
    assert!(error.to_string().starts_with("halves.png: the texture cannot be decoded"), "{error}");
}

/// A lamp under the floor lights its back, unless back sides reflect nothing.
#[test]
fn a_back_side_of_a_one_sided_scene_is_black() {
    let Some(gpu) = gpu() else { return };
    let light = Light::Point { position: [1e5, 0.0, -1.5], intensity: [6.0; 3] };
    let rig = LightRig { lights: vec![light], ..LightRig::default() };
    let under = Camera { origin: [1e5, -1.5, -2.5], ..camera() };
    let middle = |one_sided| {
        let mut room = floor();
        room.scene.mesh.one_sided = one_sided;
        runtime(&gpu, &room, 0.5).render(&rig, &under, SIZE[0], SIZE[1], DIRECT).unwrap()[25 * 70 + 35]
    };
    let both = middle(false);
    assert!(both[0] > 0.1 && (both[1] - 0.5 * both[0]).abs() < 1e-4, "red reflects twice as much as green: {both:?}");
    assert_eq!(middle(true), [0.0; 3]);
}

/// Two pictures of the same box by different means; what differs are the edges of shadows and of surfaces.
#[test]
fn a_picture_is_that_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let room = cornell(8);
    let rig = LightRig {
        lights: vec![Light::Point { position: [2.7, 2.5, 4.9], intensity: [9.0, 8.0, 7.0] }],
        ..LightRig::default()
    };
    let camera = Camera { origin: [2.75, 0.1, 2.75], target: [2.75, 5.0, 2.2], up: [0.0, 0.0, 1.0], fov_x_deg: 80.0 };
    let packed = diagonal_operator(room.patches.len() as u32, 0.5);
    let params = Params { pixel_detail: 4, ..Params::default() };
    let runtime = GpuRuntime::new(&gpu, &room.bake(), &packed, &params).unwrap();
    let found = runtime.render(&rig, &camera, 64, 64, Parts::default()).unwrap();
    let rays = scene::Rays::new(&room.scene.mesh);
    let operator = packed.clone().into();
    let bake =
        relight::Relighter::new(&room.scene, &rays, &room.patches, &room.elements, &operator, &room.sky).unwrap();
    let light = bake.direct_light(&rig);
    let frame = bake.frame(&light, &relight::PatchSamples::default(), &radfile::Quiet);
    let receivers = relight::Receivers::Interpolated(&room.rows);
    let shown =
        relight::Shown { bake: &bake, transfer: &room.transfer, receivers: &receivers, light: &light, frame: &frame };
    let look = relight::Look { width: 64, height: 64, samples: 64, ..relight::Look::default() };
    let truth = relight::render(&shown, &camera, &look, &radfile::Quiet).pixels;
    let (mean, rms) = common::difference(&found, &truth);
    println!("picture: mean {:+.3} %, rms {:.2} % of the mean", 100.0 * mean, 100.0 * rms);
    // 16 samples a pixel in rows against 64 scattered ones: an edge of contrast 1 is off by up to 1/8 of a pixel.
    assert!(mean.abs() < 0.003 && rms < 0.03, "mean {mean}, rms {rms}");
}

/// Pictures are made on what the one before was made on, if that has their size.
#[test]
fn a_picture_owes_nothing_to_the_one_before() {
    let Some(gpu) = gpu() else { return };
    let room = floor();
    let runtime = runtime(&gpu, &room, 0.5);
    let picture = |rig: &LightRig, height: f64, size: [u32; 2], parts: Parts| {
        let camera = Camera { origin: [1e5, -1.5, height], ..camera() };
        runtime.render(rig, &camera, size[0], size[1], parts).unwrap()
    };
    let sky = LightRig { lights: vec![Light::Sky { radiance: [9.0; 3] }], ..LightRig::default() };
    let first = picture(&lamp(), 2.5, SIZE, Parts::default());
    assert_ne!(picture(&sky, 1.0, SIZE, Parts::default()), first);
    assert_ne!(picture(&lamp(), 2.5, SIZE, DIRECT), first);
    assert_eq!(picture(&lamp(), 2.5, SIZE, Parts::default()), first);
    let before = gpu.buffers_made();
    assert_eq!(picture(&lamp(), 2.5, SIZE, Parts::default()), first);
    assert_eq!(gpu.buffers_made(), before, "a later picture of this size makes no buffers");
    assert_eq!(picture(&lamp(), 2.5, [8, 8], DIRECT).len(), 64);
    assert_eq!(picture(&lamp(), 2.5, SIZE, Parts::default()), first);
}

#[test]
fn what_does_not_fit_together_or_into_the_device_is_said() {
    let Some(gpu) = gpu() else { return };
    let room = floor();
    let bad = runtime(&gpu, &room, 0.5);
    let say = |e: gpu_runtime::Error| e.to_string();
    let text = say(bad.render(&lamp(), &camera(), 40_000, 40_000, DIRECT).unwrap_err());
    assert!(text.starts_with("the picture needs 40000 x 40000 samples, ") && text.contains("maxTextureDimension2D"));
    assert!(text.ends_with("fewer samples a pixel, or use --backend cpu"), "{text}");
    let nowhere = Camera { target: camera().origin, ..camera() };
    assert_eq!(say(bad.render(&lamp(), &nowhere, 8, 8, DIRECT).unwrap_err()), "the camera looks at its own eye");
    let text = say(bad.patch_indirect(&[[0.0; 3]; 3]).unwrap_err());
    assert_eq!(text, "the direct light is of 3 patches, the bake has 16; all parts must come from one bake");
    let rows = radfile::Rows { row_start: vec![0, 1], sender: vec![16], weight: vec![1.0] };
    let text = say(bad.gather(&rows, &[[0.0; 3]; 16]).unwrap_err());
    assert_eq!(text, "weights of receivers: an entry names patch 16, there are 16");
    let packed = diagonal_operator(16, 0.5);
    let build = |room: &Room, params: &Params| GpuRuntime::new(&gpu, &room.bake(), &packed, params);
    let text = say(build(&room, &Params { patch_samples: 0, ..Params::default() }).err().unwrap());
    assert_eq!(text, "patch_samples is 0, expected at least 1");
    let text = say(build(&room, &Params { shadow_resolution: 1 << 20, ..Params::default() }).err().unwrap());
    assert!(text.starts_with("a shadow map needs 1048576 texels along an edge"), "{text}");
    let text = say(build(&room, &Params { patch_samples: 1 << 30, ..Params::default() }).err().unwrap());
    assert!(text.starts_with("the sample points of patches needs 262144.0 MiB") && text.contains("(max"), "{text}");
    let bare = build(&floor().without_fine_mesh(), &Params::default()).unwrap();
    let text = say(bare.render(&lamp(), &camera(), 8, 8, DIRECT).unwrap_err());
    assert_eq!(text, "the bake has no fine mesh to be shown; it is written by `allbounce transfer`");
}
