//! Back sides of walls, with and without `--one-sided`.

use super::{EDGES, EVEN, LeakScene, Volume, place::TURNED};
use crate::shapes::{Plate, inside_of_box, outside_of_box};

const ROOM: [f64; 3] = [2.4, 2.0, 2.4];
const LAMP: [f64; 3] = [2.3, 1.1, 1.3];

pub fn scenes() -> Vec<LeakScene> {
    let sided = |one_sided: bool| {
        let sides = if one_sided { "one-sided" } else { "two-sided" };
        let mut scenes = vec![outside(sides), behind_a_sheet(sides, false), under_the_sky(sides)];
        if one_sided {
            scenes.push(behind_a_sheet(sides, true));
        } else {
            scenes.push(inside_out(sides));
        }
        scenes.iter_mut().for_each(|s| s.one_sided = one_sided);
        scenes
    };
    [false, true].into_iter().flat_map(sided).collect()
}

fn lit_room(name: String) -> LeakScene {
    let mut scene = LeakScene::new(name, TURNED, LAMP);
    scene.ask(&inside_of_box([0.0; 3], ROOM), &EVEN);
    scene
}

/// The back sides of a lit room's walls: there is nothing outside.
fn outside(sides: &str) -> LeakScene {
    let mut scene = lit_room(format!("outsides of a lit room, {sides}"));
    scene.plates(&inside_of_box([0.0; 3], ROOM));
    scene.ask(&outside_of_box([0.0; 3], ROOM), &EDGES);
    // Whatever looks away from the room.
    let far = 10.0;
    for (axis, wall) in ROOM.into_iter().enumerate() {
        for (low, high) in [(-far, 0.0), (wall, far)] {
            let mut space = ([-far; 3], [far; 3]);
            (space.0[axis], space.1[axis]) = (low, high);
            scene.dark.push(Volume::Box(space.0, space.1));
        }
    }
    scene
}

/// A dark room beside the lit one, the wall a sheet that turns its front or its `back` to the lamp.
fn behind_a_sheet(sides: &str, back: bool) -> LeakScene {
    let side = if back { "back" } else { "front" };
    let mut scene = lit_room(format!("behind a sheet whose {side} is lit, {sides}"));
    let (low, high) = ([ROOM[0], 0.0, 0.0], [2.0 * ROOM[0], ROOM[1], ROOM[2]]);
    let dark = inside_of_box(low, high);
    let lit = inside_of_box([0.0; 3], ROOM);
    scene.plates(&dark[1..]);
    scene.plates([&lit[0], &lit[2], &lit[3], &lit[4], &lit[5]]);
    scene.plates([if back { &dark[0] } else { &lit[1] }]);
    scene.ask(&dark, &EDGES);
    scene.dark = vec![Volume::Box(low, high)];
    scene.eye = Some([[4.6, 1.1, 1.3], [2.4, 0.9, 1.2]]);
    scene
}

/// A closed room under a bright sky, its walls a millimetre thick; nothing shines inside.
fn under_the_sky(sides: &str) -> LeakScene {
    let mut scene = LeakScene::new(format!("closed room under the sky, {sides}"), TURNED, LAMP);
    (scene.lamp, scene.sky) = (None, true);
    let thick = ROOM.map(|x| x + 0.001);
    let (outer, inner): ([Plate; 6], [Plate; 6]) = (outside_of_box([-0.001; 3], thick), inside_of_box([0.0; 3], ROOM));
    scene.plates(&outer);
    scene.plates(&inner);
    scene.ask(&outer, &EVEN);
    scene.ask(&inner, &EDGES);
    scene.dark = vec![Volume::Box([0.0; 3], ROOM)];
    scene.eye = Some([[2.2, 1.2, 1.1], [0.0, 0.9, 1.2]]);
    scene
}

/// A dark room whose fronts look outwards, beside a lit one whose fronts do, too.
fn inside_out(sides: &str) -> LeakScene {
    let mut scene = lit_room(format!("rooms inside out, {sides}"));
    let (low, high) = ([ROOM[0] + 0.001, 0.0, 0.0], [2.0 * ROOM[0], ROOM[1], ROOM[2]]);
    scene.plates(&outside_of_box([0.0; 3], ROOM));
    scene.plates(&outside_of_box(low, high));
    scene.ask(&inside_of_box(low, high), &EDGES);
    scene.dark = vec![Volume::Box(low, high)];
    scene.eye = Some([[4.6, 1.1, 1.3], [2.4, 0.9, 1.2]]);
    scene
}
