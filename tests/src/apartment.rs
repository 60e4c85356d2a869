//! The bundled apartment: five rooms joined by doors, one window, furniture and columns.
//!
//! Walls and furniture are boxes. All of their planes together cut space into a grid of cells;
//! a cell is solid or air, and a face is made wherever the two meet. So the mesh has no
//! T-junctions, no coincident faces and no inside of furniture. A turned crate, a bench and round
//! columns are added on top, open below where they stand on the floor.

use crate::mesh_text::{MeshText, Paint};

const PLASTER: Paint = Paint::matt("plaster", [0.78, 0.77, 0.74]);
const WOOD: Paint = Paint::matt("wood", [0.42, 0.27, 0.15]);
const OCHRE: Paint = Paint::matt("ochre", [0.72, 0.45, 0.12]);
const BLUE: Paint = Paint::matt("blue", [0.16, 0.28, 0.58]);
const GREEN: Paint = Paint::matt("green", [0.22, 0.5, 0.2]);
const RED: Paint = Paint::matt("red", [0.6, 0.12, 0.09]);
const DARK: Paint = Paint::matt("dark", [0.09, 0.09, 0.1]);
const WHITE: Paint = Paint::matt("white", [0.85, 0.85, 0.85]);
const LAMP: Paint = Paint { name: "lamp", reflectance: [0.8, 0.8, 0.8], emission: [12.0, 10.5, 8.0] };

/// An axis-aligned box: lower and upper corner.
type Cuboid = [[f64; 3]; 2];

/// What a box does to the cells that it covers.
#[derive(Clone, Copy)]
enum Act {
    Fill(Paint),
    Carve,
    /// Only repaints cells that are solid already.
    Paint(Paint),
}

const fn cuboid(x: [f64; 2], y: [f64; 2], z: [f64; 2]) -> Cuboid {
    [[x[0], y[0], z[0]], [x[1], y[1], z[1]]]
}

/// Boxes in the order in which they act; metres, floor at y = 0, ceiling at 2.6.
fn boxes() -> Vec<(Cuboid, Act)> {
    use Act::*;
    let air = |x, z| (cuboid(x, [0.0, 2.6], z), Carve);
    let door = |x, z| (cuboid(x, [0.0, 2.1], z), Carve);
    let fill = |x, y, z, paint| (cuboid(x, y, z), Fill(paint));
    vec![
        (cuboid([0.0, 10.6], [-0.2, 2.8], [0.0, 8.6]), Fill(PLASTER)),
        (cuboid([0.0, 10.6], [-0.2, 0.0], [0.0, 8.6]), Paint(WOOD)),
        // living room, hall, kitchen, bedroom, bath
        air([0.2, 6.0], [0.2, 5.0]),
        air([0.2, 6.0], [5.2, 6.6]),
        air([6.2, 10.4], [0.2, 3.4]),
        air([6.2, 10.4], [3.6, 8.4]),
        air([0.2, 6.0], [6.8, 8.4]),
        // doors: living-hall, living-kitchen, hall-bedroom, hall-bath; a window in the living room
        door([2.4, 3.4], [5.0, 5.2]),
        door([6.0, 6.2], [1.2, 2.2]),
        door([6.0, 6.2], [5.5, 6.4]),
        door([4.6, 5.4], [6.6, 6.8]),
        (cuboid([0.0, 0.2], [0.9, 2.2], [1.4, 3.8]), Carve),
        // coloured walls: solid layers behind the rooms' faces
        (cuboid([0.2, 2.4], [0.0, 2.6], [5.0, 5.1]), Paint(RED)),
        (cuboid([10.4, 10.6], [0.0, 2.6], [3.6, 8.4]), Paint(BLUE)),
        (cuboid([6.2, 10.4], [0.0, 2.6], [0.0, 0.2]), Paint(OCHRE)),
        (cuboid([0.2, 4.6], [0.0, 2.6], [8.4, 8.6]), Paint(GREEN)),
        // lamps flush with the ceilings of kitchen and bedroom
        (cuboid([7.8, 8.8], [2.6, 2.7], [1.4, 2.2]), Paint(LAMP)),
        (cuboid([8.0, 8.6], [2.6, 2.7], [5.8, 6.4]), Paint(LAMP)),
        // living room: sofa, low table on legs, shelf, square column
        fill([4.9, 5.8], [0.0, 0.45], [2.6, 4.6], RED),
        fill([5.6, 5.8], [0.45, 0.9], [2.6, 4.6], RED),
        fill([2.6, 3.8], [0.36, 0.42], [2.0, 2.8], WOOD),
        fill([2.6, 2.7], [0.0, 0.36], [2.0, 2.1], WOOD),
        fill([3.7, 3.8], [0.0, 0.36], [2.0, 2.1], WOOD),
        fill([2.6, 2.7], [0.0, 0.36], [2.7, 2.8], WOOD),
        fill([3.7, 3.8], [0.0, 0.36], [2.7, 2.8], WOOD),
        fill([0.2, 0.6], [0.0, 1.9], [4.2, 5.0], WOOD),
        fill([4.2, 4.5], [0.0, 2.6], [0.9, 1.2], PLASTER),
        // kitchen: counter, cupboard, table
        fill([9.8, 10.4], [0.0, 0.9], [0.2, 3.0], WHITE),
        fill([6.2, 6.8], [0.0, 2.0], [2.6, 3.4], DARK),
        fill([7.6, 8.8], [0.68, 0.76], [1.2, 2.4], WOOD),
        fill([8.1, 8.3], [0.0, 0.68], [1.7, 1.9], WOOD),
        // bedroom: bed, wardrobe; hall: shoe chest; bath: tub rim
        fill([8.4, 10.4], [0.0, 0.5], [6.6, 8.2], WHITE),
        fill([6.2, 6.8], [0.0, 2.1], [7.0, 8.4], WOOD),
        fill([0.2, 0.6], [0.0, 0.8], [5.6, 6.4], OCHRE),
        fill([0.2, 1.8], [0.0, 0.55], [7.6, 8.4], WHITE),
        (cuboid([0.3, 1.7], [0.15, 0.55], [7.7, 8.3]), Carve),
    ]
}

/// The whole apartment.
pub fn scene() -> MeshText {
    let mut mesh = MeshText::default();
    add_cells(&mut mesh, &boxes());
    add_turned_box(&mut mesh, WHITE, [1.5, 0.9], [0.35, 0.35], 0.7, 0.45);
    add_turned_box(&mut mesh, OCHRE, [7.2, 4.6], [0.5, 0.25], 0.45, -0.6);
    for x in [1.6, 3.9] {
        add_column(&mut mesh, PLASTER, [x, 5.9], 0.16, 2.6);
    }
    add_column(&mut mesh, DARK, [7.6, 5.0], 0.12, 2.6);
    mesh
}

/// Faces between solid and air cells of the grid that all box planes make.
fn add_cells(mesh: &mut MeshText, boxes: &[(Cuboid, Act)]) {
    let planes: [Vec<f64>; 3] = std::array::from_fn(|axis| {
        let mut planes: Vec<f64> = boxes.iter().flat_map(|(b, _)| [b[0][axis], b[1][axis]]).collect();
        planes.sort_by(f64::total_cmp);
        planes.dedup();
        planes
    });
    let solid = |cell: [i64; 3]| -> Option<Paint> {
        let mut centre = [0.0; 3];
        for axis in 0..3 {
            let at = usize::try_from(cell[axis]).ok()?;
            centre[axis] = 0.5 * (planes[axis].get(at)? + planes[axis].get(at + 1)?);
        }
        let mut state = None;
        for (b, act) in boxes {
            if (0..3).all(|a| b[0][a] < centre[a] && centre[a] < b[1][a]) {
                state = match act {
                    Act::Fill(paint) => Some(*paint),
                    Act::Carve => None,
                    Act::Paint(paint) => state.map(|_| *paint),
                };
            }
        }
        state
    };
    let count = planes.each_ref().map(|p| p.len() as i64 - 1);
    for k in 0..count[2] {
        for j in 0..count[1] {
            for i in 0..count[0] {
                let cell = [i, j, k];
                let Some(paint) = solid(cell) else { continue };
                for axis in 0..3 {
                    for step in [-1, 1] {
                        let mut beside = cell;
                        beside[axis] += step;
                        if solid(beside).is_none() {
                            mesh.polygon(paint, &face(&planes, cell, axis, step > 0));
                        }
                    }
                }
            }
        }
    }
}

/// One face of a cell, counter-clockwise seen from outside of the cell.
fn face(planes: &[Vec<f64>; 3], cell: [i64; 3], axis: usize, upper: bool) -> [[f64; 3]; 4] {
    let (s, t) = ((axis + 1) % 3, (axis + 2) % 3);
    let corner = |ds: usize, dt: usize| {
        let mut corner = [0.0; 3];
        corner[axis] = planes[axis][cell[axis] as usize + usize::from(upper)];
        corner[s] = planes[s][cell[s] as usize + ds];
        corner[t] = planes[t][cell[t] as usize + dt];
        corner
    };
    let ring = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
    if upper { ring } else { [ring[0], ring[3], ring[2], ring[1]] }
}

/// A box of given half extents that stands on the floor, turned about the vertical.
fn add_turned_box(mesh: &mut MeshText, paint: Paint, centre: [f64; 2], half: [f64; 2], height: f64, angle: f64) {
    let (sin, cos) = angle.sin_cos();
    let foot = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]].map(|[a, b]: [f64; 2]| {
        let (x, z) = (a * half[0], b * half[1]);
        [centre[0] + cos * x + sin * z, centre[1] - sin * x + cos * z]
    });
    mesh.polygon(paint, &foot.map(|[x, z]| [x, height, z]));
    add_sides(mesh, paint, &foot, height);
}

/// A twelve-sided column from floor to ceiling.
fn add_column(mesh: &mut MeshText, paint: Paint, centre: [f64; 2], radius: f64, height: f64) {
    let ring: Vec<[f64; 2]> = (0..12)
        .map(|k| {
            let angle = f64::from(k) * std::f64::consts::TAU / 12.0;
            [centre[0] + radius * angle.sin(), centre[1] + radius * angle.cos()]
        })
        .collect();
    add_sides(mesh, paint, &ring, height);
}

/// Vertical sides over a ring that turns counter-clockwise seen from above.
fn add_sides(mesh: &mut MeshText, paint: Paint, ring: &[[f64; 2]], height: f64) {
    for (k, &[ax, az]) in ring.iter().enumerate() {
        let [bx, bz] = ring[(k + 1) % ring.len()];
        mesh.polygon(paint, &[[ax, 0.0, az], [bx, 0.0, bz], [bx, height, bz], [ax, height, az]]);
    }
}
