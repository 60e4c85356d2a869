//! Irradiance volumes: what their probes gather, which have none, the container entry.

mod common;
mod staged;

use std::f64::consts::PI;

use common::Maker;
use glam::Vec3;
use hmatrix::Rectangle;
use radfile::{Container, Elements, Gathered, Mesh, Patches, PointRows, Quiet, Record, Side, Volume};
use scene::{NO_TRIANGLE, Rays, SurfacePoint};
use staged::{again, container};
use transfer::{Error, Mode, Params, Senders, VolumeParams, gather_for_points, volume};

fn every(spacing: f32) -> VolumeParams {
    VolumeParams { spacing, ..VolumeParams::default() }
}

fn params() -> Params {
    Params { gather_error: 0.002, ..Params::default() }
}

fn made(mesh: &Mesh, patches: &Patches, wanted: &VolumeParams) -> Result<(Volume, Gathered), Error> {
    let senders = Senders { patches, elements: &Elements::whole(patches), rays: &Rays::new(mesh) };
    let (probes, gathered, report) = volume(mesh, &senders, wanted, &params(), &Quiet)?;
    probes.check().expect("legal");
    assert_eq!((report.probes, report.probes + report.filled), (probes.probes(), probes.cells()));
    assert_eq!(gathered.sky.len(), probes.receivers());
    Ok((probes, gathered))
}

/// What the six receivers of every probe get of patches of given radiosity.
fn light(gathered: &Gathered, radiosity: impl Iterator<Item = f32>) -> Vec<[f32; 6]> {
    let of_patches: Vec<[f32; 3]> = radiosity.map(|b| [b; 3]).collect();
    let rows = Rectangle::from_bytes(&gathered.stream).expect("a stream");
    let mut light = vec![[0.0; 3]; rows.receivers()];
    rows.multiply(&[of_patches.clone(), of_patches].concat(), &mut light, &mut rows.workspace());
    light.as_chunks::<6>().0.iter().map(|six| six.map(|e| e[0])).collect()
}

/// A box with patches on the given sides of its walls; their fronts are outside.
fn solid(maker: &mut Maker, low: Vec3, size: Vec3, count: usize, sides: &[Side]) {
    let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
    let sheets = [(low, x, z), (low + y, z, x), (low, y, x), (low + z, x, y), (low, z, y), (low + x, y, z)];
    for (corner, u, v) in sheets {
        maker.sheet(corner, u, v, [count; 2], sides);
    }
}

#[test]
fn in_a_furnace_every_direction_of_every_probe_gets_the_radiosity_of_the_walls() {
    let mut maker = Maker::new(0.5);
    maker.room(Vec3::new(-1.0, 0.5, 2.0), Vec3::new(1.0, 0.8, 1.3), [2; 3]);
    let (mesh, patches) = maker.finish();
    let (probes, gathered) = made(&mesh, &patches, &every(0.35)).expect("a room");
    assert_eq!((probes.count, probes.probes(), probes.origin), ([3, 3, 4], 36, [-1.0, 0.5, 2.0]));
    assert!(probes.spacing.iter().all(|&edge| edge <= 0.35));
    for (probe, six) in light(&gathered, patches.area.iter().map(|_| 1.0)).iter().enumerate() {
        // What packing changes at single receivers; nothing escapes and nothing is lost by noise.
        assert!(six.iter().all(|e| (e - 1.0).abs() < 0.01), "probe {probe}: {six:?}");
    }
    assert_eq!(gathered.sky, vec![0.0; probes.receivers()]);
}

/// Form factor from a point to a rectangle a × b over it at distance 1, one corner on its normal
/// (Howell, configuration B-3).
fn corner_factor(a: f64, b: f64) -> f64 {
    let half = |a: f64, b: f64| a / (1.0 + a * a).sqrt() * (b / (1.0 + a * a).sqrt()).atan();
    (half(a, b) + half(b, a)) / (2.0 * PI)
}

/// The middle of a cube of which one wall shines, each of the six in turn: the direction of that wall gets the closed form
/// of a square, the opposite nothing, and the four others, by symmetry and closure, a quarter of what is left.
#[test]
fn the_direction_of_the_wall_that_shines_gets_the_most_and_the_opposite_nothing() {
    let mut maker = Maker::new(1.0);
    maker.room(Vec3::splat(-1.0), Vec3::splat(2.0), [2; 3]);
    let (mesh, patches) = maker.finish();
    let (probes, gathered) = made(&mesh, &patches, &every(2.0)).expect("a room");
    assert_eq!((probes.count, probes.probes()), ([1; 3], 1));
    // The probe is up to 3.4 cm off the middle, which moves what it gets by 3 % of the light.
    let facing = 4.0 * corner_factor(1.0, 1.0);
    for (direction, normal) in Volume::NORMALS.iter().enumerate() {
        let shines = |inward: &[f32; 3]| if (0..3).all(|a| inward[a] == -normal[a]) { 1.0 } else { 0.0 };
        let [six] = light(&gathered, patches.normal.iter().map(shines))[..] else { panic!("one probe") };
        for (d, &found) in six.iter().enumerate() {
            let expected = match d {
                _ if d == direction => facing,
                _ if d == direction ^ 1 => 0.0,
                _ => 0.25 * (1.0 - facing),
            };
            assert!((f64::from(found) - expected).abs() < 0.03, "wall {direction}, direction {d}: {found}, {expected}");
            assert!(expected > 0.0 || found == 0.0, "wall {direction} shines into direction {d}: {found}");
        }
    }
}

/// A wall without thickness stands where the middles of cells are.
#[test]
fn probes_of_a_dark_room_beside_a_bright_one_are_exactly_dark() {
    let mut maker = Maker::new(0.5);
    maker.room(Vec3::ZERO, Vec3::new(1.0, 0.8, 1.2), [2; 3]);
    maker.room(Vec3::X, Vec3::new(1.0, 0.8, 1.2), [2; 3]);
    let (mesh, patches) = maker.finish();
    let (probes, gathered) = made(&mesh, &patches, &every(0.4)).expect("rooms");
    assert_eq!((probes.count, probes.probes()), ([5, 2, 3], 30));
    assert_eq!(probes.middle(2)[0], 1.0);
    let bright = |patch: usize| if patch < patches.len() / 2 { 1.0 } else { 0.0 };
    for (probe, six) in light(&gathered, (0..patches.len()).map(bright)).iter().enumerate() {
        let dark = probes.position[probe][0] > 1.0;
        let right = |e: &f32| if dark { *e == 0.0 } else { (e - 1.0).abs() < 0.02 };
        assert!(six.iter().all(right), "probe {probe} at {:?} gets {six:?}", probes.position[probe]);
    }
}

/// Cells of half a metre; the box fills some of them, touches the wall of the room, and beyond that wall is a dark room,
/// from which no cell of the box may be filled though it is as near.
#[test]
fn probes_within_a_standing_box_are_left_out_and_filled_from_the_room_it_stands_in() {
    for sides in [&[Side::Front][..], &[Side::Front, Side::Back]] {
        a_box_stands_in_a_room(sides);
    }
}

fn a_box_stands_in_a_room(sides: &[Side]) {
    let mut maker = Maker::new(0.5);
    maker.room(Vec3::ZERO, Vec3::splat(3.0), [2; 3]);
    maker.room(Vec3::X * 3.0, Vec3::new(1.0, 3.0, 3.0), [2; 3]);
    let dark_from = maker.patches.len() / 2;
    let [low, size] = [Vec3::new(1.95, 0.0, 0.95), Vec3::new(1.04, 1.1, 1.1)];
    solid(&mut maker, low, size, 2, sides);
    let (mesh, patches) = maker.finish();
    let (probes, gathered) = made(&mesh, &patches, &every(0.5)).expect("a room");
    let high = low + size;
    let within = |p: Vec3| p.cmpgt(low).all() && p.cmplt(high).all();
    let inside: Vec<usize> = (0..probes.cells()).filter(|&c| within(probes.middle(c).into())).collect();
    let without: Vec<usize> = (0..probes.cells()).filter(|&c| !probes.cell.contains(&(c as u32))).collect();
    assert_eq!((inside.len(), &without), (8, &inside));
    let bright = |patch: usize| if (dark_from..2 * dark_from).contains(&patch) { 0.0 } else { 1.0 };
    let light = light(&gathered, (0..patches.len()).map(bright));
    for cell in inside {
        let probe = probes.probe[cell] as usize;
        let distance = Vec3::from(probes.position[probe]).distance(probes.middle(cell).into());
        assert!(distance < 1.2, "cell {cell} is filled from {distance} m away");
        assert!(light[probe].iter().all(|e| (e - 1.0).abs() < 0.02), "cell {cell} shows {:?}", light[probe]);
    }
}

/// Two sheets stand in a corner of a room and show their backs to it; all of the room is in the open for all that.
#[test]
fn probes_behind_back_sides_that_have_patches_are_in_the_open() {
    let mut maker = Maker::new(0.5);
    maker.room(Vec3::ZERO, Vec3::splat(2.0), [2; 3]);
    let both = &[Side::Front, Side::Back];
    maker.sheet(Vec3::X * 0.4, Vec3::Y * 2.0, Vec3::Z * 1.6, [2; 2], both);
    maker.sheet(Vec3::new(0.4, 0.0, 1.6), Vec3::Y * 2.0, Vec3::X * 1.2, [2; 2], both);
    let (mesh, patches) = maker.finish();
    let (probes, _) = made(&mesh, &patches, &every(0.25)).expect("a room");
    assert_eq!((probes.cells(), probes.probes()), (512, 512));
}

/// A room that is wound the wrong way round, as it may be where both sides of surfaces reflect.
#[test]
fn a_room_that_is_inside_out_is_a_room() {
    let mut maker = Maker::new(0.5);
    solid(&mut maker, Vec3::ZERO, Vec3::ONE, 2, &[Side::Front, Side::Back]);
    let (mesh, patches) = maker.finish();
    let (probes, _) = made(&mesh, &patches, &every(0.5)).expect("a room");
    assert_eq!(probes.probes(), 8);
}

#[test]
fn packed_probes_get_the_light_of_the_same_points_unpacked() {
    let mut maker = Maker::new(0.25);
    maker.room(Vec3::ZERO, Vec3::new(1.0, 0.8, 1.2), [4; 3]);
    solid(&mut maker, Vec3::new(0.3, 0.0, 0.4), Vec3::splat(0.3), 2, &[Side::Front]);
    let (mesh, patches) = maker.finish();
    let (probes, gathered) = made(&mesh, &patches, &every(0.25)).expect("a room");
    let point = |r: usize| SurfacePoint {
        position: probes.position[r / 6].into(),
        normal: Volume::NORMALS[r % 6].into(),
        triangle: NO_TRIANGLE,
    };
    let points: Vec<SurfacePoint> = (0..probes.receivers()).map(point).collect();
    let senders = Senders { patches: &patches, elements: &Elements::whole(&patches), rays: &Rays::new(&mesh) };
    let counted = gather_for_points(&senders, &points, &params().gather, &Quiet);
    let PointRows::Gathered { rows, sky } = counted else { panic!("they are gathered") };
    assert_eq!(sky, gathered.sky);
    // A wall of the room lights the rest.
    let radiosity = || patches.position.iter().map(|p| if p[0] < 1e-3 { 1.0 } else { 0.1 + 0.1 * p[1] });
    let of_patches: Vec<[f32; 3]> = radiosity().map(|b| [b; 3]).collect();
    let expected = rows.gather(&[of_patches.clone(), of_patches].concat());
    let found = light(&gathered, radiosity());
    let square = |values: &mut dyn Iterator<Item = f32>| values.map(|v| f64::from(v).powi(2)).sum::<f64>();
    let error = square(&mut found.as_flattened().iter().zip(&expected).map(|(f, e)| f - e[0]));
    let relative = (error / square(&mut expected.iter().map(|e| e[0]))).sqrt();
    assert!(relative < 2.0 * params().gather_error, "packing changes the light by {relative}");
}

#[test]
fn what_makes_no_volume_is_refused() {
    let mut maker = Maker::new(0.5);
    solid(&mut maker, Vec3::ZERO, Vec3::new(4.0, 2.0, 1.0), 1, &[Side::Front]);
    let (mesh, patches) = maker.finish();
    let said = |wanted: VolumeParams| made(&mesh, &patches, &wanted).expect_err("a refusal").to_string();
    assert!(said(every(0.5)).starts_with("the middles of all 64 cells of the irradiance volume lie inside or behind"));
    let few = said(VolumeParams { spacing: 0.1, max_cells: 100 });
    assert!(few.starts_with("probes every 0.1 m are [40, 20, 10] along x, y and z, the limit is 100 in all"), "{few}");
    let remedy: f32 =
        few.split("a spacing of ").nth(1).and_then(|t| t.split(' ').next()?.parse().ok()).expect("a number");
    let coarser = said(VolumeParams { spacing: remedy, max_cells: 100 });
    assert!(coarser.starts_with("the middles of all"), "{coarser}");
    // A row of 800 cells is no texture.
    assert!(said(VolumeParams { spacing: 0.005, max_cells: u64::MAX }).contains("682 along an axis"));
    assert!(said(every(1e-38)).contains("a spacing of"));
    for spacing in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(said(every(spacing)).contains("expected a positive length"), "{spacing}");
    }
}

#[test]
fn a_flat_scene_has_one_layer_of_cells() {
    let mut maker = Maker::new(0.5);
    maker.sheet(Vec3::ZERO, Vec3::Z * 2.0, Vec3::X * 2.0, [2; 2], &[Side::Front, Side::Back]);
    let (mesh, patches) = maker.finish();
    let (probes, gathered) = made(&mesh, &patches, &every(1.0)).expect("a floor");
    assert_eq!((probes.count, probes.origin, probes.spacing), ([2, 1, 2], [0.0, -0.5, 0.0], [1.0; 3]));
    let up = probes.probe[0] as usize * 6 + 2;
    assert_eq!(gathered.sky[up], 1.0);
}

fn one_room() -> Container {
    let mut maker = Maker::new(0.5);
    maker.room(Vec3::ZERO, Vec3::ONE, [2; 3]);
    container(maker.finish())
}

#[test]
fn the_stage_adds_a_volume_and_a_later_run_without_one_drops_it() {
    let wanted = Params { volume: Some(every(0.5)), ..params() };
    let (made, report) = again(&one_room(), &wanted).expect("the room is sound");
    let probes = Volume::read(&made).expect("legal");
    let gathered = Gathered::read(&made, Volume::PREFIX, probes.receivers()).expect("legal");
    assert_eq!(report.volume.expect("it was asked for").probes, probes.probes());
    assert_eq!(gathered.certificate.senders as usize, Elements::read(&made).expect("elements").senders());
    let (without, report) = again(&made, &params()).expect("the room is sound");
    assert!(report.volume.is_none() && !without.has("volume.meta") && !without.has("volume.gather"));
    assert!(transfer::memory_needed(&made, &wanted).expect("it is small") >= (48 * gathered.certificate.rays).into());
}

#[test]
fn a_volume_is_not_interpolated() {
    let wanted = Params { mode: Mode::Interpolate, volume: Some(every(0.5)), ..params() };
    let error = again(&one_room(), &wanted).err().expect("a refusal").to_string();
    assert!(error.starts_with("an irradiance volume is only made where light is gathered; leave out"), "{error}");
}

#[test]
fn the_number_of_threads_does_not_change_a_byte() {
    let wanted = Params { volume: Some(every(0.3)), ..params() };
    let bytes = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        pool.install(|| again(&one_room(), &wanted)).expect("the room is sound").0.as_bytes().to_vec()
    };
    assert_eq!(bytes(1), bytes(3));
}
