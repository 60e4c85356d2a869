//! A sealed dark room beside a lit one.

use super::{
    EDGES, EVEN, LeakScene, Placement, Volume,
    place::{PLACEMENTS, TURNED_MORE},
};
use crate::shapes::{Plate, inside_of_box, outside_of_box};

/// Each room, metres.
const ROOM: [f64; 3] = [2.4, 2.0, 2.4];
/// How far a partition goes into floor, ceiling and walls, so that no rounding opens a gap.
const SUNK: f64 = 0.02;
/// Edge of a voxel at which scenes are baked.
const VOXEL: f64 = super::measure::VOXEL;

/// Thickness of the wall, 0 for a single sheet, and what a table calls it.
const WALLS: [(f64, &str); 6] =
    [(0.0, "a sheet"), (0.001, "1 mm"), (0.01, "1 cm"), (0.1, "10 cm"), (VOXEL, "1 voxel"), (2.0 * VOXEL, "2 voxels")];

/// Each wall in each place, both as rooms with walls of their own and as one hall that is parted.
pub fn scenes() -> Vec<LeakScene> {
    let mut scenes = Vec::new();
    for (thick, name) in WALLS {
        for placement in PLACEMENTS {
            scenes.push(own_walls(thick, name, placement));
            scenes.push(parted(thick, name, placement));
        }
    }
    scenes.push(parted(0.001, "1 mm", TURNED_MORE));
    scenes
}

/// Two boxes beside each other. Where the wall is a sheet, the lit room's stands for both.
fn own_walls(thick: f64, wall: &str, placement: Placement) -> LeakScene {
    let mut scene = dark_room(format!("two rooms, wall {wall}, {}", placement.name), thick, placement);
    let dark = dark_walls(thick);
    scene.plates(&inside_of_box([0.0; 3], ROOM));
    scene.plates(dark.iter().skip(usize::from(thick == 0.0)));
    scene
}

/// One hall with a wall across; floor and ceiling run on below and above it.
fn parted(thick: f64, wall: &str, placement: Placement) -> LeakScene {
    let mut scene = dark_room(format!("parted hall, wall {wall}, {}", placement.name), thick, placement);
    scene.plates(&inside_of_box([0.0; 3], [2.0 * ROOM[0] + thick, ROOM[1], ROOM[2]]));
    scene.plates(&partition(thick, [ROOM[1], ROOM[2] + SUNK]));
    scene
}

/// A wall at the end of the lit room, from below the floor to above `height` and up to z = `depth`.
fn partition(thick: f64, [height, depth]: [f64; 2]) -> Vec<Plate> {
    let (low, high) = ([ROOM[0], -SUNK, -SUNK], [ROOM[0] + thick, height + SUNK, depth]);
    let walls = outside_of_box(low, high);
    if thick == 0.0 { walls[..1].to_vec() } else { walls.to_vec() }
}

/// Lamp, dark places and questions that both kinds share.
fn dark_room(name: String, thick: f64, placement: Placement) -> LeakScene {
    let mut scene = LeakScene::new(name, placement, [ROOM[0] - 0.1, 1.1, 1.3]);
    let dark = dark_walls(thick);
    let far = [2.0 * ROOM[0] + thick, ROOM[1], ROOM[2]];
    scene.dark = vec![Volume::Box([ROOM[0] + thick, 0.0, 0.0], far)];
    scene.ask(&inside_of_box([0.0; 3], ROOM), &EVEN);
    scene.ask(&dark, &EDGES);
    scene.eye = Some([[far[0] - 0.2, 1.2, 1.1], [ROOM[0] + thick, 0.9, 1.2]]);
    scene
}

/// Walls of the dark room, the one to the lit room first.
fn dark_walls(thick: f64) -> [Plate; 6] {
    inside_of_box([ROOM[0] + thick, 0.0, 0.0], [2.0 * ROOM[0] + thick, ROOM[1], ROOM[2]])
}

/// A parted hall that is open in front, for a picture: no way leads from one room to the other, as what leaves does not
/// come back.
pub fn section() -> LeakScene {
    const THICK: f64 = 0.01;
    let mut scene = dark_room("parted hall, cut open".into(), THICK, super::place::ALIGNED);
    scene.plates(&inside_of_box([0.0; 3], [2.0 * ROOM[0] + THICK, ROOM[1], ROOM[2]])[..5]);
    scene.plates(&partition(THICK, [ROOM[1], ROOM[2]]));
    scene.points.retain(|p| p.position[2] < ROOM[2] - 1e-6);
    scene.eye = None;
    scene
}
