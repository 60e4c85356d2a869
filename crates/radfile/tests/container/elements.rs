//! Elements and gathered receivers: read as they were written, found where they are, refused where they are broken.

use radfile::{Elements, Gathered, Record, Transfer, Weights};

use crate::{
    assert_says,
    fixture::{cube, elements, gathered, open},
};

#[test]
fn elements_and_gathered_receivers_are_read_as_they_were_written() {
    let (cube, elements, gathered) = (cube(), elements(), gathered());
    let mut builder = cube.builder();
    elements.write(&mut builder);
    gathered.write(&mut builder);
    let c = open(&builder);
    assert_eq!(c.version(), (1, 3));
    assert_eq!(Elements::read_or_whole(&c, &cube.patches).expect("legal"), elements);
    assert_eq!(Transfer::read(&c).expect("legal"), gathered);
}

#[test]
fn a_file_without_elements_has_whole_patches() {
    let cube = cube();
    let elements = Elements::read_or_whole(&open(&cube.builder()), &cube.patches).expect("legal");
    assert_eq!((elements.len(), elements.senders()), (6, 12));
    assert_eq!((0..6).map(|p| elements.at(p, [9.0; 3])).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5]);
    assert_eq!(elements.area, cube.patches.area);
}

/// Cells of half a metre; points that rounding moved out of all cells belong to the nearest.
#[test]
fn a_point_belongs_to_the_element_of_its_cell() {
    let elements = elements();
    assert_eq!(elements.at(1, [0.2, 0.2, 0.0]), 4);
    assert_eq!(elements.at(1, [0.7, 0.2, 0.1]), 5);
    assert_eq!(elements.at(1, [0.7, 0.7, 0.4]), 7);
    assert_eq!(elements.at(1, [0.2, 1.01, 0.0]), 6);
    assert_eq!(elements.at(5, [0.2, 0.2, 0.0]), 20, "the last wall is one element");
}

#[test]
fn a_patch_has_the_mean_of_its_elements_by_area() {
    let mut elements = elements();
    elements.area[..4].copy_from_slice(&[0.1, 0.2, 0.3, 0.4]);
    let light: Vec<[f32; 3]> = (0..elements.len()).map(|e| [e as f32, 1.0, 0.0]).collect();
    let mean = elements.mean(&light);
    assert!((mean[0][0] - 2.0).abs() < 1e-6, "{:?}", mean[0]);
    assert!(mean.iter().all(|m| (m[1] - 1.0).abs() < 1e-6), "{mean:?}");
    assert_eq!(mean[5][0], 20.0);
}

#[test]
fn broken_elements_are_refused() {
    type Case = (fn(&mut Elements), &'static str);
    let cases: &[Case] = &[
        (|e| e.start[2] = 3, "elements: start does not run from 0 to 21"),
        (|e| e.start[2] = 4, "elements: patch 1 has no elements"),
        (|e| e.area[3] = 0.0, "elements: element 3 has area 0, expected a positive number"),
        (|e| e.reflectance[1][2] = 1.0, "elements: element 1 has reflectance"),
        (|e| e.point[4][0] = f32::NAN, "elements: point 4 lies at [NaN"),
        (|e| e.point_face[4] = 24, "elements: point 4 lies on face 24, there are 24"),
        (|e| e.edge[0] = f32::INFINITY, "elements: the cells of patch 0 have an edge of inf"),
        (|e| e.cell_key[1] = 0, "elements: patch 0 has no elements, or cells that do not increase"),
        (|e| e.cell_element[1] = 5, "elements: patch 0 has no elements, or cells that do not increase or name others"),
        (|e| e.grid_origin[1] = f32::NAN, "elements: the grid starts at"),
    ];
    for (break_it, said) in cases {
        let (cube, mut elements) = (cube(), elements());
        break_it(&mut elements);
        let mut builder = cube.builder();
        elements.write(&mut builder);
        assert_says(Elements::read(&open(&builder)), &[said]);
    }
}

#[test]
fn broken_gathered_receivers_are_refused() {
    type Case = (fn(&mut Gathered), &'static str);
    let cases: &[Case] = &[
        (|g| g.sky[3] = 1.5, "gathered rows: receiver 3 sees 1.5 of the sky, expected 0 to 1"),
        (|g| g.sky[3] = f32::NAN, "gathered rows: receiver 3 sees NaN of the sky"),
        (|g| g.sky.truncate(20), "section transfer.sky holds f32 [20], expected f32 [24]"),
        (|g| g.certificate.rays = 0, "gathered rows: illegal certificate"),
        (|g| g.certificate.vis99 = f64::NAN, "gathered rows: illegal certificate"),
        (|g| g.certificate.error_wanted = 2.0, "gathered rows: illegal certificate"),
    ];
    for (break_it, said) in cases {
        let (cube, mut transfer) = (cube(), gathered());
        let Weights::Gathered(rows) = &mut transfer.weights else { panic!("they are gathered") };
        break_it(rows);
        let mut builder = cube.builder();
        transfer.write(&mut builder);
        assert_says(Transfer::read(&open(&builder)), &[said]);
    }
}
