//! Damage in transfer or on disk: cut files, flipped bits.

use radfile::Container;

use crate::{
    fixture::{cube, every_feature, minimal},
    raw::{ENTRY, HEADER, SECTION_COUNT, u32_at},
    refusal,
};

#[test]
fn every_beginning_of_a_file_is_refused() {
    for file in [minimal().to_bytes(), every_feature().to_bytes(), cube().builder().to_bytes()] {
        for length in 0..file.len() {
            let said = refusal(&file[..length]);
            assert!(said.contains("truncated") || said.contains("no Allbounce container"), "{length}: {said}");
        }
        assert!(Container::from_bytes(&file).is_ok());
    }
}

#[test]
fn a_file_with_something_behind_it_is_refused() {
    let mut file = minimal().to_bytes();
    file.extend([0; 64]);
    assert!(refusal(&file).contains("joined with something else"));
}

#[test]
fn no_other_byte_in_header_or_table_passes() {
    let mut file = every_feature().to_bytes();
    let table_end = HEADER + ENTRY * u32_at(&file, SECTION_COUNT) as usize;
    for at in 0..table_end {
        let right = file[at];
        for wrong in (0..=255).filter(|&b| b != right) {
            file[at] = wrong;
            assert!(Container::from_bytes(&file).is_err(), "byte {at} may be {wrong} instead of {right}");
        }
        file[at] = right;
    }
}

#[test]
fn no_flipped_bit_passes_anywhere() {
    for mut file in [every_feature().to_bytes(), cube().builder().to_bytes()] {
        for at in 0..file.len() {
            for bit in 0..8 {
                file[at] ^= 1 << bit;
                assert!(Container::from_bytes(&file).is_err(), "bit {bit} of byte {at} may be flipped");
                file[at] ^= 1 << bit;
            }
        }
    }
}

#[test]
fn a_damaged_section_is_named() {
    let builder = cube();
    let mut file = builder.builder().to_bytes();
    let container = Container::from_bytes(&file).expect("undamaged");
    let at = container.section("patches.area").expect("it was written").offset as usize;
    file[at] ^= 1;
    let said = refusal(&file);
    assert!(said.starts_with("section patches.area: checksum ") && said.contains("the file is damaged"), "{said}");
}
