//! Metadata as `formats/rad.md` §5 lists it, decoded by another implementation.
//!
//! The structs below repeat the specification field by field; wincode reads and writes them. So the file format
//! does not hang on the one library that we happen to encode with.

use radfile::{Container, Section, decode_meta, encode_meta};
use wincode::{SchemaRead, SchemaWrite};

use crate::{
    assert_says,
    fixture::{cube, open},
    raw::{edited, field},
};

type Rgb = [f32; 3];

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
struct MeshMeta {
    origin: [f64; 3],
    one_sided: bool,
}

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
struct MaterialsMeta {
    materials: Vec<Material>,
    textures: Vec<(String, u64, [Wrap; 2])>,
}

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
struct Material {
    name: String,
    reflectance: Rgb,
    reflectance_texture: Option<u32>,
    emission: Rgb,
    emission_texture: Option<u32>,
}

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
enum Wrap {
    Repeat,
    Mirror,
    Clamp,
}

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
struct SceneExtras {
    lights: Vec<(String, Light)>,
    cameras: Vec<(String, Camera)>,
}

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
enum Light {
    Point { position: [f64; 3], intensity: Rgb },
    Spot { position: [f64; 3], direction: [f32; 3], intensity: Rgb, half_angle_deg: f32, penumbra_deg: f32 },
    Directional { direction: [f32; 3], irradiance: Rgb },
    Quad { corner: [f64; 3], edge_u: [f32; 3], edge_v: [f32; 3], radiance: Rgb },
    Sky { radiance: Rgb },
}

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
struct Camera {
    origin: [f64; 3],
    target: [f64; 3],
    up: [f64; 3],
    fov_x_deg: f64,
}

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
struct PatchesMeta {
    grid_origin: [f32; 3],
    cell_size: f32,
}

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
struct SeriesMeta {
    bounces: Option<u32>,
}

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
struct PackMeta {
    n: u32,
    channels: u32,
    bounces: Option<u32>,
    format: BlockFormat,
    map: ValueMap,
    scale: [f32; 3],
    tile: u32,
    tiles: u32,
}

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
enum BlockFormat {
    Bc1,
    Bc4,
}

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
enum ValueMap {
    Log { shift: f32 },
    Sqrt,
}

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
struct Provenance {
    steps: Vec<Step>,
}

#[derive(Debug, PartialEq, SchemaRead, SchemaWrite)]
struct Step {
    stage: String,
    version: String,
    options: String,
    inputs: Vec<(String, String)>,
}

/// Decodes a section with wincode, encodes it again, and compares the bytes.
macro_rules! by_wincode {
    ($container:expr, $name:expr, $type:ty) => {{
        let section: &Section = $container.section($name).expect("it was written");
        let bytes = $container.data(section);
        let value: $type = wincode::deserialize(bytes).expect("wincode reads it");
        assert_eq!(wincode::serialize(&value).expect("wincode writes it"), bytes, "{}", $name);
        value
    }};
}

#[test]
fn another_implementation_reads_and_writes_the_same_metadata() {
    let cube = cube();
    let c = open(&cube.builder());
    assert_eq!(by_wincode!(c, "mesh.meta", MeshMeta), MeshMeta { origin: cube.mesh.origin, one_sided: true });
    let materials = by_wincode!(c, "materials.meta", MaterialsMeta);
    assert_eq!(materials.materials[2].name, "grün");
    assert_eq!(materials.materials[3].emission_texture, Some(1));
    assert_eq!(materials.textures[0], ("white.png".into(), 67, [Wrap::Repeat, Wrap::Mirror]));
    let extras = by_wincode!(c, "scene.extras", SceneExtras);
    assert_eq!(extras.lights[4], ("e".into(), Light::Sky { radiance: [7.0; 3] }));
    assert_eq!(extras.cameras[0].1.fov_x_deg, 39.0);
    let patches = by_wincode!(c, "patches.meta", PatchesMeta);
    assert_eq!(patches, PatchesMeta { grid_origin: [-0.25; 3], cell_size: 1.5 });
    assert_eq!(by_wincode!(c, "series.meta", SeriesMeta), SeriesMeta { bounces: None });
    let pack = by_wincode!(c, "pack.meta", PackMeta);
    assert_eq!((pack.n, pack.format, pack.map, pack.tile), (6, BlockFormat::Bc4, ValueMap::Sqrt, 8));
    assert_eq!(by_wincode!(c, "provenance", Provenance).steps[0].stage, "voxel-simplify");

    let paper = cube.packed_as_the_paper();
    let mut builder = radfile::Builder::new();
    radfile::Record::write(&paper, &mut builder);
    let c = open(&builder);
    let pack = by_wincode!(c, "pack.meta", PackMeta);
    assert_eq!((pack.bounces, pack.format, pack.map), (Some(3), BlockFormat::Bc1, ValueMap::Log { shift: 4.0 }));
}

#[test]
fn every_metadata_section_is_read_by_the_test_above() {
    let c = open(&cube().builder());
    let is_meta = |s: &&Section| s.element == radfile::ElementType::Meta;
    let names: Vec<&str> = c.sections().iter().filter(is_meta).map(|s| s.name.as_str()).collect();
    let read =
        ["mesh.meta", "materials.meta", "scene.extras", "patches.meta", "series.meta", "pack.meta", "provenance"];
    assert_eq!(names, read);
}

#[test]
fn numbers_are_little_endian_lengths_are_u64_alternatives_u32_and_options_one_byte() {
    assert_eq!(encode_meta(&(1u32, true, 1.0f32)), [1, 0, 0, 0, 1, 0, 0, 0x80, 0x3F]);
    assert_eq!(encode_meta(&"ab"), [2, 0, 0, 0, 0, 0, 0, 0, b'a', b'b']);
    assert_eq!(encode_meta(&radfile::Wrap::Clamp), [2, 0, 0, 0]);
    assert_eq!(encode_meta(&(None::<u16>, Some(7u16))), [0, 1, 7, 0]);
    assert_eq!(encode_meta(&vec![[1u8, 2]]), [1, 0, 0, 0, 0, 0, 0, 0, 1, 2]);
}

#[test]
fn metadata_that_cannot_be_decoded_says_why() {
    let says = |bytes: &[u8], what: &str| {
        let said = decode_meta::<Vec<(String, Option<bool>)>>(bytes).expect_err("refused");
        assert!(said.contains(what), "{said:?} does not say {what:?}");
    };
    let one = |name: &[u8], rest: &[u8]| {
        [&[1, 0, 0, 0, 0, 0, 0, 0, name.len() as u8, 0, 0, 0, 0, 0, 0, 0], name, rest].concat()
    };
    assert!(decode_meta::<Vec<(String, Option<bool>)>>(&one(b"x", &[1, 0])).is_ok());
    says(&one(b"x", &[]), "it ends too early");
    says(&one(b"x", &[1, 2]), "a truth value is 2, expected 0 or 1");
    says(&one(b"x", &[2]), "there is no alternative number 2");
    says(&one(b"\xff", &[0]), "a text is not UTF-8");
    says(&one(b"x", &[0, 0]), "1 bytes are left over");
    // Lengths that no file could hold must neither reserve memory nor abort.
    says(&[0xFF; 8], "it ends too early");
    says(&[&[1, 0, 0, 0, 0, 0, 0, 0][..], &[0xFF; 8]].concat(), "a length in it is beyond 64 MiB");
    says(&[&[1, 0, 0, 0, 0, 0, 0, 0][..], &[0, 0, 0, 3, 0, 0, 0, 0]].concat(), "it ends too early");
}

#[test]
fn a_section_with_broken_metadata_is_named() {
    let file = cube().builder().to_bytes();
    let at = open(&cube().builder()).section("mesh.meta").expect("written").offset as usize;
    let c = Container::from_bytes(&edited(&file, |b| b[at + 24] = 9)).expect("the checksum was made right");
    assert_says(
        <radfile::Mesh as radfile::Record>::read(&c),
        &["metadata of mesh.meta cannot be decoded: a truth value is 9, expected 0 or 1"],
    );
    assert!(field(0, 0) == 64, "mesh.meta is the first section");
}
