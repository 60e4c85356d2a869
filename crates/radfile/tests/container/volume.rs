//! Irradiance volumes: what is written is read, what breaks a rule is refused.

use radfile::{Builder, Record, Volume};

use crate::{
    assert_says,
    fixture::{open, volume},
};

/// One way to break a volume, and what is said.
type Case = (fn(&mut Volume), &'static str);

fn written(volume: &Volume) -> radfile::Container {
    let mut builder = Builder::new();
    volume.write(&mut builder);
    open(&builder)
}

#[test]
fn a_volume_is_read_as_it_was_written_and_makes_version_1_3() {
    let c = written(&volume());
    assert_eq!(Volume::read(&c).expect("legal"), volume());
    assert_eq!(c.version(), (1, 3));
    // It does not depend on patches, and a reader that does not know it can do without.
    assert!(c.sections().iter().all(|s| s.flags == 0));
}

#[test]
fn a_cell_shows_the_six_values_of_its_probe() {
    let volume = volume();
    assert_eq!((volume.cells(), volume.probes(), volume.receivers()), (8, 5, 30));
    let values: Vec<[f32; 3]> = (0..30).map(|r| [(r / 6) as f32, (r % 6) as f32, -1.0]).collect();
    let filled = volume.fill(&values);
    for (cell, probe) in [0, 1, 1, 2, 3, 3, 4, 2].into_iter().enumerate() {
        assert_eq!(filled[cell], std::array::from_fn(|d| [probe as f32, d as f32, -1.0]), "cell {cell}");
    }
    // Opposite directions are neighbours.
    for pair in Volume::NORMALS.as_chunks::<2>().0 {
        assert_eq!(pair[0], pair[1].map(|x| -x));
    }
}

/// x runs fastest, then y.
#[test]
fn the_middle_of_a_cell_is_where_its_number_says() {
    assert_eq!(volume().middle(6), [0.625, 0.75, 0.5]);
    let moved = Volume { origin: [-2.0, 1.0, 4.0], count: [2, 3, 5], ..volume() };
    assert_eq!(moved.middle(1 + 2 * (2 + 3 * 4)), [-1.625, 2.25, 8.5]);
}

#[test]
fn volumes_with_broken_numbers_are_refused() {
    let cases: &[Case] = &[
        (|v| v.origin[1] = f32::NAN, "volume: cells of [0.25, 0.5, 1.0] from [0.0, NaN, 0.0] on, expected finite"),
        (|v| v.spacing[2] = 0.0, "volume: cells of [0.25, 0.5, 0.0] from"),
        (|v| v.spacing[2] = -1.0, "expected finite numbers and positive edges"),
        (|v| v.spacing[0] = f32::MAX, "expected finite numbers and positive edges"),
        (|v| v.cell[2] = 1, "volume: the cells of probes 1 and 2 do not increase"),
        (|v| v.cell[4] = 8, "volume: probe 4 lies in cell 8, there are 8"),
        (|v| v.cell[4] = u32::MAX, "volume: probe 4 lies in cell 4294967295, there are 8"),
        (|v| v.cell[4] = 5, "volume: probe 4 lies at [0.625, 0.75, 0.5], outside of cell 5"),
        (|v| v.position[3][1] = f32::INFINITY, "volume: probe 3 lies at [0.125, inf, 0.5], outside of cell 4"),
        (|v| v.position[0][0] = -0.01, "volume: probe 0 lies at [-0.01, 0.25, 0.5], outside of cell 0"),
        (|v| v.probe[2] = 5, "volume: cell 2 names probe 5, there are 5"),
        (|v| v.probe[2] = u32::MAX, "volume: cell 2 names probe 4294967295, there are 5"),
        (|v| v.probe[1] = 0, "volume: cell 1 does not show its own probe 1"),
        (|v| v.position.truncate(4), "section volume.position holds f32 [4, 3], expected f32 [5, 3]"),
    ];
    for (break_it, said) in cases {
        let mut volume = volume();
        break_it(&mut volume);
        assert_says(Volume::read(&written(&volume)), &[said]);
    }
}

#[test]
fn a_volume_without_probes_is_refused() {
    let empty = Volume { cell: vec![], position: vec![], ..volume() };
    assert_says(Volume::read(&written(&empty)), &["volume: cell 0 names probe 0, there are 0"]);
}

#[test]
fn boxes_that_no_texture_holds_are_refused() {
    let read = |count: [u32; 3], shape: [usize; 3], cells: usize| {
        let volume = volume();
        let mut builder = Builder::new();
        volume.write(&mut builder);
        builder.meta("volume.meta", 0, &(volume.origin, volume.spacing, count));
        builder.array("volume.probe", 0, &shape, vec![0u32; cells]);
        open(&builder)
    };
    let said = "section volume.probe holds u32 [1, 4, 2], expected u32 [1, 2, 4]";
    assert_says(Volume::read(&read([4, 2, 1], [1, 4, 2], 8)), &[said]);
    let said = "volume: [683, 1, 1] cells, expected 1 to 682 along each axis";
    assert_says(Volume::read(&read([683, 1, 1], [1, 1, 683], 683)), &[said]);
    let huge = read([u32::MAX, 0, 1], [1, 0, u32::MAX as usize], 0);
    assert_says(Volume::read(&huge), &["volume: [4294967295, 0, 1] cells, expected 1 to 682"]);
}
