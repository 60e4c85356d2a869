//! The Cornell box from its published measurements.
//!
//! Source: Cornell University Program of Computer Graphics, "The Cornell Box: physical model data"
//! (1984, 1998): corners in millimetres, spectral reflectances; the colours here are their usual
//! reduction to linear RGB. Two departures: metres, and the ceiling is cut around the lamp instead
//! of lying in the same plane behind it.

use crate::mesh_text::{MeshText, Paint};

const WHITE: Paint = Paint::matt("white", [0.725, 0.71, 0.68]);
const RED: Paint = Paint::matt("red", [0.63, 0.065, 0.05]);
const GREEN: Paint = Paint::matt("green", [0.14, 0.45, 0.091]);
const LAMP: Paint = Paint { name: "lamp", reflectance: [0.78, 0.78, 0.78], emission: [17.0, 12.0, 4.0] };

/// Height of the ceiling, mm.
const TOP: f64 = 548.8;

/// Walls, lamp and blocks, every front towards the room.
pub fn scene() -> MeshText {
    let mut mesh = MeshText::default();
    let mut quad = |paint: Paint, corners: [[f64; 3]; 4]| mesh.polygon(paint, &corners.map(|c| c.map(|x| x / 1000.0)));
    quad(WHITE, [[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]]);
    quad(WHITE, [[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, TOP, 559.2], [556.0, TOP, 559.2]]);
    quad(GREEN, [[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, TOP, 0.0], [0.0, TOP, 559.2]]);
    quad(RED, [[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, TOP, 559.2], [556.0, TOP, 0.0]]);
    let [outer, lamp] = [rectangle(0.0, 556.0, 0.0, 559.2), rectangle(213.0, 343.0, 227.0, 332.0)];
    quad(LAMP, lamp);
    for side in 0..4 {
        let next = (side + 1) % 4;
        quad(WHITE, [outer[side], outer[next], lamp[next], lamp[side]]);
    }
    let short = [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]];
    let tall = [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]];
    for (foot, height) in [(short, 165.0), (tall, 330.0)] {
        quad(WHITE, foot.map(|[x, z]| [x, height, z]));
        for side in 0..4 {
            let ([ax, az], [bx, bz]) = (foot[side], foot[(side + 1) % 4]);
            quad(WHITE, [[bx, 0.0, bz], [bx, height, bz], [ax, height, az], [ax, 0.0, az]]);
        }
    }
    mesh
}

/// A rectangle at the ceiling's height that faces down.
fn rectangle(x0: f64, x1: f64, z0: f64, z1: f64) -> [[f64; 3]; 4] {
    [[x1, TOP, z0], [x1, TOP, z1], [x0, TOP, z1], [x0, TOP, z0]]
}
