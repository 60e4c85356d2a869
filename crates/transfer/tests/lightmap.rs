//! Lightmaps: what their texels gather, the scene's own coordinates, the container entry.

mod common;
mod staged;

use common::Maker;
use glam::Vec3;
use hmatrix::Rectangle;
use radfile::{Container, Elements, Gathered, Lightmap, Mesh, Patches, Quiet, Record, Side};
use scene::Rays;
use staged::{again, container};
use transfer::{Error, LightmapParams, Mode, Params, Report, Senders, lightmap};

/// Two closed rooms side by side, behind a wall without thickness.
fn rooms() -> (Mesh, Patches) {
    let mut maker = Maker::new(0.5);
    maker.room(Vec3::ZERO, Vec3::new(1.0, 0.8, 1.2), [2; 3]);
    maker.room(Vec3::X, Vec3::new(1.0, 0.8, 1.2), [2; 3]);
    maker.finish()
}

fn params(texels: u32) -> Params {
    let size = LightmapParams { texels, ..LightmapParams::default() };
    Params { lightmap: Some(size), gather_error: 0.002, ..Params::default() }
}

/// What the texels get of senders of given radiosity.
fn light(gathered: &Gathered, radiosity: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let rows = Rectangle::from_bytes(&gathered.stream).expect("a stream");
    let mut light = vec![[0.0; 3]; rows.receivers()];
    rows.multiply(radiosity, &mut light, &mut rows.workspace());
    light
}

#[test]
fn every_texel_of_a_closed_room_gets_all_of_its_view_from_that_room() {
    let (mesh, patches) = rooms();
    let (elements, rays) = (Elements::whole(&patches), Rays::new(&mesh));
    let senders = Senders { patches: &patches, elements: &elements, rays: &rays };
    let params = params(1500);
    let (texels, gathered, report) =
        lightmap(&mesh, &senders, &params.lightmap.unwrap(), &params, &Quiet).expect("a lightmap");
    texels.check(mesh.triangles.len()).expect("legal");
    assert!((1300..1700).contains(&report.placed.touched), "{report:?}");
    assert_eq!((report.placed.hidden, report.coordinates.as_str()), (0, "unwrapped"));
    assert_eq!(gathered.sky, vec![0.0; texels.receivers()]);
    // The first room glows and the second is dark.
    let glow = |patch: usize| if patch < patches.len() / 2 { [1.0, 2.0, 0.0] } else { [0.0; 3] };
    let of_first: Vec<[f32; 3]> = (0..patches.len()).map(glow).collect();
    let radiosity = [of_first.clone(), of_first].concat();
    let middle = mesh.triangles.len() / 2;
    for (r, light) in light(&gathered, &radiosity).iter().enumerate() {
        let expected = if (texels.triangle[r] as usize) < middle { [1.0, 2.0, 0.0] } else { [0.0; 3] };
        let error = (0..3).map(|c| (light[c] - expected[c]).abs()).fold(0.0, f32::max);
        assert!(error < 0.02, "receiver {r} gets {light:?}, expected {expected:?}");
        assert!(expected != [0.0; 3] || *light == [0.0; 3], "receiver {r} in the dark room gets {light:?}");
    }
}

#[test]
fn coordinates_of_the_scene_are_taken_where_they_are_a_lightmaps() {
    let mut maker = Maker::new(0.5);
    maker.sheet(Vec3::ZERO, Vec3::X, Vec3::Y, [2, 2], &[Side::Front]);
    maker.sheet(Vec3::Z, Vec3::Y, Vec3::X, [2, 2], &[Side::Front]);
    let (mut mesh, patches) = maker.finish();
    let (elements, rays) = (Elements::whole(&patches), Rays::new(&mesh));
    let senders = Senders { patches: &patches, elements: &elements, rays: &rays };
    let params = params(256);
    let mut made = |scale: f32| {
        mesh.lightmap_uv = mesh.positions.iter().map(|[x, y, z]| [scale * x + 0.5 * z, scale * y]).collect();
        let made = lightmap(&mesh, &senders, &params.lightmap.unwrap(), &params, &Quiet).expect("a lightmap");
        let own = (0..mesh.triangles.len())
            .all(|t| made.0.corner_uv[t] == mesh.triangles[t].map(|v| mesh.lightmap_uv[v as usize]));
        (own, made.2.coordinates)
    };
    assert_eq!(made(0.45), (true, "those of the scene file".into()));
    let (own, coordinates) = made(1.0);
    assert!(!own && coordinates.starts_with("unwrapped; those of the scene file are no lightmap's: "), "{coordinates}");
}

fn of_rooms(params: &Params) -> Result<(Container, Report), Error> {
    again(&container(rooms()), params)
}

#[test]
fn the_stage_adds_a_lightmap_and_a_later_run_without_one_drops_it() {
    let (made, report) = of_rooms(&params(600)).expect("the rooms are sound");
    let texels = Lightmap::read(&made).expect("legal");
    let gathered = Gathered::read(&made, Lightmap::PREFIX, texels.receivers()).expect("legal");
    let numbers = report.lightmap.expect("it was asked for");
    assert_eq!(numbers.placed.receivers, texels.receivers());
    assert_eq!(gathered.certificate.senders as usize, Elements::read(&made).expect("elements").senders());
    let (without, report) = again(&made, &Params { lightmap: None, ..params(600) }).expect("the rooms are sound");
    assert!(report.lightmap.is_none() && !without.has("lightmap.meta") && !without.has("lightmap.gather"));
}

#[test]
fn a_lightmap_is_not_interpolated() {
    let error = of_rooms(&Params { mode: Mode::Interpolate, ..params(600) }).err().expect("a refusal").to_string();
    assert!(
        error.starts_with("a lightmap is only made where light is gathered; leave out --mode interpolate"),
        "{error}"
    );
}
