//! A curtain of a single sheet across a room with the lamp on one side: behind it there is only what goes round it.

use super::{Darkness, EVEN, LeakScene, Placement, Volume, place};
use crate::shapes::{Plate, inside_of_box};

const ROOM: [f64; 3] = [4.0, 2.0, 2.4];
const LAMP: [f64; 3] = [1.5, 1.1, 1.9];
/// Where the curtain hangs.
const AT: f64 = 1.9;
/// How far it goes into floor, ceiling and wall.
const SUNK: f64 = 0.02;
/// Places behind it are those that lie so far from its free edge, metres.
const AWAY: f64 = 0.3;

pub fn scenes() -> Vec<LeakScene> {
    let placed = |p: Placement| {
        [(0.05, "5 cm"), (0.6, "60 cm")].map(|(gap, name)| {
            let mut scene = hung(format!("curtain with a gap of {name}, {}", p.name), gap, ROOM[2] + SUNK, p);
            let room = inside_of_box([0.0; 3], ROOM);
            scene.plates(&room);
            scene.ask(&room, &EVEN);
            scene
        })
    };
    [place::ALIGNED, place::TURNED].into_iter().flat_map(placed).collect()
}

/// The sheet from z = `gap` to `end`, and questions behind it.
fn hung(name: String, gap: f64, end: f64, placement: Placement) -> LeakScene {
    let mut scene = LeakScene::new(name, placement, LAMP);
    let sheet = Plate { corner: [AT, -SUNK, gap], u: [0.0, ROOM[1] + 2.0 * SUNK, 0.0], v: [0.0, 0.0, end - gap] };
    scene.plates(&[sheet]);
    let from = gap + AWAY;
    scene.darkness = Darkness::Excess;
    scene.dark = vec![Volume::Box([AT, 0.0, from], ROOM)];
    // The sheet itself, floor and ceiling at its foot, and the wall where it begins.
    let near = inside_of_box([AT, 0.0, from], [AT + 0.5, ROOM[1], ROOM[2]]);
    let asked = if end > ROOM[2] { &[0, 2, 3, 5][..] } else { &[0, 2, 3] };
    scene.ask(asked.iter().map(|&wall| &near[wall]), &[0.001, 0.3, 0.6, 0.9]);
    scene
}

/// The same room without its front, for a picture: what leaves does not come back.
pub fn section() -> LeakScene {
    let mut scene = hung("curtain, cut open".into(), 0.3, ROOM[2], place::ALIGNED);
    let room = &inside_of_box([0.0; 3], ROOM)[..5];
    scene.plates(room);
    scene.ask(room, &EVEN);
    scene
}
