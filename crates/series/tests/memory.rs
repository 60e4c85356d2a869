//! The memory that is asked for beforehand is the memory that is taken, by what the system says of the process.

mod common;

use std::process::Command;

use radfile::{FormFactors, Quiet};
use series::all_bounces;

const PATCHES: usize = 1500;
const WAY: &str = "ALLBOUNCE_TEST_WAY";

/// What the process may take besides: vectors, stacks, what is packed inside a panel of LU.
const SLACK: i64 = 5 << 20;

#[test]
fn every_method_takes_the_memory_that_it_asks_for() {
    if figure("VmHWM:").is_none() {
        eprintln!("skipped: this system does not say how much memory a process has taken");
        return;
    }
    for (at, params) in common::every_way(5).into_iter().enumerate() {
        // A process each, as what one method frees is not always given back before the next one starts.
        let child = Command::new(std::env::current_exe().expect("this test"))
            .args(["--exact", "one_way_alone", "--ignored", "--nocapture", "--test-threads=1"])
            .env(WAY, at.to_string())
            .env("RAYON_NUM_THREADS", "2")
            .output()
            .expect("the test starts itself");
        let text = String::from_utf8_lossy(&child.stdout);
        let line = text.lines().find_map(|line| line.strip_prefix("taken ")).unwrap_or_else(|| panic!("{child:?}"));
        let (taken, asked) = line.split_once(" of ").expect("two figures");
        let (taken, asked): (i64, i64) = (taken.parse().unwrap(), asked.parse().unwrap());
        println!("{params:?}: asked {asked}, taken {taken}");
        assert!(taken <= asked + SLACK, "{params:?} took {taken} bytes, asked for {asked}");
        // The last channel of the result is not touched before some matrices are gone, and not all products pack.
        assert!(taken * 100 >= asked * 85, "{params:?} took only {taken} bytes, asked for {asked}");
    }
}

#[test]
#[ignore = "a part of the test above"]
fn one_way_alone() {
    let Some(at) = std::env::var(WAY).ok().and_then(|at| at.parse::<usize>().ok()) else { return };
    let params = common::every_way(5).swap_remove(at);
    let values = vec![0.7 / PATCHES as f32; PATCHES * PATCHES];
    let factors = FormFactors { values: values.into(), sky: vec![0.3; PATCHES].into() };
    let patches = common::patches(vec![1.0; PATCHES], vec![[0.8, 0.5, 0.3]; PATCHES]);
    let before = figure("VmRSS:").expect("asked before");
    all_bounces(&patches, &factors, &params, &Quiet).expect("a physical room");
    let taken = figure("VmHWM:").expect("asked before") - before;
    println!("\ntaken {taken} of {}", params.memory_needed(PATCHES, 3));
}

/// A line of the process's status, bytes.
fn figure(name: &str) -> Option<i64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<i64>().ok()? << 10)
}
