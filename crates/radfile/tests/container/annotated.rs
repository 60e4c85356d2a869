//! `formats/minimal.rad.txt` explains every byte of `formats/minimal.rad`; this decodes it line by line.

use std::path::Path;

use radfile::{Container, Permutation, Provenance, Record};

use crate::fixture::minimal;

struct Line {
    offset: usize,
    bytes: Vec<u8>,
    kind: String,
    value: String,
}

fn read(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../formats").join(name);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// `offset | bytes | type | field = value | remark`; a line without a type goes on with the field before it.
fn lines(text: &str) -> Vec<Line> {
    let mut lines: Vec<Line> = vec![];
    for line in text.lines().filter(|l| !l.starts_with('#') && !l.is_empty()) {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let offset = usize::from_str_radix(cells[0], 16).expect("a hexadecimal offset");
        let byte = |b: &str| u8::from_str_radix(b, 16).expect("a hexadecimal byte");
        let bytes: Vec<u8> = cells[1].split_whitespace().map(byte).collect();
        if cells.len() == 2 {
            let field = lines.last_mut().expect("a first line");
            assert_eq!(field.offset + field.bytes.len(), offset);
            field.bytes.extend(bytes);
            continue;
        }
        let (_, value) = cells[3].split_once(" = ").unwrap_or((cells[3], ""));
        lines.push(Line { offset, bytes, kind: cells[2].into(), value: value.into() });
    }
    lines
}

/// The value of a field in words, by its type.
fn decode(kind: &str, bytes: &[u8]) -> String {
    let number = || bytes.iter().rev().fold(0, |n: u64, &b| n << 8 | u64::from(b));
    match (kind, bytes.len()) {
        ("u16", 2) | ("u32", 4) | ("u64", 8) => number().to_string(),
        ("crc", 4) => format!("{:08X}", number()),
        ("text", _) => std::str::from_utf8(bytes).expect("text").to_string(),
        ("name", 32) => std::str::from_utf8(bytes).expect("text").trim_end_matches('\0').to_string(),
        ("zero", _) => {
            assert!(bytes.iter().all(|&b| b == 0));
            String::new()
        }
        ("bytes", _) => String::new(),
        other => panic!("a field of type {other:?}"),
    }
}

#[test]
fn the_annotated_bytes_are_those_of_the_file_and_decode_to_their_values() {
    let text = String::from_utf8(read("minimal.rad.txt")).expect("text");
    let mut end = 0;
    let mut bytes = Vec::new();
    for line in lines(&text) {
        assert_eq!(line.offset, end, "lines follow each other");
        assert_eq!(decode(&line.kind, &line.bytes), line.value, "at {:04x}", line.offset);
        end += line.bytes.len();
        bytes.extend(line.bytes);
    }
    assert_eq!(bytes, read("minimal.rad"));
}

#[test]
fn the_annotated_file_is_a_legal_container_and_the_one_that_we_write() {
    let bytes = read("minimal.rad");
    let container = Container::from_bytes(&bytes).expect("legal");
    assert_eq!(Permutation::read(&container).expect("legal").new_to_old(), [2, 0, 1]);
    assert_eq!(Provenance::read(&container).expect("legal").steps[0].stage, "permute");
    assert_eq!(minimal().to_bytes(), bytes);
    assert_eq!(bytes.len(), 384, "the length that formats/rad.md states");
}
