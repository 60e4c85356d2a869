//! The insides of closed solids in a lit room.

use super::{EDGES, EVEN, LeakScene, Placement, Volume, place};
use crate::{
    mesh_text::MeshText,
    shapes::{Facing, inside_of_box, outside_of_box, sphere},
    workbench::Point,
};

const ROOM: [f64; 3] = [3.2, 2.4, 3.2];
const LAMP: [f64; 3] = [0.5, 1.9, 0.6];
/// Metres that a plank is thick: less than a voxel.
const PLANK: f64 = 0.03;

pub fn scenes() -> Vec<LeakScene> {
    let placed = |p: Placement| [ball(p), nested(p), crossed(p)];
    [place::ALIGNED, place::TURNED].into_iter().flat_map(placed).collect()
}

fn room(name: &str, placement: Placement) -> LeakScene {
    let mut scene = LeakScene::new(format!("{name}, {}", placement.name), placement, LAMP);
    let room = inside_of_box([0.0; 3], ROOM);
    scene.plates(&room);
    scene.ask(&room, &EVEN);
    scene
}

/// A ball of many small faces.
fn ball(placement: Placement) -> LeakScene {
    const CENTRE: [f64; 3] = [1.7, 1.2, 1.8];
    const RADIUS: f64 = 0.6;
    let mut scene = room("inside of a ball", placement);
    let mut mesh = MeshText::default();
    sphere(&mut mesh, super::WALL, RADIUS, [12, 24, 0], Facing::Outwards);
    for face in mesh.faces() {
        let corners: Vec<[f64; 3]> = face.iter().map(|c| std::array::from_fn(|a| c[a] + CENTRE[a])).collect();
        let middle: [f64; 3] =
            std::array::from_fn(|a| corners.iter().map(|c| c[a]).sum::<f64>() / corners.len() as f64);
        let inwards: [f64; 3] = std::array::from_fn(|a| CENTRE[a] - middle[a]);
        scene.points.push(Point { position: middle, normal: inwards });
        scene.faces.push(corners);
    }
    scene.dark = vec![Volume::Ball { centre: CENTRE, radius: RADIUS }];
    scene.eye = Some([CENTRE, [CENTRE[0], CENTRE[1], 0.0]]);
    scene
}

/// A box in a box, the outer one a plank thick.
fn nested(placement: Placement) -> LeakScene {
    let mut scene = room("inside of a box with a box in it", placement);
    let (low, high) = ([1.0, 0.5, 1.1], [2.2, 1.6, 2.3]);
    let (inner_low, inner_high) = (low.map(|x| x + PLANK), high.map(|x| x - PLANK));
    let (core_low, core_high) = (low.map(|x| x + 0.4), high.map(|x| x - 0.3));
    scene.plates(&outside_of_box(low, high));
    scene.plates(&inside_of_box(inner_low, inner_high));
    scene.plates(&outside_of_box(core_low, core_high));
    scene.ask(&inside_of_box(inner_low, inner_high), &EDGES);
    scene.ask(&outside_of_box(core_low, core_high), &EDGES);
    scene.ask(&inside_of_box(core_low, core_high), &EDGES);
    scene.dark = vec![Volume::Box(low, high)];
    scene.eye = Some([[2.05, 1.45, 2.1], low]);
    scene
}

/// Two planks that cross each other: faces of each go through the inside of the other.
fn crossed(placement: Placement) -> LeakScene {
    let mut scene = room("insides of crossed planks", placement);
    let planks = [([0.5, 0.9, 1.5], [2.7, 0.9 + PLANK, 1.9]), ([1.6, 0.3, 0.9], [1.6 + PLANK, 2.0, 2.6])];
    for (low, high) in planks {
        scene.plates(&outside_of_box(low, high));
        scene.ask(&inside_of_box(low, high), &EDGES);
        scene.dark.push(Volume::Box(low, high));
    }
    scene
}
