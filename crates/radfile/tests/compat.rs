//! Files that earlier versions wrote are read for ever, with the meaning that they had.

#[path = "fixture/mod.rs"]
mod fixture;

use std::path::{Path, PathBuf};

use fixture::{
    Extras, accuracy, certified, cube, elements, every_feature, gathered, gathered_by_lightmap, gathered_by_volume,
    half, hierarchical, lightmap, operators, parted_floor, patches_of_a_parted_floor, receivers_that_gather, volume,
};
use radfile::{
    Accuracy, BlockFormat, Container, Elements, FLAG_PATCH_ORDER, FormFactors, Gathered, HierarchicalOperator,
    Lightmap, Materials, Mesh, Operator, PackedOperator, Patches, Permutation, Provenance, Record, Transfer, ValueMap,
    Volume, digest,
};

/// BLAKE3 of each file, so that none is made again by accident.
const FILES: [(&str, &str); 4] = [
    ("minimal.rad", "b3706c531aef15d92d918d66c691ee466d6744178c51142c336c1d4ddad38b04"),
    ("cube.rad", "2f4525df317196d0c14b161f0346b6386228cfabac208013fd45a22bd806cc36"),
    ("cube-bc1.rad", "10d145108335187f2886bbfaf0209fe3e76a1f82d1c372232d95df74cc9a9d7d"),
    ("every-feature.rad", "cf85602b154f76204f72a277faba1cfa88353ec92e3292e04454f831eb014893"),
];

const PARTED_FLOOR: &str = "9412d0702a70d18e5391d5eab844efb0739f244a98e0f399586c146a26460860";

const OPERATORS: &str = "19ba957c89e07036f96054790c6c590ad271c856d2d6b7b8047c310eb3d4abb9";

const GATHERED: &str = "ff8e6e32d3f06ffcced4a1ccd0cdb8e48b6108ae24073325f1777ac19ffed5e2";

const CERTIFIED: &str = "56e801bdd89280f81bbb9e947f79331def88b3d86cdfbc976e6b7343bb6d9a6f";

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/compat/1.0")
}

fn open(name: &str) -> Container {
    Container::open(&folder().join(name)).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn files_of_version_1_0_are_the_ones_that_were_written_then() {
    let version = std::fs::read_to_string(folder().join("VERSION")).expect("it says who wrote the folder");
    assert_eq!(version.trim(), "container 1.0");
    for (name, expected) in FILES {
        assert_eq!(digest(open(name).as_bytes()), expected, "{name} is not the file that version 1.0 wrote");
        assert_eq!(open(name).version(), (1, 0));
    }
}

#[test]
fn every_file_of_the_folder_is_listed_here() {
    let entries = std::fs::read_dir(folder()).expect("the folder is there");
    let names = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter(|n| n.ends_with(".rad")).collect();
    let mut listed = FILES.map(|(name, _)| name);
    names.sort();
    listed.sort();
    assert_eq!(names, listed);
    assert_eq!(std::fs::read_dir(folder().join("../1.1")).expect("the folder is there").count(), 2);
}

#[test]
fn the_file_of_version_1_1_is_the_one_that_was_written_then_and_is_read() {
    let folder = folder().join("../1.1");
    let version = std::fs::read_to_string(folder.join("VERSION")).expect("it says who wrote the folder");
    assert_eq!(version.trim(), "container 1.1");
    let c = Container::open(&folder.join("parted-floor.rad")).expect("legal");
    assert_eq!(c.version(), (1, 1));
    assert_eq!(digest(c.as_bytes()), PARTED_FLOOR, "this is not the file that version 1.1 wrote");
    assert_eq!(c.as_bytes(), parted_floor().as_bytes(), "version 1.1 is still what is written");
    let patches = Patches::read(&c).expect("legal");
    assert_eq!(patches, patches_of_a_parted_floor());
    // The front of triangle 9, the half of the floor with its corner at (0, 1).
    let [near, far] = [[0.1, 0.3, 0.0], [0.6, 0.9, 0.0]].map(|p| patches.locator.patch_at(18, p).expect("a patch"));
    assert_eq!(
        (patches.position[near as usize], patches.position[far as usize]),
        ([0.25, 0.25, 0.0], [0.75, 0.75, 0.0])
    );
}

#[test]
fn the_file_of_version_1_2_is_the_one_that_was_written_then_and_is_read() {
    let folder = folder().join("../1.2");
    let version = std::fs::read_to_string(folder.join("VERSION")).expect("it says who wrote the folder");
    assert_eq!(version.trim(), "container 1.2");
    assert_eq!(std::fs::read_dir(&folder).expect("the folder is there").count(), 2);
    let c = Container::open(&folder.join("operators.rad")).expect("legal");
    assert_eq!(c.version(), (1, 2));
    assert_eq!(digest(c.as_bytes()), OPERATORS, "this is not the file that version 1.2 wrote");
    assert_eq!(c.as_bytes(), operators().as_bytes(), "version 1.2 is still what is written");
    assert_eq!(HierarchicalOperator::read(&c).expect("legal"), hierarchical());
    assert_eq!(PackedOperator::read(&c).expect("legal"), half());
}

#[test]
fn the_file_of_version_1_3_is_the_one_that_was_written_then_and_is_read() {
    let folder = folder().join("../1.3");
    let version = std::fs::read_to_string(folder.join("VERSION")).expect("it says who wrote the folder");
    assert_eq!(version.trim(), "container 1.3");
    assert_eq!(std::fs::read_dir(&folder).expect("the folder is there").count(), 2);
    let c = Container::open(&folder.join("gathered.rad")).expect("legal");
    assert_eq!(c.version(), (1, 3));
    assert_eq!(digest(c.as_bytes()), GATHERED, "this is not the file that version 1.3 wrote");
    assert_eq!(c.as_bytes(), receivers_that_gather().as_bytes(), "version 1.3 is still what is written");
    assert_eq!(Mesh::read(&c).expect("legal").lightmap_uv.len(), 24);
    assert_eq!(Elements::read(&c).expect("legal"), elements());
    assert_eq!(Transfer::read(&c).expect("legal"), gathered());
    assert_eq!(Lightmap::read(&c).expect("legal"), lightmap());
    assert_eq!(Gathered::read(&c, Lightmap::PREFIX, 6).expect("legal"), gathered_by_lightmap());
    assert_eq!(Volume::read(&c).expect("legal"), volume());
    assert_eq!(Gathered::read(&c, Volume::PREFIX, 30).expect("legal"), gathered_by_volume());
}

#[test]
fn the_file_of_version_1_4_is_the_one_that_was_written_then_and_is_read() {
    let folder = folder().join("../1.4");
    let version = std::fs::read_to_string(folder.join("VERSION")).expect("it says who wrote the folder");
    assert_eq!(version.trim(), "container 1.4");
    assert_eq!(std::fs::read_dir(&folder).expect("the folder is there").count(), 2);
    let c = Container::open(&folder.join("certified.rad")).expect("legal");
    assert_eq!(c.version(), (1, 4));
    assert_eq!(digest(c.as_bytes()), CERTIFIED, "this is not the file that version 1.4 wrote");
    assert_eq!(c.as_bytes(), certified().as_bytes(), "version 1.4 is still what is written");
    assert_eq!(Accuracy::read(&c).expect("legal"), accuracy());
}

#[test]
fn the_minimal_file_is_read() {
    let c = open("minimal.rad");
    assert_eq!(Permutation::read(&c).expect("legal").new_to_old(), [2, 0, 1]);
    let steps = Provenance::read(&c).expect("legal").steps;
    let step = &steps[0];
    assert_eq!((steps.len(), &*step.stage, &*step.version, &*step.options), (1, "permute", "1.0", "none"));
    assert_eq!(c.as_bytes(), std::fs::read(folder().join("../../../formats/minimal.rad")).expect("it is there"));
}

#[test]
fn every_record_of_the_cube_is_read() {
    let (c, cube) = (open("cube.rad"), cube());
    assert_eq!(c.sections().len(), 41);
    assert_eq!(Mesh::read(&c).expect("legal"), cube.mesh);
    assert_eq!(Materials::read(&c).expect("legal"), cube.materials);
    assert_eq!(c.meta::<Extras>("scene.extras").expect("legal"), cube.extras);
    assert_eq!(Patches::read(&c).expect("legal"), cube.patches);
    assert_eq!(FormFactors::read(&c).expect("legal"), cube.factors);
    assert_eq!(Operator::read(&c).expect("legal"), cube.operator);
    assert_eq!(Permutation::read(&c).expect("legal"), cube.order);
    assert_eq!(PackedOperator::read(&c).expect("legal"), cube.packed);
    assert_eq!(Transfer::read(&c).expect("legal"), cube.transfer);
}

/// What the numbers mean, said without the fixture.
#[test]
fn the_light_in_the_cube_is_the_light_that_was_stored() {
    let c = open("cube.rad");
    let (patches, operator) = (Patches::read(&c).expect("legal"), Operator::read(&c).expect("legal"));
    let packed = PackedOperator::read(&c).expect("legal");
    let lamp = (0..6).find(|&i| patches.emission[i][0] > 0.0).expect("one wall shines");
    assert_eq!(patches.normal[lamp], [0.0, 0.0, -1.0], "it is the ceiling and shines down");
    assert!((patches.emission[lamp][0] / std::f32::consts::PI - 17.0).abs() < 1e-5);
    // Furnace identity: Σ_j K_ij (1 − ρ_j) = 1 in a closed room of equal areas. Six f32 terms and factors
    // rounded to nine digits leave 1e-6.
    for (channel, i) in (0..3).flat_map(|c| (0..6).map(move |i| (c, i))) {
        let row = &operator.channel(channel)[6 * i..][..6];
        let sum: f32 = row.iter().zip(&patches.reflectance).map(|(k, rho)| k * (1.0 - rho[channel])).sum();
        assert!((sum - 1.0).abs() < 1e-6, "channel {channel}, patch {i}: {sum}");
    }
    // Where there is an outlier the packed operator is exact up to rounding; elsewhere eight levels are left.
    for channel in 0..3 {
        let (exact, decoded) = (operator.channel(channel), packed.decode(channel));
        for (at, (k, d)) in exact.iter().zip(&decoded).enumerate() {
            let limit = if at == 0 || at == 21 { 1e-6 } else { 0.1 };
            assert!((k - d).abs() < limit, "channel {channel}, element {at}: {k} became {d}");
        }
    }
}

#[test]
fn the_operator_in_the_papers_format_is_read() {
    let c = open("cube-bc1.rad");
    let (packed, exact) = (PackedOperator::read(&c).expect("legal"), cube().operator);
    let p = &packed.packing;
    assert_eq!((p.n, p.channels, p.bounces, p.tile, p.tiles), (6, 3, Some(3), 8, 1));
    assert_eq!((p.format, p.map), (BlockFormat::Bc1, ValueMap::Log { shift: 4.0 }));
    assert_eq!((&packed.outlier_start[..], &packed.outlier_column[..]), (&[0, 1, 1, 1, 2, 2, 2][..], &[0, 3][..]));
    for channel in 0..3 {
        let (exact, decoded) = (exact.channel(channel), packed.decode(channel));
        for at in [0, 21] {
            assert!((exact[at] - decoded[at]).abs() < 1e-5, "outliers are exact up to rounding of exp");
        }
        assert_eq!(packed.texel(channel, 7, 7), 0.0, "code 0 is exactly 0, also beyond the matrix");
    }
}

#[test]
fn every_feature_is_read_and_handed_through() {
    let c = open("every-feature.rad");
    assert_eq!(c.array::<u8>("permute.extra_u8", 1).expect("legal"), (&[1, 2, 255][..], &[3][..]));
    assert_eq!(c.array::<f64>("x-scalar", 0).expect("legal").0, [-0.5]);
    assert_eq!(c.array::<u16>("x-rank.1", 1).expect("legal").0, [1, 65535]);
    assert_eq!(c.array::<u32>("x-rank.2", 2).expect("legal"), (&[0, 1, 2, 3, 4, 5][..], &[2, 3][..]));
    assert_eq!(c.array::<f32>("x-rank.3", 3).expect("legal").0, [0.25, -1.0, f32::INFINITY, 1e-40]);
    assert_eq!(c.section("x-rank.3").expect("there").flags, FLAG_PATCH_ORDER);
    assert_eq!(c.array::<u64>("x-rank.4", 4).expect("legal"), (&[0, 1, u64::MAX, 1 << 63][..], &[2, 1, 1, 2][..]));
    assert_eq!(c.array::<f32>("x-empty", 1).expect("legal").1, [0]);
    assert_eq!(c.array::<f32>("x-empty.rows", 2).expect("legal").1, [0, 3]);
    assert_eq!(c.array::<u8>("x-exactly-one-line", 1).expect("legal").0.len(), 64);
    assert_eq!(c.array::<u8>("x-a_name.of-32.bytes.0123456789a", 1).expect("legal").0, [7]);
    assert_eq!(c.meta::<String>("x-note").expect("legal"), "a section that no version knows");
    assert_eq!(Permutation::read(&c).expect("legal").new_to_old(), [0; 0]);
    assert_eq!(radfile::Builder::from_input(&c, |_| true).to_bytes(), c.as_bytes());
}

/// Version 1.0 is still what is written where nothing of 1.1 is needed, byte for byte where no elementary function is involved.
#[test]
fn the_same_records_still_give_the_same_files() {
    assert_eq!(cube().builder().to_bytes(), open("cube.rad").as_bytes());
    assert_eq!(every_feature().to_bytes(), open("every-feature.rad").as_bytes());
}
