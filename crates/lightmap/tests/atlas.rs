//! Atlases: charts, sizes, what is refused, the same for any number of threads.

mod common;

use common::{ALL, cuboid, lightmap, load, quad, room};
use lightmap::{Atlas, Error, NO_CHART, Size, UnwrapParams, memory_needed, texels, unwrap};
use radfile::{Mesh, NO_RECEIVER, Quiet};
use scene::{Rays, hash};

fn with_size(size: Size) -> UnwrapParams {
    UnwrapParams { size, ..UnwrapParams::default() }
}

#[test]
fn a_box_is_unwrapped_into_its_sides_at_the_density_that_was_asked_for() {
    let mut mesh = Mesh::default();
    cuboid(&mut mesh, [0.0; 3], [1.0, 2.0, 3.0], true, ALL);
    let (atlas, map, report) = lightmap(&mesh, Size::PerMetre(10.0));
    // Surfaces that stand on each other are never of one chart.
    assert_eq!(atlas.charts(), 6);
    // Sides are whole texels long: 22 m² of 100 texels each.
    assert_eq!((report.touched, report.hidden, report.shared), (2200, 0, 0));
    for (t, &chart) in atlas.chart.iter().enumerate() {
        assert_eq!(chart, atlas.chart[t ^ 1], "both triangles of a side");
        let [a, b, c] = common::flat(&map, t);
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
        let [p, q, r] = mesh.corners(t).map(glam::Vec3::from);
        let surface = 0.5 * f64::from((q - p).cross(r - p).length());
        assert!((area / surface - 100.0).abs() < 0.01, "triangle {t}: {area} texels on {surface} m²");
    }
}

#[test]
fn a_floor_is_parted_where_a_wall_stands_on_its_edges() {
    let mut mesh = Mesh::default();
    quad(&mut mesh, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    // Of other vertices, as where a texture has a seam.
    quad(&mut mesh, [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
    let params = with_size(Size::PerMetre(16.0));
    assert_eq!(unwrap(&mesh, &params, &Quiet).unwrap().charts(), 1);
    quad(&mut mesh, [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]]);
    assert_eq!(unwrap(&mesh, &params, &Quiet).unwrap().charts(), 3);
}

#[test]
fn a_number_of_texels_is_met() {
    for (path, wanted) in [("assets/cornell/cornell.obj", 65_536), ("assets/apartment/apartment.obj", 20_000)] {
        let mesh = load(path).expect("it is bundled");
        let (_, _, report) = lightmap(&mesh, Size::Texels(wanted));
        let found = report.touched as f64 / f64::from(wanted);
        assert!((0.97..1.03).contains(&found), "{path}: {} of {wanted}", report.touched);
    }
}

#[test]
fn a_width_is_kept_and_charts_that_do_not_fit_are_refused() {
    let atlas = unwrap(&room(), &with_size(Size::Width(64)), &Quiet).unwrap();
    assert!(atlas.width == 64 && atlas.height <= 64, "{} × {}", atlas.width, atlas.height);
    let mesh = load("assets/apartment/apartment.obj").expect("it is bundled");
    let error = unwrap(&mesh, &with_size(Size::Width(16)), &Quiet).unwrap_err();
    assert!(matches!(error, Error::TooSmall { width: 16, padding: 2, .. }), "{error}");
}

#[test]
fn sizes_and_paddings_out_of_range_are_refused() {
    let said = |params: UnwrapParams| unwrap(&room(), &params, &Quiet).unwrap_err().to_string();
    assert!(said(with_size(Size::PerMetre(f32::NAN))).starts_with("a lightmap of NaN texels a metre was asked for"));
    assert!(said(with_size(Size::PerMetre(1e6))).contains("a texture holds 16384 × 16384"));
    assert!(said(with_size(Size::PerMetre(5e3))).contains("a texture holds 16384 × 16384"));
    let params = UnwrapParams { padding: 0, ..UnwrapParams::default() };
    assert!(said(params).starts_with("charts 0 texels apart were asked for, expected 1 to 64"));
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let mesh = load("assets/apartment/apartment.obj").expect("it is bundled");
    let rays = Rays::new(&mesh);
    let made = |threads: usize, fast: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let params = UnwrapParams { size: Size::Texels(8000), fast, ..UnwrapParams::default() };
            let atlas = unwrap(&mesh, &params, &Quiet).expect("an atlas");
            let map = texels(&mesh, &atlas, &rays, &Quiet);
            (atlas, map)
        })
    };
    for fast in [false, true] {
        assert_eq!(made(1, fast), made(3, fast));
    }
}

#[test]
fn triangles_without_area_have_no_receivers_and_no_nonsense() {
    let mut mesh = room();
    let first = mesh.positions.len() as u32;
    mesh.positions.extend([[1.0; 3], [2.0; 3], [3.0; 3]]);
    // One on the floor's corners, one alone, one of a single vertex.
    mesh.triangles.extend([[16, 17, 17], [first, first + 1, first + 2], [3, 3, 3]]);
    mesh.triangle_material.extend([0; 3]);
    let (atlas, map, report) = lightmap(&mesh, Size::PerMetre(8.0));
    assert_eq!((atlas.charts(), atlas.chart[13]), (6, NO_CHART));
    assert_eq!(report.hidden, 0);
    assert!(map.triangle.iter().all(|&t| t < 12));
    // Nothing but such triangles is no reason to fail.
    let nothing = Mesh { triangles: vec![[first, first + 1, first + 2]], triangle_material: vec![0], ..mesh };
    assert_eq!(lightmap(&nothing, Size::Texels(100)).2.receivers, 0);
}

#[test]
fn triangles_at_random_of_any_size_give_legal_lightmaps() {
    for (seed, size) in [(1, 1e-6), (2, 1.0), (3, 1e7)] {
        let mut state = seed;
        let mut random = move || {
            state = hash(state, seed);
            state as f32 / u32::MAX as f32
        };
        let mut mesh = Mesh::default();
        for t in 0..400 {
            let middle: [f32; 3] = std::array::from_fn(|_| size * random());
            // Of a tenth of the scene down to a millionth; every seventh is a needle.
            let extent = size * 10f32.powf(-1.0 - 5.0 * random());
            let mut corners: [[f32; 3]; 3] = std::array::from_fn(|_| middle.map(|x| x + extent * (random() - 0.5)));
            if t % 7 == 0 {
                corners[2] = std::array::from_fn(|k| 0.5 * (corners[0][k] + corners[1][k]));
            }
            mesh.positions.extend(corners);
            mesh.triangles.push([3 * t, 3 * t + 1, 3 * t + 2]);
            mesh.triangle_material.push(0);
        }
        // `lightmap` checks every number of the record.
        let (atlas, map, report) = lightmap(&mesh, Size::Texels(4000));
        assert!(report.receivers > 1000, "size {size}: {report:?}");
        for (t, _) in atlas.chart.iter().enumerate().filter(|(_, c)| **c != NO_CHART) {
            let inside = common::bilinear(&map, common::flat(&map, t)[0]);
            assert!(inside.iter().all(|(x, weight)| *weight < 1e-3 || map.receiver[*x] != NO_RECEIVER), "{size}: {t}");
        }
    }
}

/// Two unit squares side by side, both with coordinates of their own.
fn laid_out() -> Mesh {
    let mut mesh = Mesh::default();
    quad(&mut mesh, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    quad(&mut mesh, [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
    let square = |x: f32| [[x, 0.1], [x + 0.4, 0.1], [x + 0.4, 0.5], [x, 0.5]];
    mesh.lightmap_uv = [square(0.05), square(0.55)].concat();
    mesh
}

#[test]
fn the_files_own_coordinates_are_taken_as_they_are() {
    let mesh = laid_out();
    let atlas = Atlas::from_mesh(&mesh, Size::PerMetre(40.0)).unwrap();
    // 2 m² have 0.32 of the texture, so a metre is 0.4 of its edge.
    assert_eq!((atlas.width, atlas.height, atlas.charts()), (100, 100, 2));
    assert_eq!(atlas.corner_uv[1], [[0.05, 0.1], [0.05 + 0.4, 0.5], [0.05, 0.5]]);
    let (map, report) = texels(&mesh, &atlas, &Rays::new(&mesh), &Quiet);
    assert_eq!((report.touched, report.shared), (2 * 40 * 40, 0));
    // Texel (25, 30) is the middle of (0.255, 0.305): half way up and across the first square.
    let receiver = map.texel.iter().position(|&x| x == 30 * 100 + 25).expect("it is on the mesh");
    let [x, y, z] = map.position[receiver];
    assert!((x - 0.5125).abs() < 1e-4 && (y - 0.5125).abs() < 1e-4 && z == 0.0, "{x} {y} {z}");
    let about = Atlas::from_mesh(&mesh, Size::Texels(10_000)).unwrap();
    let (_, report) = texels(&mesh, &about, &Rays::new(&mesh), &Quiet);
    // Without its texels along the borders, 0.32 of 177 × 177 is 10 000.
    assert!(about.width <= 177 && (9_800..10_200).contains(&report.touched), "{} {}", about.width, report.touched);
}

#[test]
fn coordinates_that_are_no_lightmaps_are_refused_in_words() {
    let said = |change: fn(&mut Mesh)| {
        let mut mesh = laid_out();
        change(&mut mesh);
        Atlas::from_mesh(&mesh, Size::Width(128)).unwrap_err().to_string()
    };
    let none = said(|m| m.lightmap_uv.clear());
    assert_eq!(none, "the scene has no second set of texture coordinates (TEXCOORD_1 of glTF); make one with --unwrap");
    let outside = said(|m| m.lightmap_uv[5] = [1.5, 0.0]);
    assert!(outside.contains("is no lightmap: vertex 5 lies at [1.5, 0.0], expected 0 to 1; make one with --unwrap"));
    let stacked = said(|m| m.lightmap_uv.copy_within(0..4, 4));
    assert!(stacked.contains("texels are covered by several triangles, expected one each"), "{stacked}");
    let crowded = said(|m| m.lightmap_uv = [[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]; 2].concat());
    assert!(crowded.contains("its triangles have 2.00 times the area of the texture"), "{crowded}");
    let placeless = said(|m| m.lightmap_uv[4..].fill([0.0; 2]));
    assert!(placeless.contains("50.0 % of the surface has no area in it"), "{placeless}");
}

#[test]
fn instances_that_share_coordinates_are_refused() {
    let Some(mesh) = load("../shared/scenes/dirty/instances_uv1_lights.glb") else { return };
    assert!(!mesh.lightmap_uv.is_empty());
    assert!(matches!(Atlas::from_mesh(&mesh, Size::Width(256)), Err(Error::Unusable { .. })));
}

#[test]
fn memory_is_told_beforehand() {
    assert!(memory_needed(66_000, 65_536) < 100 << 20);
    assert!(memory_needed(38, 4_000_000) > 800 << 20, "four million texels took 800 MB");
    assert_eq!(memory_needed(u64::MAX, u64::MAX), u64::MAX);
}
