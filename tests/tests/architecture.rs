//! The invariants of ARCHITECTURE.md.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    process::Command,
};

use allbounce_tests::root;
use serde_json::Value;

const STAGES: [&str; 7] = ["voxel-simplify", "formfactor", "series", "permute", "dxt-pack", "hmatrix", "transfer"];
/// Stages that pack the operator, and measure what that costs.
const PACKERS: [&str; 2] = ["dxt-pack", "hmatrix"];
/// Files that may hold `unsafe`.
const UNSAFE_FILES: [&str; 1] = ["crates/radfile/src/bytes.rs"];

fn cargo(args: &[&str]) -> String {
    let output = Command::new(env!("CARGO")).args(args).current_dir(root()).output().expect("cargo starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("cargo speaks UTF-8")
}

/// The members of the workspace.
fn packages() -> Vec<Value> {
    let metadata = cargo(&["metadata", "--format-version", "1", "--no-deps", "--offline"]);
    let metadata: Value = serde_json::from_str(&metadata).expect("JSON");
    metadata["packages"].as_array().expect("packages").clone()
}

/// Names of the packages that a crate of ours depends on, without dev-dependencies.
fn dependencies(package: &str) -> BTreeSet<String> {
    let packages = packages();
    let found = packages.iter().find(|p| p["name"] == package).unwrap_or_else(|| panic!("no crate {package}"));
    let normal = found["dependencies"].as_array().expect("dependencies").iter().filter(|d| d["kind"].is_null());
    normal.map(|d| d["name"].as_str().expect("a name").to_owned()).collect()
}

fn ours() -> BTreeSet<String> {
    let folders = std::fs::read_dir(root().join("crates")).expect("crates");
    folders.flatten().map(|e| e.file_name().into_string().expect("UTF-8")).collect()
}

/// Every Rust source file of the crates' libraries and programs.
fn sources() -> Vec<(PathBuf, String)> {
    ours().iter().flat_map(|own| files_below(&format!("crates/{own}/src"))).collect()
}

/// Every Rust source file below a folder of the workspace.
fn files_below(folder: &str) -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("src").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).expect("UTF-8");
                files.push((path.strip_prefix(root()).expect("below the root").to_owned(), text));
            }
        }
    }
    files
}

/// Source text without comments and without the test module at the end of a file.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or("");
    text.lines().map(|l| l.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

#[test]
fn stages_know_radfile_and_scene_and_nothing_else_of_ours() {
    let allowed = BTreeSet::from(["radfile".to_owned(), "scene".to_owned()]);
    for stage in STAGES {
        let known: BTreeSet<String> = dependencies(stage).intersection(&ours()).cloned().collect();
        let own: &[&str] = match stage {
            // It packs form factors, those of lightmaps as well.
            "transfer" => &["hmatrix", "lightmap"],
            _ if PACKERS.contains(&stage) => &["probes"],
            _ => &[],
        };
        let own: BTreeSet<String> = own.iter().map(|name| (*name).to_owned()).collect();
        assert!(known.is_subset(&(&allowed | &own)), "{stage} depends on {known:?}");
    }
    assert!(dependencies("radfile").is_disjoint(&ours()));
    assert!(dependencies("plot").is_disjoint(&ours()));
    for base in ["scene", "probes"] {
        assert_eq!(dependencies(base).intersection(&ours()).collect::<Vec<_>>(), ["radfile"]);
    }
    let known: BTreeSet<String> = dependencies("lightmap").intersection(&ours()).cloned().collect();
    assert_eq!(known, allowed);
    // The run times multiply with hierarchical blocks.
    let allowed = &allowed | &BTreeSet::from(["hmatrix".to_owned()]);
    for runtime in ["relight", "gpu-runtime"] {
        let known: BTreeSet<String> = dependencies(runtime).intersection(&ours()).cloned().collect();
        assert!(known.is_subset(&allowed), "{runtime} depends on {known:?}");
    }
}

#[test]
fn the_judge_shares_scenes_and_rays_with_what_it_judges_and_nothing_else() {
    let known: BTreeSet<String> = dependencies("reference").intersection(&ours()).cloned().collect();
    assert_eq!(known, BTreeSet::from(["radfile".to_owned(), "scene".to_owned()]));
    let knows_it = |own: &String| dependencies(own).contains("reference");
    assert_eq!(ours().into_iter().filter(knows_it).collect::<Vec<_>>(), ["allbounce"]);
}

#[test]
fn heavy_dependencies_stand_in_one_room_each() {
    let rooms = [
        ("wgpu", "gpu-runtime"),
        ("faer", "series"),
        ("obvhs", "scene"),
        ("bincode", "radfile"),
        ("tobj", "scene"),
        ("kuva", "plot"),
        ("uvunwrap", "lightmap"),
    ];
    for (package, room) in rooms {
        for own in ours() {
            assert_eq!(dependencies(&own).contains(package), own == room, "{own} and {package}");
        }
    }
    // Products on a CPU choose their vector instructions at run time.
    let products = ours().into_iter().filter(|own| dependencies(own).contains("pulp"));
    assert_eq!(products.collect::<Vec<_>>(), ["hmatrix", "reference", "relight"]);
}

#[test]
fn without_the_gpu_feature_no_wgpu_is_pulled_in() {
    let tree =
        cargo(&["tree", "-p", "allbounce", "--no-default-features", "-e", "normal", "--prefix", "none", "--offline"]);
    let wgpu: Vec<&str> = tree
        .lines()
        .filter(|l| l.starts_with("wgpu") || l.starts_with("naga") || l.starts_with("gpu-runtime"))
        .collect();
    assert!(wgpu.is_empty(), "{wgpu:?}");
    let with = cargo(&["tree", "-p", "allbounce", "-e", "normal", "--prefix", "none", "--offline"]);
    assert!(with.lines().any(|l| l.starts_with("wgpu v")), "the gpu feature is on by default");
}

#[test]
fn only_the_command_line_prints_and_only_it_and_radfile_touch_files() {
    let printing = ["println!", "eprintln!", "print!(", "eprint!(", "dbg!("];
    let touches_files = [
        Path::new("crates/radfile/src/builder.rs"),
        Path::new("crates/radfile/src/container.rs"),
        Path::new("crates/radfile/src/bytes.rs"),
    ];
    for (path, text) in sources() {
        if path.starts_with("crates/allbounce") {
            continue;
        }
        let code = code(&text);
        assert!(!printing.iter().any(|p| code.contains(p)), "{} prints", path.display());
        let way = way_to_files(&code);
        assert!(way.is_none() || touches_files.contains(&path.as_path()), "{} has {way:?}", path.display());
    }
}

/// What in a source text reaches for files, if anything does.
fn way_to_files(code: &str) -> Option<&'static str> {
    let calls = [
        "std::fs",
        "File::open",
        "File::create",
        "tempfile",
        "image::open",
        "ImageReader::open",
        "tobj::load_obj(",
        "memmap2::",
    ];
    let of_a_word = |start: usize| code[..start].chars().next_back().is_some_and(|c| c.is_alphanumeric() || c == '_');
    let module = code.match_indices("fs::").any(|(start, _)| !of_a_word(start)).then_some("fs::");
    // A list of imports, `use std::{…, fs, …};`.
    let lists = code.split("use std::{").skip(1).map(|rest| rest.split(';').next().unwrap_or(""));
    let mut names = lists.flat_map(|list| list.split(|c: char| !(c.is_alphanumeric() || c == '_')));
    let imported = names.any(|name| name == "fs").then_some("use std::{fs}");
    calls.into_iter().find(|call| code.contains(call)).or(module).or(imported)
}

#[test]
fn every_way_to_files_is_seen() {
    for code in [
        "use std::{\n    collections::HashMap,\n    fs,\n};",
        "use std::{fs::File, path::Path};",
        "let bytes = fs::read(path)?;",
        "std::fs::read(path)",
        "image::open(path)",
        "tobj::load_obj(path, &options)",
        "memmap2::Mmap::map(&file)",
    ] {
        assert!(way_to_files(code).is_some(), "{code}");
    }
    for code in ["use std::{fmt, path::Path};", "prefs::read()", "tobj::load_obj_buf(text)", "let fs = 3;"] {
        assert_eq!(way_to_files(code), None, "{code}");
    }
    let middle = "fn a() {}\n#[cfg(test)]\nfn b() {}\nfn c() { fs::read(p) }\n#[cfg(test)]\nmod tests { std::fs }";
    assert_eq!(way_to_files(&code(middle)), Some("fs::"), "code after a single test item is still code");
}

#[test]
fn unsafe_code_stands_only_in_the_named_files() {
    for (path, text) in sources() {
        let code = code(&text);
        let unsafe_word = code.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|word| word == "unsafe");
        let named = UNSAFE_FILES.iter().any(|f| Path::new(f) == path);
        assert_eq!(unsafe_word, named, "{}", path.display());
    }
}

#[test]
fn every_room_of_the_architecture_page_exists() {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    for own in ours() {
        assert!(page.contains(&format!("crates/{own}/")), "ARCHITECTURE.md does not name crates/{own}/");
    }
    for word in page.split(['`', ' ', ';', ',']).filter(|w| w.starts_with("crates/") && !w.contains('{')) {
        assert!(root().join(word).exists(), "ARCHITECTURE.md names {word}");
    }
}

/// Numbers of equations, such as 7.2, that stand in brackets.
fn equations(text: &str) -> BTreeSet<&str> {
    let number = |inner: &&str| {
        inner
            .split_once('.')
            .is_some_and(|(a, b)| [a, b].iter().all(|d| !d.is_empty() && d.bytes().all(|c| c.is_ascii_digit())))
    };
    text.split('(').skip(1).filter_map(|rest| Some(rest.split_once(')')?.0)).filter(number).collect()
}

#[test]
fn every_equation_that_code_cites_is_in_the_theory() {
    let page = std::fs::read_to_string(root().join("docs/theory.md")).expect("docs/theory.md");
    // An equation is defined where its number ends a line.
    let ends: Vec<&str> =
        page.lines().filter_map(|l| l.get(l.rfind('(')?..)).filter(|end| end.ends_with(')')).collect();
    let defined: BTreeSet<&str> = ends.iter().flat_map(|end| equations(end)).collect();
    assert!(defined.len() > 30, "{defined:?}");
    let mut cited = 0;
    let mut files = files_below("crates");
    files.extend(files_below("tests"));
    for (path, text) in files {
        for passage in text.split("theory.md").skip(1) {
            // What is cited follows at once: theory.md (4.1), (4.3).
            let line: String = passage.chars().take_while(|c| " (),.and0123456789".contains(*c)).collect();
            for number in equations(&line) {
                assert!(defined.contains(number), "{} cites equation ({number})", path.display());
                cited += 1;
            }
        }
    }
    assert!(cited > 10, "{cited} citations");
    // `allbounce verify` prints numbers beside its checks.
    for (path, text) in files_below("crates/allbounce/src/verify") {
        for number in ["check(\"", "skip(\""].iter().flat_map(|call| text.split(call).skip(1)) {
            let number = number.split('"').next().unwrap_or("");
            assert!(defined.contains(number), "{} prints equation ({number})", path.display());
        }
    }
    for number in equations(&page) {
        assert!(defined.contains(number), "docs/theory.md cites its equation ({number})");
    }
}

#[test]
fn decisions_are_numbered_without_gaps() {
    let folder = std::fs::read_dir(root().join("docs/decisions")).expect("docs/decisions");
    let names = folder.map(|e| e.expect("an entry").file_name().into_string().expect("UTF-8"));
    let mut numbers: Vec<usize> = names
        .map(|name| {
            let number = name.split_once('-').filter(|(digits, _)| digits.len() == 4).and_then(|(d, _)| d.parse().ok());
            assert!(name.ends_with(".md") && number.is_some(), "{name} is not called like 0001-a-title.md");
            number.unwrap_or_default()
        })
        .collect();
    numbers.sort_unstable();
    assert!(!numbers.is_empty());
    assert_eq!(numbers, (1..=numbers.len()).collect::<Vec<_>>());
}

#[test]
fn every_dependency_of_the_workspace_is_used_by_a_member() {
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).expect("Cargo.toml");
    let (_, table) = manifest.split_once("[workspace.dependencies]\n").expect("the table");
    let keys = table.lines().take_while(|line| !line.starts_with('[')).filter(|line| !line.starts_with('#'));
    let offered: BTreeSet<&str> = keys.filter_map(|line| Some(line.split_once(" = ")?.0)).collect();
    assert!(offered.len() > 20, "{offered:?}");
    let packages = packages();
    let used: BTreeSet<&str> = packages
        .iter()
        .flat_map(|p| p["dependencies"].as_array().expect("dependencies"))
        .map(|d| d["name"].as_str().expect("a name"))
        .collect();
    let idle: Vec<&&str> = offered.difference(&used).collect();
    assert!(idle.is_empty(), "no member uses {idle:?}");
}
