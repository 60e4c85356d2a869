//! The container and its records from outside: what is written is read, everything else is refused in a sentence.

#[path = "../fixture/mod.rs"]
mod fixture;

mod accuracy;
mod annotated;
mod damage;
mod differences;
mod disagreement;
mod elements;
mod foreign;
mod half;
mod hostile;
mod invariants;
mod lightmap;
mod metadata;
mod patch_order;
mod random;
mod raw;
mod records;
mod specification;
mod volume;
mod writing;

use radfile::{Container, Error};

/// The sentence with which bytes are refused.
fn refusal(bytes: &[u8]) -> String {
    match Container::from_bytes(bytes) {
        Ok(_) => panic!("{} bytes were accepted", bytes.len()),
        Err(e) => e.to_string(),
    }
}

/// Asserts that an error's sentence contains all of `parts`.
#[track_caller]
fn assert_says<T>(result: Result<T, Error>, parts: &[&str]) {
    let said = result.err().expect("should have been refused").to_string();
    for part in parts {
        assert!(said.contains(part), "{said:?} does not say {part:?}");
    }
}
