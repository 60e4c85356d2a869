//! OBJ files made on the spot, and what becomes of them.

mod import_support;

use import_support::{Memory, area, corners, png};
use radfile::Wrap;
use scene::Surfaces;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0.25 1\nvt 0.75 0\n";

fn obj(text: &str) -> Memory {
    Memory::default().with("s.obj", format!("{SQUARE}{text}"))
}

#[test]
fn faces_keep_their_order_and_winding_across_materials_and_groups() {
    let mtl = "newmtl red\nKd 0.6 0.1 0.1\nnewmtl two words\nKd 0.2 0.2 0.2\nKe 3 2 1\n";
    let text = "mtllib m.mtl\ng first\nusemtl red\nf 1 2 3\no other\nusemtl two words\nf 1 3 4\nusemtl red\nf 4 3 2\n";
    let (scene, report) = obj(text).with("m.mtl", mtl).import("s.obj").unwrap();
    let [a, b, c, d] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    assert_eq!(corners(&scene), [[a, b, c], [a, c, d], [d, c, b]]);
    assert_eq!(scene.mesh.triangle_material, [0, 1, 0]);
    let m = &scene.materials.materials;
    assert_eq!((m[0].reflectance, m[1].emission, m[1].name.as_str()), ([0.6, 0.1, 0.1], [3.0, 2.0, 1.0], "two words"));
    assert_eq!(Surfaces::new(&scene.mesh, &scene.materials).unwrap().emitters(), [1]);
    assert!(report.warnings.is_empty() && scene.mesh.uv.is_empty(), "{:?}", report.warnings);
}

#[test]
fn concave_faces_cover_their_area_once() {
    let l = "v 0 0 0\nv 3 0 0\nv 3 0 -1\nv 1 0 -1\nv 1 0 -3\nv 0 0 -3\n";
    for start in 0..6 {
        let face: Vec<String> = (0..6).map(|k| ((k + start) % 6 + 1).to_string()).collect();
        let text = format!("{l}f {}\n", face.join(" "));
        let (scene, report) = Memory::default().with("s.obj", text).import("s.obj").unwrap();
        assert_eq!((report.triangles, area(&scene)), (4, 5.0), "from corner {start}");
    }
}

#[test]
fn one_bad_face_does_not_cost_the_file() {
    let text = "v nan 0 0\nf 1 2 3\nf 1 2 99\nf 1 2 5\nf 1 2\nf 1 x 3\nl 1 2\nf 1 3 4\n";
    let (scene, report) = obj(text).import("s.obj").unwrap();
    assert_eq!((report.triangles, area(&scene)), (2, 1.0));
    let said = [
        "vertices that are not three finite numbers: 1",
        "lines and points are ignored: 1",
        "faces with fewer than three corners are dropped: 1",
        "faces that cannot be read are dropped: 1",
        "faces with an index out of range are dropped: 1",
        "faces with a vertex that is not three finite numbers are dropped: 1",
        "faces without a material are grey 0.5",
    ];
    assert_eq!(report.warnings, said);
    assert_eq!(scene.materials.materials[0].reflectance, [0.5; 3]);
}

#[test]
fn libraries_may_be_several_on_one_line_and_one_may_be_missing() {
    let text =
        "mtllib a.mtl gone.mtl\nmtllib my lib.mtl\nusemtl one\nf 1 2 3\nusemtl two\nf 1 3 4\nusemtl three\nf 4 3 1\n";
    let folder = obj(text).with("a.mtl", "newmtl one\nKd 0.1 0.1 0.1").with("my lib.mtl", "newmtl two\nKd 0.2 0.2 0.2");
    let (scene, report) = folder.import("s.obj").unwrap();
    let greys: Vec<f32> = scene.materials.materials.iter().map(|m| m.reflectance[0]).collect();
    assert_eq!(greys, [0.1, 0.2, 0.5]);
    assert_eq!(report.warnings[0], "material libraries are missing: gone.mtl");
    assert_eq!(report.warnings[1], "materials are not defined and are grey 0.5: three");
}

fn with_mtl(mtl: &str) -> (scene::Scene, scene::ImportReport) {
    let text = "mtllib maps/m.mtl\nusemtl m\nf 1/1 2/1 3/2\n";
    let image = png(&[[0, 0, 0], [255, 255, 255]]);
    obj(text).with("maps/m.mtl", mtl).with("maps/Two.png", image).import("s.obj").unwrap()
}

#[test]
fn maps_are_found_beside_their_library_and_v_counts_from_the_bottom() {
    let (scene, report) = with_mtl("newmtl m\nKd 0.5 0.5 0.5\nmap_Kd -clamp on Two.png\nmap_Ke Two.png\nKe 4 4 4\n");
    assert!(report.warnings.is_empty(), "{:?}", report.warnings);
    assert_eq!(scene.mesh.uv, [[0.25, 0.0], [0.25, 0.0], [0.75, 1.0]]);
    assert_eq!(scene.mesh.emission_uv.len(), 0);
    let wraps: Vec<Wrap> = scene.materials.textures.iter().map(|t| t.wrap[0]).collect();
    assert_eq!(wraps, [Wrap::Clamp, Wrap::Repeat]);
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials).unwrap();
    assert_eq!((surfaces.reflectance(0, 0.0, 1.0), surfaces.emission(0, 0.0, 1.0)), ([0.5; 3], [4.0; 3]));
    assert_eq!((surfaces.reflectance(0, 0.0, 0.0), surfaces.emission(0, 0.0, 0.0)), ([0.0; 3], [0.0; 3]));
}

#[test]
fn a_map_without_a_colour_is_the_whole_colour() {
    let (scene, _) = with_mtl("newmtl m\nmap_Kd Two.png\nmap_Ke Two.png\n");
    let surfaces = Surfaces::new(&scene.mesh, &scene.materials).unwrap();
    assert_eq!((surfaces.reflectance(0, 0.0, 1.0), surfaces.emission(0, 0.0, 1.0)), ([0.99; 3], [1.0; 3]));
}

#[test]
fn maps_in_the_wrong_case_are_found_and_missing_ones_leave_the_colour() {
    let (scene, report) = with_mtl("newmtl m\nKd 0.5 0.5 0.5\nmap_Kd TWO.PNG\n");
    assert_eq!(scene.materials.textures.len(), 1);
    assert_eq!(report.warnings[0], "files were found only under a name in another case: TWO.PNG");
    let (scene, report) = with_mtl("newmtl m\nKd 0.5 0.5 0.5\nmap_Kd gone.png\n");
    assert_eq!(scene.materials.materials[0].reflectance_texture, None);
    assert_eq!(report.warnings[0], "textures are missing, the plain colour of their materials is used: gone.png");
}

#[test]
fn colours_that_reflect_everything_are_clamped_by_name() {
    let (scene, report) = with_mtl("newmtl m\nKd 1 1 1\n");
    assert_eq!(scene.materials.materials[0].reflectance, [scene::MAX_REFLECTANCE; 3]);
    assert_eq!(report.warnings, ["reflectance is clamped to 0.99 in materials: m"]);
    let (_, report) = with_mtl("newmtl m\nKs 1 1 1\nd 0.3\nbump b.png\n");
    let said = [
        "gloss is ignored, surfaces are diffuse; materials: 1",
        "transparency is ignored, surfaces are opaque; materials: 1",
        "bump and normal maps are ignored; materials: 1",
        "materials without Kd are grey 0.5: m",
    ];
    assert_eq!(report.warnings, said);
}

#[test]
fn files_without_faces_are_empty() {
    for (text, detail) in [("", "it has no faces"), ("v 0 0 0\n", "it has no faces")] {
        let error = Memory::default().with("s.obj", text).import("s.obj").unwrap_err().to_string();
        assert_eq!(error, format!("s.obj: no usable triangle ({detail})"));
    }
    let error = obj("f 1 2\nf 1 1 2\n").import("s.obj").unwrap_err().to_string();
    assert!(error.contains("(faces with fewer than three corners are dropped: 1; "), "{error}");
    assert!(error.contains("triangles without area are dropped: 1"), "{error}");
}
