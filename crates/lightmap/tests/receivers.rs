//! Receivers lie on the mesh, on the side that is looked at, in open air; filters read nothing else.

mod common;

use common::{ALL, bilinear, cuboid, flat, lightmap, load, middles, quad, room, weights};
use glam::Vec3;
use lightmap::{NO_CHART, Size};
use radfile::{Lightmap, Mesh, NO_RECEIVER};
use scene::Sobol;

/// Normal of the front.
fn front(mesh: &Mesh, triangle: u32) -> Vec3 {
    let [a, b, c] = mesh.corners(triangle as usize).map(Vec3::from);
    (b - a).cross(c - a).normalize()
}

/// Triangles of a lightmap whose receivers are on the back.
fn turned(mesh: &Mesh, map: &Lightmap) -> Vec<u32> {
    let back = |&(t, n): &(&u32, &[f32; 3])| front(mesh, *t).dot(Vec3::from(*n)) < 0.0;
    let mut turned: Vec<u32> = map.triangle.iter().zip(&map.normal).filter(back).map(|(t, _)| *t).collect();
    turned.dedup();
    turned.sort_unstable();
    turned.dedup();
    turned
}

/// Every bilinear sample on the mesh reads texels of its own chart, at the corners of triangles, too.
fn filters_stay_inside(path: &str, texels: u32) {
    let Some(mesh) = load(path) else { return };
    let (atlas, map, _) = lightmap(&mesh, Size::Texels(texels));
    let samples = (2_000_000 / mesh.triangles.len()).clamp(10, 2000) as u32;
    for t in (0..mesh.triangles.len()).filter(|&t| atlas.chart[t] != NO_CHART) {
        let (corners, sequence) = (flat(&map, t), Sobol::new(t as u32));
        for sample in 0..samples {
            let [x, y, ..] = sequence.sample(sample);
            let (u, v) = scene::square_to_triangle(x, y);
            let w = match sample {
                0..3 => std::array::from_fn(|k| if k == sample as usize { 1.0 } else { 0.0 }),
                _ => [1.0 - u - v, u, v].map(f64::from),
            };
            let p = [0, 1].map(|k| (0..3).map(|c| w[c] * corners[c][k]).sum::<f64>());
            for (texel, weight) in bilinear(&map, p) {
                let receiver = map.receiver[texel];
                let chart = (receiver != NO_RECEIVER).then(|| atlas.chart[map.triangle[receiver as usize] as usize]);
                assert!(
                    weight < 1e-4 || chart == Some(atlas.chart[t]),
                    "{path}: triangle {t} reads texel {texel} at {p:?}"
                );
            }
        }
    }
}

#[test]
fn filters_read_nothing_but_their_own_chart() {
    filters_stay_inside("assets/cornell/cornell.obj", 65_536);
    filters_stay_inside("assets/apartment/apartment.obj", 65_536);
    filters_stay_inside("assets/apartment/apartment.obj", 3000);
}

#[test]
fn filters_read_nothing_but_their_own_chart_in_sponza() {
    filters_stay_inside("../shared/scenes/sponza/sponza.glb", 65_536);
}

#[test]
fn receivers_lie_on_their_triangle_in_their_texel() {
    let mesh = load("assets/apartment/apartment.obj").expect("it is bundled");
    let (_, map, _) = lightmap(&mesh, Size::Texels(30_000));
    for r in 0..map.receivers() {
        let t = map.triangle[r];
        let ([a, b, c], p) = (mesh.corners(t as usize).map(Vec3::from), Vec3::from(map.position[r]));
        let (n, area) = (front(&mesh, t), (b - a).cross(c - a).length());
        assert!((p - a).dot(n).abs() < 1e-5, "receiver {r} is off its plane");
        assert!(n.dot(Vec3::from(map.normal[r])) > 0.99999, "receiver {r}");
        let w = [(b - p).cross(c - p), (c - p).cross(a - p), (a - p).cross(b - p)].map(|x| x.dot(n) / area);
        assert!(w.iter().all(|w| *w > -1e-5), "receiver {r} is off its triangle: {w:?}");
        let corners = flat(&map, t as usize);
        let place = [0, 1].map(|k| (0..3).map(|c| f64::from(w[c]) * corners[c][k]).sum::<f64>());
        let texel = [map.texel[r] % map.width, map.texel[r] / map.width].map(f64::from);
        assert!((0..2).all(|k| (place[k] - texel[k] - 0.5).abs() < 0.51), "receiver {r}: {place:?} in texel {texel:?}");
    }
}

#[test]
fn nothing_is_hidden_in_an_empty_room() {
    let (_, map, report) = lightmap(&room(), Size::PerMetre(20.0));
    assert_eq!((report.hidden, report.moved, report.turned), (0, 0, 0));
    assert_eq!(report.touched, 20 * 20 * (2 * 16 + 4 * 12));
    assert_eq!(map.fill(&vec![[1.0; 3]; map.receivers()]).iter().filter(|t| t[0] == 1.0).count(), {
        map.receiver.iter().filter(|r| **r != NO_RECEIVER).count()
    });
}

/// Receivers of the floor of a room with something on it, and the middles of its texels that have none.
fn floor_with(add: impl FnOnce(&mut Mesh)) -> (Vec<Vec3>, Vec<Vec3>) {
    let mut mesh = room();
    add(&mut mesh);
    let (_, map, _) = lightmap(&mesh, Size::PerMetre(20.0));
    let on_floor = (0..map.receivers()).filter(|&r| matches!(map.triangle[r], 8 | 9));
    let receivers = on_floor.map(|r| Vec3::from(map.position[r])).collect();
    let texels = [8, 9].map(|t| middles(&mesh, &map, t)).concat();
    let hidden = texels.iter().filter(|(x, _)| map.texel.binary_search(x).is_err());
    (receivers, hidden.map(|(_, p)| *p).collect())
}

/// How far a point of the floor lies inside a rectangle; negative outside.
fn depth(p: Vec3, low: [f32; 2], high: [f32; 2]) -> f32 {
    [p.x - low[0], high[0] - p.x, p.y - low[1], high[1] - p.y].into_iter().fold(f32::INFINITY, f32::min)
}

#[test]
fn the_floor_under_a_box_has_no_receivers_and_that_around_it_has_all() {
    // The box ends within texels, which are 5 cm wide.
    let ([low, high], texel) = ([[1.02, 1.33], [2.57, 2.41]], 0.05);
    let open_below = [true, true, true, true, false, true];
    for (name, bottom, top, sides) in [
        ("standing, closed", 0.0, 0.6, ALL),
        ("standing, open below", 0.0, 0.6, open_below),
        ("a millimetre above", 0.001, 0.6, ALL),
        ("sunk in", -0.1, 0.6, ALL),
        ("through the ceiling", -0.1, 3.2, ALL),
    ] {
        let (receivers, hidden) = floor_with(|mesh| {
            cuboid(mesh, [low[0], low[1], bottom], [high[0], high[1], top], true, sides);
        });
        // A box that floats is seen into for a little way.
        let slack = if bottom > 0.0 { texel } else { 1e-4 };
        let inside = receivers.iter().find(|p| depth(**p, low, high) > slack);
        assert_eq!(inside, None, "{name}: a receiver is under the box");
        let outside = hidden.iter().find(|p| depth(**p, low, high) < -texel);
        assert_eq!(outside, None, "{name}: a texel in the open is hidden");
        let area = (high[0] - low[0]) * (high[1] - low[1]);
        let found = hidden.len() as f32 * texel * texel;
        assert!((found / area - 1.0).abs() < 0.1, "{name}: {found} m² of {area} m² are hidden");
    }
}

#[test]
fn texels_that_are_half_covered_receive_on_their_open_half() {
    // Texels are 25 cm wide, and the box covers 60 % of those along its left side.
    let mut mesh = room();
    cuboid(&mut mesh, [1.1, 0.5, 0.0], [3.9, 3.5, 1.0], true, ALL);
    let (_, map, report) = lightmap(&mesh, Size::PerMetre(4.0));
    let texels = [8, 9].map(|t| middles(&mesh, &map, t)).concat();
    let beside = |p: &Vec3| (p.x - 1.125).abs() < 0.01 && (0.5..3.5).contains(&p.y);
    let along: Vec<_> = texels.iter().filter(|(_, p)| beside(p)).collect();
    assert!(along.len() >= 12 && report.moved >= 12, "{} {}", along.len(), report.moved);
    for (texel, _) in along {
        let receiver = map.texel.binary_search(texel).expect("it receives");
        assert!(map.position[receiver][0] < 1.1, "{:?}", map.position[receiver]);
    }
}

#[test]
fn hidden_texels_show_a_neighbour_of_their_own_chart() {
    let mut mesh = room();
    cuboid(&mut mesh, [1.0, 1.0, 0.0], [3.0, 3.0, 0.5], true, ALL);
    let (atlas, map, _) = lightmap(&mesh, Size::PerMetre(20.0));
    let values: Vec<[f32; 3]> =
        (0..map.receivers()).map(|r| [map.position[r][0], atlas.chart[map.triangle[r] as usize] as f32, 1.0]).collect();
    let picture = map.fill(&values);
    for (texel, p) in [8, 9].map(|t| middles(&mesh, &map, t)).concat() {
        let [x, chart, set] = picture[texel as usize];
        assert_eq!((chart, set), (atlas.chart[8] as f32, 1.0));
        // From under the box the nearest texel of the floor is a metre away at most, and 3 texels for the ways of rings.
        assert!((x - p.x).abs() < 1.15, "{p} shows the floor at x = {x}");
    }
    assert!(picture.iter().zip(&map.receiver).all(|(v, r)| (*r == NO_RECEIVER) == (v[2] == 0.0)));
}

#[test]
fn what_is_hidden_as_a_whole_keeps_its_receivers() {
    // A box in a box.
    let mut mesh = room();
    cuboid(&mut mesh, [1.0, 1.0, 0.1], [3.0, 3.0, 2.0], true, ALL);
    cuboid(&mut mesh, [1.5, 1.5, 0.5], [2.5, 2.5, 1.5], true, ALL);
    let (_, map, report) = lightmap(&mesh, Size::PerMetre(10.0));
    assert_eq!(report.turned, 0);
    assert!((24..36).all(|t| map.triangle.contains(&t)));
}

#[test]
fn solids_and_rooms_receive_on_their_fronts_and_what_is_inside_out_on_its_back() {
    let sides = |build: &dyn Fn(&mut Mesh)| {
        let mut mesh = Mesh::default();
        build(&mut mesh);
        let (_, map, _) = lightmap(&mesh, Size::PerMetre(5.0));
        turned(&mesh, &map)
    };
    let ([low, high], block) = ([[0.0; 3], [4.0, 4.0, 3.0]], [[1.0, 1.0, 0.0], [2.0, 2.0, 1.0]]);
    let room = |m: &mut Mesh, outside| cuboid(m, low, high, outside, ALL);
    let inside_out: Vec<u32> = (0..12).collect();
    assert_eq!(sides(&|m| room(m, false)), [] as [u32; 0]);
    assert_eq!(sides(&|m| room(m, true)), inside_out, "a room inside out");
    assert_eq!(
        sides(&|m| {
            room(m, true);
            cuboid(m, block[0], block[1], true, ALL);
        }),
        inside_out,
        "a room inside out, what stands in it is not"
    );
    // A building of thick walls: outside there is nothing to see, but it is its front.
    assert_eq!(
        sides(&|m| {
            room(m, false);
            cuboid(m, [-0.3; 3], [4.3, 4.3, 3.3], true, ALL);
        }),
        [] as [u32; 0],
        "a building that stands alone"
    );
    // One wall of a building turned: its front looks into the wall.
    assert_eq!(
        sides(&|m| {
            cuboid(m, low, high, false, [false, true, true, true, true, true]);
            cuboid(m, low, high, true, [true, false, false, false, false, false]);
            cuboid(m, [-0.3; 3], [4.3, 4.3, 3.3], true, ALL);
        }),
        [10, 11],
        "a wall inside out"
    );
    let mut mesh = Mesh { one_sided: true, ..Mesh::default() };
    room(&mut mesh, true);
    assert_eq!(
        turned(&mesh, &lightmap(&mesh, Size::PerMetre(5.0)).1),
        [] as [u32; 0],
        "one-sided meshes have no backs"
    );
}

#[test]
fn a_single_sheet_receives_on_its_front() {
    let mut mesh = Mesh::default();
    quad(&mut mesh, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    let (_, map, report) = lightmap(&mesh, Size::PerMetre(10.0));
    assert_eq!((report.receivers, report.turned), (100, 0));
    assert!(map.normal.iter().all(|n| *n == [0.0, 0.0, 1.0]));
    // All weights are those of its two triangles.
    let at = weights(flat(&map, 0), [0.5, 0.5]);
    assert!((at.iter().sum::<f64>() - 1.0).abs() < 1e-12);
}
