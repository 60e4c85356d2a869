//! No light passes a wall, however thin.

use allbounce_tests::{
    mesh_text::{MeshText, Paint},
    shapes::{Plate, inside_of_box},
    workbench::{Point, Workbench},
};
use serde_json::json;

/// Two rooms of 3 × 3 × 2.5 m, the wall between them `thick`; voxels are 0.4 m.
fn assert_dark(thick: f64) {
    let wall = Paint::matt("wall", [0.9; 3]);
    let (lit, dark) =
        (inside_of_box([0.0; 3], [3.0, 3.0, 2.5]), inside_of_box([3.0 + thick, 0.0, 0.0], [6.0 + thick, 3.0, 2.5]));
    let mut mesh = MeshText::default();
    lit.iter().for_each(|w| w.add(&mut mesh, wall));
    // Where the wall is a single sheet, the lit room's stands for both.
    dark.iter().skip(usize::from(thick == 0.0)).for_each(|w| w.add(&mut mesh, wall));
    let bench = Workbench::new(&mesh);
    bench.bake(&["--voxel", "0.4m", "--rays", "1024"]);
    bench.verify();

    let lamp = json!({ "type": "point", "position": [2.9, 1.5, 1.2], "intensity": [100, 100, 100] });
    // Edges and corners within a millimetre.
    let steps = [0.0004, 0.03, 0.5, 0.97, 0.9996];
    let on = |wall: &Plate| {
        let (wall, normal) = (*wall, wall.normal());
        steps.into_iter().flat_map(move |s| steps.map(|t| Point { position: wall.at(s, t), normal }))
    };
    let points: Vec<Point> = lit.iter().chain(&dark).flat_map(on).collect();
    let half = points.len() / 2;
    for options in [&[][..], &["--bounces", "50"], &["--transfer", "interpolate"]] {
        for light in bench.relight(&json!({ "lights": [lamp] }), &points, options) {
            for (i, point) in points.iter().enumerate().skip(half) {
                assert_eq!(light.direct[i], 0.0, "direct light passed a wall of {thick} m to {point:?}");
                assert_eq!(light.indirect[i], 0.0, "light passed a wall of {thick} m to {point:?}, {options:?}");
            }
            assert!(light.indirect[..half].iter().all(|&e| e > 1.0), "the lit room is lit");
        }
    }
}

#[test]
fn a_sealed_room_behind_a_wall_of_two_millimetres_is_exactly_dark() {
    assert_dark(0.002);
}

#[test]
fn a_sealed_room_behind_a_single_sheet_is_exactly_dark() {
    assert_dark(0.0);
}
