//! Containers, errors and the exported texture.

mod common;

use common::{Room, room};
use ddsfile::{D3D10ResourceDimension, Dds, DxgiFormat};
use dxt_pack::{Outliers, Params, dds, ktx2, pack, run};
use radfile::{
    BlockFormat, Builder, Container, FormFactors, Operator, PackedOperator, Packing, Patches, Provenance, Quiet,
    Record, Step, ValueMap,
};

fn step() -> Step {
    Step { stage: "dxt-pack".into(), version: "1".into(), options: "--preset x".into(), inputs: Vec::new() }
}

/// A container as `series` leaves it, with a section that this version does not know.
fn solved(room: &Room) -> Container {
    let n = room.operator.n;
    let factors = FormFactors { values: vec![0.0; n * n].into(), sky: vec![0.25; n].into() };
    let mut builder = Builder::new();
    room.patches.write(&mut builder);
    factors.write(&mut builder);
    room.operator.write(&mut builder);
    builder.array::<u8>("x.note", 0, &[3], vec![1, 2, 3]);
    builder.provenance(None, Step { stage: "series".into(), ..step() }).unwrap();
    builder.finish().unwrap()
}

fn run_on(input: &Container, params: &Params) -> dxt_pack::Result<Container> {
    let mut output = None;
    run(input, params, step(), &Quiet, &mut |builder| {
        output = Some(builder.finish()?);
        Ok(())
    })?;
    Ok(output.expect("the sink was called"))
}

#[test]
fn the_dense_operator_goes_and_the_rest_stays() {
    let room = room(4, 3);
    let input = solved(&room);
    for (_, params) in Params::PRESETS {
        let output = run_on(&input, &params).unwrap();
        for gone in ["series.meta", "series.values", "formfactor.values"] {
            assert!(!output.has(gone), "{gone}");
        }
        assert_eq!(Patches::read(&output).unwrap(), room.patches);
        assert_eq!(radfile::read_sky(&output).unwrap(), [0.25; 96]);
        assert_eq!(output.data(output.section("x.note").unwrap()), [1, 2, 3]);
        let steps = Provenance::read(&output).unwrap().steps;
        assert_eq!(steps.iter().map(|s| &s.stage[..]).collect::<Vec<_>>(), ["series", "dxt-pack"]);
        let (packed, _) = pack(&room.operator, &room.patches, &params, &Quiet).unwrap();
        assert_eq!(PackedOperator::read(&output).unwrap(), packed, "through a file and back");
    }
}

#[test]
fn keeping_the_dense_operator_allows_to_pack_again() {
    let room = room(3, 3);
    let dense = Params { keep_dense: true, ..Params::PAPER };
    let first = run_on(&solved(&room), &dense).unwrap();
    assert_eq!(Operator::read(&first).unwrap(), room.operator);
    assert!(first.has("formfactor.values"));
    // The other form replaces what was there.
    let again = run_on(&first, &Params::default()).unwrap();
    let fresh = run_on(&solved(&room), &Params::default()).unwrap();
    assert_eq!(PackedOperator::read(&again).unwrap(), PackedOperator::read(&fresh).unwrap());
    assert!(first.has("pack.meta") && !again.has("pack.meta"));
}

#[test]
fn the_report_is_numbers_for_people() {
    let room = room(3, 1);
    let mut calls = 0;
    let report = run(&solved(&room), &Params::default(), step(), &Quiet, &mut |_| {
        calls += 1;
        Ok(())
    })
    .unwrap();
    assert_eq!(calls, 1);
    let json = serde_json::to_value(&report).unwrap();
    for key in ["bytes_per_entry", "smaller_than_form_factors", "outlier_share"] {
        assert!(json[key].as_f64().unwrap() > 0.0, "{key}: {}", json[key]);
    }
    for key in ["l2_mean", "l2_max", "p99", "vis99", "energy_bias", "matrix_rms"] {
        assert!(json["errors"][key].is_f64(), "{key}: {}", json["errors"][key]);
    }
}

/// What packing the room with these changes is refused for.
fn refusal(params: Params, change: impl Fn(&mut Room)) -> String {
    let mut room = room(2, 3);
    change(&mut room);
    pack(&room.operator, &room.patches, &params, &Quiet).unwrap_err().to_string()
}

#[test]
fn what_cannot_be_packed_is_refused_in_one_sentence() {
    let with_value =
        |value: f32| move |room: &mut Room| room.operator.values.to_mut()[2 * 24 * 24 + 5 * 24 + 7] = value;
    let refused = "expected K ≥ 0; solve the series again";
    for value in [f32::NAN, f32::INFINITY, -0.5] {
        let found = refusal(Params::default(), with_value(value));
        assert_eq!(found, format!("operator: K[5, 7] of channel 2 is {value}, {refused}"));
    }
    assert_eq!(
        refusal(Params::default(), |room| room.patches = common::some_patches(23)),
        "operator: it has 24 patches, the patch list 23; take both from the same bake"
    );
    assert_eq!(
        refusal(Params::default(), |room| {
            room.operator = Operator { n: 0, channels: 1, bounces: None, values: Vec::new().into() };
        }),
        "operator: it has no patches, so nothing can be packed (is the scene empty?)"
    );
    for share in [-0.1, 1.5] {
        assert_eq!(
            refusal(Params { outliers: Outliers::Share(share), ..Params::default() }, |_| ()),
            format!("option outliers is {share}, expected a share 0..=1")
        );
    }
    assert_eq!(
        refusal(Params { outliers: Outliers::Share(f64::NAN), ..Params::default() }, |_| ()),
        "option outliers is NaN, expected a share 0..=1"
    );
    for error in [0.0, -0.1, f64::NAN] {
        assert_eq!(
            refusal(Params { error, ..Params::default() }, |_| ()),
            format!("option error is {error}, expected a relative error above 0 and up to 1")
        );
    }
    for shift in [0.0, -6.0, f32::NAN, 81.0] {
        assert_eq!(
            refusal(Params { shift, ..Params::PAPER }, |_| ()),
            format!("option shift is {shift}, expected a number above 0 and up to 80 (6 is usual)")
        );
    }
}

#[test]
fn a_container_without_an_operator_names_the_stage_that_makes_it() {
    let mut builder = Builder::new();
    let patches = room(2, 1).patches;
    patches.write(&mut builder);
    let found = run_on(&builder.finish().unwrap(), &Params::default()).err().unwrap();
    assert_eq!(found.to_string(), "section series.meta is missing; it is written by `allbounce series`");
}

#[test]
fn outliers_out_of_order_are_no_packed_operator() {
    let room = room(3, 1);
    let params = Params { outliers: Outliers::Share(0.1), ..Params::default() };
    let (mut packed, _) = pack(&room.operator, &room.patches, &params, &Quiet).unwrap();
    let row = (0..54).find(|&i| packed.outlier_start[i + 1] - packed.outlier_start[i] >= 2).unwrap();
    packed.outlier_column.to_mut().swap(packed.outlier_start[row] as usize, packed.outlier_start[row] as usize + 1);
    let mut builder = Builder::new();
    packed.write(&mut builder);
    let found = PackedOperator::read(&builder.finish().unwrap()).unwrap_err().to_string();
    assert_eq!(found, format!("packed operator: the columns of the outliers of row {row} do not increase"));
}

#[test]
fn the_exported_texture_holds_the_same_blocks() {
    let room = room(4, 3);
    // 24 × 24 blocks, or 300 of the half in a row.
    for (params, format, size) in
        [(Params::PAPER, DxgiFormat::BC1_UNorm, (96, 96, 1)), (Params::BC4_SQRT, DxgiFormat::BC4_UNorm, (1200, 4, 1))]
    {
        let (packed, _) = pack(&room.operator, &room.patches, &params, &Quiet).unwrap();
        let file = Dds::read(&dds(&packed).unwrap()[..]).unwrap();
        assert_eq!((file.get_width(), file.get_height(), file.get_depth()), size);
        assert_eq!((file.get_num_array_layers(), file.get_num_mipmap_levels()), (1, 1));
        assert_eq!(file.get_dxgi_format(), Some(format));
        assert_eq!(file.header10.as_ref().unwrap().resource_dimension, D3D10ResourceDimension::Texture2D);
        assert_eq!(file.get_data(0).unwrap(), &packed.blocks[..]);
    }
}

/// Offsets and numbers are those of the specification's tables.
#[test]
fn a_ktx2_file_says_what_its_blocks_are_and_holds_them() {
    let room = room(4, 3);
    for (params, format, model, [width, height]) in
        [(Params::PAPER, 131, 128, [96, 96]), (Params::BC4_SQRT, 139, 131, [1200, 4])]
    {
        let (packed, _) = pack(&room.operator, &room.patches, &params, &Quiet).unwrap();
        let file = ktx2(&packed);
        assert_eq!(file[..12], [0xAB, 0x4B, 0x54, 0x58, 0x20, 0x32, 0x30, 0xBB, 0x0D, 0x0A, 0x1A, 0x0A]);
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
        let long = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
        let header: Vec<u32> = (12..48).step_by(4).map(word).collect();
        assert_eq!(header, [format, 1, width, height, 0, 1, 1, 1, 0]);
        let (descriptor, length) = (word(48) as usize, word(52));
        assert_eq!((word(descriptor), word(56), word(60), long(64), long(72)), (length, 0, 0, 0, 0));
        assert_eq!((u32::from(file[descriptor + 12]), file[descriptor + 14]), (model, 1));
        assert_eq!(file[descriptor + 16..descriptor + 21], [3, 3, 0, 0, 8]);
        let (first, length) = (long(80), long(88));
        assert_eq!((first % 8, length, first + length), (0, long(96), file.len()));
        assert!(first >= descriptor + word(52) as usize);
        assert_eq!(file[first..], packed.blocks[..]);
    }
}

#[test]
fn a_texture_beyond_what_dds_holds_is_refused() {
    let (tile, tiles) = Packing::tiling(60_000);
    let packing = Packing {
        n: 60_000,
        channels: 3,
        bounces: None,
        format: BlockFormat::Bc4,
        map: ValueMap::Sqrt,
        scale: [1.0; 3],
        tile,
        tiles,
    };
    let none = PackedOperator {
        half: None,
        packing,
        blocks: Vec::new().into(),
        outlier_start: Vec::new().into(),
        outlier_column: Vec::new().into(),
        outlier_value: Vec::new().into(),
    };
    assert_eq!(
        dds(&none).unwrap_err().to_string(),
        "the texture array has 675 layers and 5400000000 bytes, a DDS file holds 2048 layers and 4294967295 bytes; \
         read the blocks from the .rad file instead"
    );
}
