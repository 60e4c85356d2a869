//! A dark cell in a lit room, asked with normals that tilt as the mean normals of smooth shading do.
//!
//! Light is all around the cell, a millimetre or nothing away. Normals tilt into the cell, as in its own corners, or
//! into the neighbouring wall, as where a mesh is smooth across an edge that it should be split at.

use super::{EDGES, EVEN, LeakScene, Placement, Volume, place};
use crate::{
    shapes::{Plate, dot, inside_of_box, outside_of_box},
    workbench::Point,
};

const ROOM: [f64; 3] = [3.2, 2.4, 3.2];
const LAMP: [f64; 3] = [0.95, 0.4, 1.1];
/// Low and high corner of the cell.
const CELL: [[f64; 3]; 2] = [[1.1, 0.53, 1.2], [2.1, 1.63, 2.2]];

pub fn scenes() -> Vec<LeakScene> {
    let placed = |p: Placement| {
        [(0.0, "a sheet"), (0.001, "1 mm")]
            .map(|(thick, wall)| cell(format!("cell with mean normals, wall {wall}, {}", p.name), thick, p))
    };
    [place::ALIGNED, place::TURNED].into_iter().flat_map(placed).collect()
}

fn cell(name: String, thick: f64, placement: Placement) -> LeakScene {
    let mut scene = LeakScene::new(name, placement, LAMP);
    let room = inside_of_box([0.0; 3], ROOM);
    scene.smooth = true;
    scene.plates(&room);
    scene.ask(&room, &EVEN);
    let [low, high] = CELL;
    let walls = inside_of_box(low, high);
    scene.plates(&outside_of_box(low.map(|x| x - thick), high.map(|x| x + thick)));
    if thick > 0.0 {
        scene.plates(&walls);
    }
    scene.dark = vec![Volume::Box(low, high)];
    for wall in &walls {
        tilted(&mut scene, wall, &walls);
    }
    scene.eye = Some([[1.9, 1.4, 2.0], low]);
    scene
}

/// Questions near the edges of a wall: its normal, and means of it with a neighbour's, turned either way.
fn tilted(scene: &mut LeakScene, wall: &Plate, walls: &[Plate; 6]) {
    let own = wall.normal();
    for neighbour in walls.iter().map(Plate::normal).filter(|n| dot(*n, own).abs() < 0.5) {
        for way in [0.7, -0.7] {
            let mean: [f64; 3] = std::array::from_fn(|a| own[a] + way * neighbour[a]);
            let normal = mean.map(|x| x / dot(mean, mean).sqrt());
            let places = [EDGES[0], 0.5, EDGES[4]];
            let at = |s: f64| places.map(|t| Point { position: wall.at(s, t), normal });
            scene.points.extend(places.into_iter().flat_map(at));
        }
    }
}
