//! The fine mesh, the container entry, what is refused, and sameness.

mod common;
mod staged;

use std::collections::HashMap;

use common::Maker;
use glam::Vec3;
use radfile::{Builder, Container, Elements, Mesh, Patches, Quiet, Record, Transfer};
use scene::{Rays, Surfaces};
use staged::{again, grey};
use transfer::{Error, Mode, Params, Report, Senders, subdivide, transfer};

/// A closed room of unequal edges, cut into no more than its twelve triangles' worth of patches.
fn room() -> (Mesh, Patches) {
    let mut maker = Maker::new(0.3);
    maker.room(Vec3::new(-0.7, 0.1, 0.3), Vec3::new(3.1, 1.7, 0.9), [1, 1, 1]);
    maker.finish()
}

fn with(params: Params) -> Result<(Transfer, Report), Error> {
    let (mesh, patches) = room();
    // A wall is one patch here, many voxels wide.
    let params = Params { edge: params.edge.or(Some(0.3)), ..params };
    let scene = grey(mesh);
    let rays = Rays::new(&scene.mesh);
    let elements = match params.mode {
        Mode::Gather => subdivide(&patches, &Surfaces::new(&scene.mesh, &scene.materials).unwrap(), &rays, &Quiet),
        Mode::Interpolate => Elements::whole(&patches),
    };
    transfer(&scene.mesh, &Senders { patches: &patches, elements: &elements, rays: &rays }, &params, &Quiet)
}

#[test]
fn the_fine_mesh_of_a_closed_room_has_no_gap_and_no_long_edge() {
    let (made, report) = with(Params::default()).expect("it is small");
    let fine = &made.fine;
    let mut uses: HashMap<(u32, u32), i32> = HashMap::new();
    let mut area = 0.0;
    for t in &fine.triangle {
        let [a, b, c] = t.map(|v| Vec3::from(fine.vertex[v as usize]));
        area += f64::from(0.5 * (b - a).cross(c - a).length());
        for (from, to) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            let length = Vec3::from(fine.vertex[from as usize]).distance(Vec3::from(fine.vertex[to as usize]));
            assert!(length <= 0.3 * 1.0001, "an edge of {length} m was left");
            // Neighbours run along their common edge in opposite senses, so the two cancel.
            *uses.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
        }
    }
    assert!(uses.values().all(|&sum| sum == 0), "an edge without its neighbour is a T-junction");
    let wanted = 2.0 * (3.1 * 1.7 + 1.7 * 0.9 + 0.9 * 3.1);
    assert!((area / wanted - 1.0).abs() < 1e-5, "area {area}, the room has {wanted}");
    assert_eq!(report.fine_triangles, fine.triangle.len());
    assert_eq!(report.fine_vertices as i64, fine.triangle.len() as i64 / 2 + 2, "Euler's count of a closed surface");
}

#[test]
fn a_longer_edge_makes_fewer_receivers() {
    let fine = with(Params::default()).expect("it is small").1;
    let coarse = with(Params { edge: Some(0.6), ..Params::default() }).expect("it is small").1;
    assert!(coarse.receivers * 2 < fine.receivers, "{coarse:?} {fine:?}");
    assert_eq!(coarse.edge, 0.6);
}

#[test]
fn absurd_sizes_are_refused_with_figure_and_remedy() {
    let text = |p: Params| with(p).expect_err("this must be refused").to_string();
    let text_of_edge = text(Params { edge: Some(-1.0), ..Params::default() });
    assert!(text_of_edge.contains("is -1 m, expected a positive length"), "{text_of_edge}");
    let fine = text(Params { edge: Some(1e-4), ..Params::default() });
    assert!(fine.contains("MiB") && fine.contains("limit is 4000000; an edge of"), "{fine}");
    let remedy: f32 = fine.split("an edge of ").nth(1).and_then(|s| s.split(' ').next()).unwrap().parse().unwrap();
    assert!(with(Params { edge: Some(remedy * 8.0), ..Params::default() }).is_ok(), "a multiple of the remedy works");
    let limited = text(Params { max_triangles: 11, ..Params::default() });
    assert!(limited.contains("12 triangles before any is cut, the limit of fine triangles is 11"), "{limited}");
}

/// What stages before this one leave of the room, with a section of somebody else.
fn with_guest() -> Container {
    let (mesh, patches) = room();
    let (scene, mut builder) = (grey(mesh), Builder::new());
    scene.write(&mut builder);
    patches.write(&mut builder);
    builder.array("guest.values", 0, &[3], vec![1.0f32, 2.0, 3.0]);
    builder.meta("accuracy.meta", 0, &"what receivers that are replaced were worth");
    builder.finish().expect("records of the test are sound")
}

#[test]
fn the_stage_adds_its_record_and_hands_the_rest_through() {
    let params = Params { edge: Some(0.3), ..Params::default() };
    let (made, report) = again(&with_guest(), &params).expect("the room is sound");
    let read = Transfer::read(&made).expect("the record is sound");
    assert_eq!(read.position.len(), report.receivers);
    assert_eq!(read, with(Params::default()).unwrap().0);
    assert!(made.has("guest.values") && made.has("patches.area"));
    assert!(!made.has("accuracy.meta"), "it was measured with other receivers");
    assert_eq!(radfile::Provenance::read(&made).unwrap().steps.last().map(|s| s.stage.as_str()), Some("transfer"));
}

#[test]
fn a_container_without_patches_is_refused_by_name() {
    let (mesh, _) = room();
    let mut builder = Builder::new();
    mesh.write(&mut builder);
    let error = again(&builder.finish().unwrap(), &Params::default()).err().expect("there are no patches");
    assert_eq!(error.to_string(), "section patches.area is missing; it is written by `allbounce voxel-simplify`");
}

#[test]
fn the_number_of_threads_does_not_change_a_byte() {
    let bytes = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        let made = pool.install(|| with(Params::default())).expect("it is small").0;
        let mut builder = Builder::new();
        made.write(&mut builder);
        builder.to_bytes()
    };
    assert_eq!(bytes(1), bytes(3));
}
