//! A closed box on the floor of a lit room: standing on it, sunk into it, a millimetre above it.

use super::{Darkness, EDGES, EVEN, LeakScene, Placement, Volume, place};
use crate::shapes::{Plate, inside_of_box, outside_of_box};

const ROOM: [f64; 3] = [3.2, 2.4, 3.2];
const LAMP: [f64; 3] = [0.6, 1.9, 0.7];
/// Low x and z, and edge of the box.
const FOOT: [f64; 2] = [1.17, 1.31];
const EDGE: f64 = 0.9;
/// Places under a box that hovers count as dark this far from its edges.
const INSET: f64 = 0.2;

/// How the box stands.
#[derive(Clone, Copy, PartialEq)]
enum Foot {
    /// Its lowest face lies in the floor.
    Standing,
    /// The floor is its lowest face.
    Open,
    /// So far below the floor.
    Sunk(f64),
    /// So far above the floor.
    Hovering(f64),
}

pub fn scenes() -> Vec<LeakScene> {
    let feet = [
        ("standing", Foot::Standing),
        ("standing, without a bottom", Foot::Open),
        ("sunk by 5 mm", Foot::Sunk(0.005)),
        ("sunk by 10 cm", Foot::Sunk(0.1)),
        ("hovering by 1 mm", Foot::Hovering(0.001)),
    ];
    let placed = |p: Placement| feet.map(|(name, foot)| on_floor(format!("box {name}, {}", p.name), foot, p));
    [place::ALIGNED, place::TURNED].into_iter().flat_map(placed).collect()
}

fn on_floor(name: String, foot: Foot, placement: Placement) -> LeakScene {
    let mut scene = LeakScene::new(name, placement, LAMP);
    let room = inside_of_box([0.0; 3], ROOM);
    scene.plates(&room);
    scene.ask(&room, &EVEN);
    add_box(&mut scene, foot, FOOT, true);
    if !matches!(foot, Foot::Hovering(_)) {
        let middle = FOOT.map(|x| x + 0.5 * EDGE);
        scene.eye = Some([[middle[0] + 0.3, 0.6, middle[1] + 0.3], [FOOT[0], 0.2, FOOT[1]]]);
    }
    scene
}

/// A box, its insides as dark places, and questions there; without its front if it is not `whole`.
fn add_box(scene: &mut LeakScene, foot: Foot, [x, z]: [f64; 2], whole: bool) {
    let bottom = match foot {
        Foot::Standing | Foot::Open => 0.0,
        Foot::Sunk(depth) => -depth,
        Foot::Hovering(height) => height,
    };
    let (low, high) = ([x, bottom, z], [x + EDGE, bottom + EDGE, z + EDGE]);
    let built = |number: &usize| (foot != Foot::Open || *number != 2) && (whole || *number != 5);
    let walls: Vec<Plate> = (0..6).filter(built).map(|i| outside_of_box(low, high)[i]).collect();
    scene.plates(&walls);
    scene.dark.push(Volume::Box(low, high));
    let inside = inside_of_box(low, high);
    let asked: Vec<Plate> = (0..6).filter(|i| whole || *i != 5).map(|i| inside[i]).collect();
    scene.ask(&asked, &EDGES);
    if matches!(foot, Foot::Sunk(_)) {
        // The floor goes on inside: both sides of it.
        let floor = inside_of_box([x, 0.0, z], [x + EDGE, 1.0, z + EDGE])[2];
        scene.ask(&[floor, Plate { corner: floor.corner, u: floor.v, v: floor.u }], &EDGES);
    }
    if let Foot::Hovering(height) = foot {
        let (low, high) = ([x + INSET, 0.0, z + INSET], [x + EDGE - INSET, height, z + EDGE - INSET]);
        scene.darkness = Darkness::Excess;
        scene.dark.push(Volume::Box(low, high));
        let gap = inside_of_box(low, high);
        scene.ask(&gap[2..4], &EVEN);
    }
}

/// Three boxes cut open in front together with the room, for a picture: nothing but what is in front could light them.
pub fn section() -> LeakScene {
    let mut scene = LeakScene::new("boxes, cut open".into(), place::ALIGNED, [0.9, 2.1, 1.2]);
    let room = inside_of_box([0.0; 3], [4.4, ROOM[1], ROOM[2]]);
    scene.plates(&room[..5]);
    scene.ask(&room[..5], &EVEN);
    for (x, foot) in [(0.4, Foot::Standing), (1.75, Foot::Sunk(0.1)), (3.1, Foot::Hovering(0.001))] {
        add_box(&mut scene, foot, [x, ROOM[2] - EDGE], false);
    }
    scene
}
