//! Lightmaps: what is written is read, what breaks a rule is refused.

use radfile::{Builder, FLAG_REQUIRED, Lightmap, Mesh, NO_RECEIVER, Record};

use crate::{
    assert_says,
    fixture::{Cube, cube, lightmap, open},
};

/// One way to break a lightmap, and what is said.
type Case = (fn(&mut Lightmap), &'static str);

#[test]
fn a_lightmap_and_the_coordinates_that_a_scene_brings_are_read_as_they_were_written() {
    let (mut cube, lightmap) = (cube(), lightmap());
    cube.mesh.lightmap_uv = cube.mesh.uv.iter().map(|[u, v]| [0.5 * u, 0.5 * v]).collect();
    let mut builder = cube.builder();
    lightmap.write(&mut builder);
    let c = open(&builder);
    assert_eq!(Lightmap::read(&c).expect("legal"), lightmap);
    assert_eq!(Mesh::read(&c).expect("legal"), cube.mesh);
    assert_eq!(c.version(), (1, 3));
    // Lightmaps do not depend on patches, and a reader that does not know them can do without.
    let names = c.sections().iter().filter(|s| s.name.contains("lightmap"));
    assert!(names.map(|s| s.flags).all(|flags| flags == 0));
}

#[test]
fn a_picture_has_at_every_texel_the_value_of_its_receiver() {
    let values: Vec<[f32; 3]> = (1..=6).map(|k| [k as f32, 0.5, -1.0]).collect();
    let reds: Vec<f32> = lightmap().fill(&values).iter().map(|v| v[0]).collect();
    assert_eq!(reds, [1.0, 2.0, 3.0, 3.0, 4.0, 5.0, 6.0, 0.0]);
}

#[test]
fn lightmaps_with_broken_numbers_are_refused() {
    let cases: &[Case] = &[
        (|l| l.corner_uv[3][1][0] = f32::NAN, "lightmap: triangle 3 has corners at [[0.25, 0.0], [NaN, 0.5]"),
        (|l| l.corner_uv[0][2][1] = 1.5, "expected 0 to 1"),
        (|l| l.corner_uv.truncate(11), "lightmap: made for 11 triangles, the mesh has 12"),
        (|l| l.texel[2] = 1, "lightmap: the texels of receivers 1 and 2 do not increase"),
        (|l| l.texel[5] = 7, "lightmap: texel 7 does not show its own receiver 5"),
        (|l| l.texel[5] = 8, "lightmap: texel 8 does not show its own receiver 5"),
        (|l| l.position[4][1] = f32::INFINITY, "lightmap: receiver 4 lies at [0.5, inf, 0.0], expected finite"),
        (|l| l.normal[1] = [0.5, 0.0, 0.0], "lightmap: receiver 1 has normal [0.5, 0.0, 0.0], expected a unit vector"),
        (|l| l.triangle[0] = 12, "lightmap: receiver 0 lies on triangle 12, there are 12"),
        (|l| l.receiver[3] = 6, "lightmap: texel 3 names receiver 6, there are 6"),
        (|l| l.receiver[3] = NO_RECEIVER - 1, "lightmap: texel 3 names receiver 4294967294, there are 6"),
        (|l| l.triangle.truncate(5), "section lightmap.triangle holds u32 [5], expected u32 [6]"),
        (|l| l.position.truncate(5), "section lightmap.position holds f32 [5, 3], expected f32 [6, 3]"),
    ];
    for (break_it, said) in cases {
        let (cube, mut lightmap) = (cube(), lightmap());
        break_it(&mut lightmap);
        let mut builder = cube.builder();
        lightmap.write(&mut builder);
        assert_says(Lightmap::read(&open(&builder)), &[said]);
    }
}

#[test]
fn sizes_that_no_texture_has_are_refused() {
    let read = |width: u32, height: u32, shape: [usize; 2], texels: usize| {
        let cube: Cube = cube();
        let lightmap = lightmap();
        let mut builder = cube.builder();
        lightmap.write(&mut builder);
        builder.meta("lightmap.meta", 0, &(width, height));
        builder.array("lightmap.receiver", 0, &shape, vec![NO_RECEIVER; texels]);
        open(&builder)
    };
    assert_says(Lightmap::read(&read(4, 2, [2, 5], 10)), &["lightmap.receiver holds u32 [2, 5], expected u32 [2, 4]"]);
    let huge = read(u32::MAX, 0, [0, u32::MAX as usize], 0);
    assert_says(Lightmap::read(&huge), &["lightmap: it is 4294967295 × 0 texels, expected 1 to 16384 each"]);
}

#[test]
fn a_lightmap_needs_its_mesh() {
    let lightmap = lightmap();
    let mut builder = Builder::new();
    lightmap.write(&mut builder);
    assert_says(Lightmap::read(&open(&builder)), &["section mesh.triangles is missing"]);
    builder.array("mesh.triangles", FLAG_REQUIRED, &[1, 3], vec![0u32, 1, 2]);
    assert_says(Lightmap::read(&open(&builder)), &["lightmap: made for 12 triangles, the mesh has 1"]);
}
