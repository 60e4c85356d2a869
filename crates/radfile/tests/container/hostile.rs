//! Files with right checksums that break a rule of the table: each is refused by the rule's own sentence.

use radfile::Container;

use crate::{
    fixture::{every_feature, minimal},
    raw::*,
    refusal,
};

/// Edits the minimal file (two sections) and returns what is said.
fn minimal_with(edit: impl FnOnce(&mut Vec<u8>)) -> String {
    refusal(&edited(&minimal().to_bytes(), edit))
}

#[test]
fn sealing_an_untouched_file_changes_nothing() {
    let file = every_feature().to_bytes();
    assert_eq!(edited(&file, |_| ()), file);
}

#[test]
fn every_rule_of_the_header_has_its_sentence() {
    let set = |at: usize, value: u64| minimal_with(|b| put(b, at, value.to_le_bytes()));
    let two = minimal_with(|b| put(b, 8, 2u16.to_le_bytes()));
    assert_eq!(two, "container version 2.0, this program reads 1.x; use the release that made the file");
    assert!(minimal_with(|b| put(b, 8, 0u16.to_le_bytes())).contains("container version 0.0"));
    assert!(set(FILE_LENGTH, u64::MAX).contains("its header says 18446744073709551615"));
    assert!(set(TABLE_OFFSET, 128).contains("the section table is at byte 128, expected 64 (formats/rad.md §3)"));
    assert!(set(TABLE_OFFSET, u64::MAX).contains("the section table is at byte 18446744073709551615"));
    assert!(set(RESERVED, 1).contains("reserved bytes of the header are not zero (formats/rad.md §2)"));
    let count = |n: u32| minimal_with(|b| put(b, SECTION_COUNT, n.to_le_bytes()));
    assert!(count(u32::MAX).contains("4294967295 sections do not fit into 384 bytes"));
    assert!(count(1).contains("section permute.new_to_old is at byte 256, expected 192"));
    assert!(count(0).contains("the file is 384 bytes long, expected 64 after its last section"));
    assert!(count(3).contains("section permute.new_to_old is at byte 256, expected 384"));
}

#[test]
fn every_rule_of_a_table_entry_has_its_sentence() {
    let set32 = |at: usize, v: u32| minimal_with(|b| put(b, field(0, at), v.to_le_bytes()));
    let set64 = |at: usize, v: u64| minimal_with(|b| put(b, field(0, at), v.to_le_bytes()));
    let set_name = |at: usize, v: u8| minimal_with(|b| put(b, field(0, NAME + at), [v]));
    let name = "is not made of a-z 0-9 . _ - and zero padding";
    for (at, byte) in [(0, b'P'), (0, b' '), (0, b'/'), (0, 0xC3), (0, 0), (31, b'x')] {
        assert!(set_name(at, byte).contains(name), "byte {byte} at {at} of a name");
    }
    assert!(set32(ELEMENT, 7).contains("section permute.new_to_old has unknown element type 7"));
    assert!(set32(FLAGS, 5).contains("section permute.new_to_old has unknown flags 0x5"));
    for rank in [2, 5, u32::MAX] {
        assert!(set32(RANK, rank).contains(if rank == 2 { "do not make the 12 bytes" } else { "has rank" }));
    }
    assert!(set32(RANK, 0).contains("of element type u32 has rank 0 and extents [3, 0, 0, 0]"));
    assert!(minimal_with(|b| put(b, field(1, RANK), 0u32.to_le_bytes())).contains("of element type meta has rank 0"));
    assert!(set64(SHAPE, 4).contains("[4] elements of u32 do not make the 12 bytes that the table says"));
    assert!(set64(SHAPE, u64::MAX).contains("do not make the 12 bytes"));
    assert!(set64(SHAPE + 8, 1).contains("has rank 1 and extents [3, 1, 0, 0]"));
    assert!(set64(OFFSET, 320).contains("is at byte 320, expected 256 (multiples of 64, no holes)"));
    assert!(set64(OFFSET, 250).contains("is at byte 250, expected 256"));
    assert!(set64(OFFSET, u64::MAX - 3).contains("expected 256"));
    assert!(set64(LENGTH, 16).contains("do not make the 16 bytes"));
}

#[test]
fn lengths_that_agree_with_their_shapes_but_not_with_the_file_are_refused() {
    let sized = |extent: u64| {
        minimal_with(|b| {
            put(b, field(0, SHAPE), extent.to_le_bytes());
            put(b, field(0, LENGTH), extent.wrapping_mul(4).to_le_bytes());
        })
    };
    assert!(sized(1000).contains("section permute.new_to_old ends beyond the end of the file"));
    assert!(sized(1 << 61).contains("ends beyond the end of the file"));
    // Nothing, but of 2^64 bytes a row.
    let empty = minimal_with(|b| {
        put(b, field(0, RANK), 2u32.to_le_bytes());
        put(b, field(0, SHAPE), (1u64 << 62).to_le_bytes());
        put(b, field(0, LENGTH), 0u64.to_le_bytes());
    });
    assert!(empty.contains("[4611686018427387904, 0] elements of u32 do not make the 0 bytes"));
    // 2^62 elements of four bytes are 2^64 bytes, which wrap to a length of 0.
    assert!(sized(1 << 62).contains("do not make the 0 bytes"));
}

#[test]
fn overlapping_sections_are_refused() {
    let said = minimal_with(|b| put(b, field(1, OFFSET), 256u64.to_le_bytes()));
    assert!(said.contains("section provenance is at byte 256, expected 320"), "{said}");
}

#[test]
fn padding_must_be_zero_between_sections_and_at_the_end() {
    let file = minimal().to_bytes();
    assert!(minimal_with(|b| b[269] = 1).contains("bytes 268 to 320 should be zero padding"));
    let last = file.len() - 1;
    assert!(minimal_with(|b| b[last] = 1).contains("to 384 should be zero padding"));
}

#[test]
fn a_name_may_be_there_only_once() {
    let file = every_feature().to_bytes();
    let first: [u8; 32] = file[field(1, NAME)..][..32].try_into().expect("a name");
    let said = refusal(&edited(&file, |b| put(b, field(2, NAME), first)));
    assert!(said.contains("section x-scalar is there twice"), "{said}");
}

#[test]
fn an_unknown_section_that_must_be_understood_is_refused_by_name() {
    let said = refusal(&edited(&every_feature().to_bytes(), |b| put(b, field(1, FLAGS), 1u32.to_le_bytes())));
    let want = "section x-scalar must be understood to use this file, but this version does not know it; \
                use a newer allbounce";
    assert_eq!(said, want);
}

#[test]
fn a_newer_minor_version_is_read() {
    let file = edited(&every_feature().to_bytes(), |b| put(b, 10, 7u16.to_le_bytes()));
    assert_eq!(Container::from_bytes(&file).expect("minor versions only add").version(), (1, 7));
}

/// A table of half a million empty sections is read in linear time.
#[test]
fn a_large_table_is_no_hang() {
    let count = 500_000;
    let mut file = minimal().to_bytes()[..64].to_vec();
    let end = (64 + 96 * count as u64).next_multiple_of(64);
    for i in 0..count {
        let mut entry = [0; ENTRY];
        let name = format!("x-{i}");
        entry[..name.len()].copy_from_slice(name.as_bytes());
        put(&mut entry, ELEMENT, 1u32.to_le_bytes());
        put(&mut entry, RANK, 1u32.to_le_bytes());
        put(&mut entry, OFFSET, end.to_le_bytes());
        file.extend(entry);
    }
    file.resize(end as usize, 0);
    let file = edited(&file, |b| {
        put(b, SECTION_COUNT, (count as u32).to_le_bytes());
        put(b, FILE_LENGTH, end.to_le_bytes());
    });
    assert_eq!(Container::from_bytes(&file).expect("legal, if silly").sections().len(), count);
}
