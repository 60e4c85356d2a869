//! `formats/rad.md` and the code list the same sections, and the specification alone is enough to read them.

use std::{collections::HashMap, path::Path};

use radfile::{Container, ElementType, FLAG_PATCH_ORDER, FLAG_REQUIRED, Lightmap, Record, SECTIONS, Volume};

use crate::fixture::{
    Cube, accuracy, cube, cube_with_cuts, elements, gathered, gathered_by_lightmap, gathered_by_volume, half,
    hierarchical, lightmap, minimal, open, volume,
};

fn specification() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../formats/rad.md");
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Rows of the tables between two headings, cells trimmed and without back quotes.
fn rows(text: &str, from: &str, to: &str) -> Vec<Vec<String>> {
    let start = text.find(&format!("\n{from}")).expect("the heading is there");
    let part = &text[start..start + text[start + 1..].find(&format!("\n{to}")).expect("the next heading is there")];
    let cells = |line: &str| line.trim_matches('|').split('|').map(|c| c.trim().replace('`', "")).collect();
    part.lines().filter(|l| l.starts_with('|') && !l.starts_with("|--")).map(cells).collect()
}

/// The rows of §4 that describe sections: name, stage, element, shape, flags, unit, meaning, rule.
fn section_rows(text: &str) -> Vec<Vec<String>> {
    rows(text, "## 4", "## 5").into_iter().filter(|r| r.len() == 8 && r[0] != "section").collect()
}

#[test]
fn specification_and_code_list_the_same_sections() {
    let text = specification();
    let listed: Vec<(String, String)> = section_rows(&text).into_iter().map(|r| (r[0].clone(), r[1].clone())).collect();
    let known: Vec<(String, String)> = SECTIONS.iter().map(|(n, s)| (n.to_string(), s.to_string())).collect();
    assert_eq!(listed, known, "formats/rad.md §4 and radfile::SECTIONS differ");
}

/// Extent such as `2t + 1` with the numbers of `symbols`; a symbol met for the first time takes the value that fits.
fn fits(extent: &str, found: u64, symbols: &mut HashMap<String, u64>) -> bool {
    let (product, plus) =
        extent.split_once('+').map_or((extent, 0), |(p, one)| (p, one.trim().parse().expect("a number")));
    let product = product.trim();
    let digits = product.find(|c: char| !c.is_ascii_digit()).unwrap_or(product.len());
    let factor: u64 = if digits == 0 { 1 } else { product[..digits].parse().expect("a number") };
    let symbol = &product[digits..];
    if symbol.is_empty() {
        return found == factor + plus;
    }
    let value = *symbols.entry(symbol.into()).or_insert((found - plus) / factor);
    found == factor * value + plus
}

/// A file of the cube that has every record.
fn with_all_records(cube: &Cube) -> Container {
    let (hierarchical, half, elements, gathered) = (hierarchical(), half(), elements(), gathered());
    let (lightmap, of_lightmap) = (lightmap(), gathered_by_lightmap());
    let (volume, of_volume, accuracy) = (volume(), gathered_by_volume(), accuracy());
    let mut builder = cube.builder();
    hierarchical.write(&mut builder);
    half.write(&mut builder);
    elements.write(&mut builder);
    gathered.write(&mut builder);
    lightmap.write(&mut builder);
    of_lightmap.write(&mut builder, Lightmap::PREFIX, 0);
    volume.write(&mut builder);
    of_volume.write(&mut builder, Volume::PREFIX, 0);
    accuracy.write(&mut builder);
    open(&builder)
}

#[test]
fn every_section_has_the_element_shape_and_flags_that_the_specification_lists() {
    let mut cube = cube_with_cuts();
    cube.mesh.lightmap_uv = cube.mesh.uv.clone();
    let container = with_all_records(&cube);
    let mut symbols = HashMap::new();
    let text = specification();
    let listed = section_rows(&text);
    assert_eq!(listed.len(), container.sections().len(), "the cube has every section");
    for row in listed {
        let section = container.section(&row[0]).expect("the cube has every section");
        assert_eq!(section.element.name(), row[2], "element of {}", row[0]);
        let shape = &section.shape;
        let listed: Vec<&str> = row[3].split('×').map(str::trim).collect();
        let fits = row[3] == "*"
            || listed.len() == shape.len() && listed.iter().zip(shape).all(|(e, &f)| fits(e, f, &mut symbols));
        assert!(fits, "shape of {} is {shape:?}, listed as {}, with {symbols:?}", row[0], row[3]);
        let flag = |word: &str, bit| if row[4].contains(word) { bit } else { 0 };
        assert_eq!(
            section.flags,
            flag("required", FLAG_REQUIRED) | flag("order", FLAG_PATCH_ORDER),
            "flags of {}",
            row[0]
        );
    }
    assert_eq!(["n", "t", "v", "c"].map(|s| symbols[s]), [6, 12, 24, 3]);
    for (symbol, _) in symbols {
        let defined = |r: &Vec<String>| r.len() == 2 && r[0].split(", ").any(|s| s == symbol);
        assert!(rows(&text, "## 4", "## 5").iter().any(defined), "symbol {symbol} is not explained");
    }
}

#[test]
fn specification_and_code_have_the_same_element_types() {
    let text = specification();
    let listed: Vec<Vec<String>> = rows(&text, "## 3", "## 4").into_iter().filter(|r| r.len() == 3).skip(1).collect();
    assert_eq!(listed.len(), 7);
    for row in listed {
        let code: u32 = row[0].parse().expect("a code");
        let element = ElementType::from_code(code).expect("the code knows it");
        assert!(row[1].starts_with(element.name()), "{} is called {}", row[1], element.name());
        assert_eq!(row[2], element.size().to_string());
    }
    assert_eq!(ElementType::from_code(7), None);
}

#[test]
fn the_checksum_is_the_one_that_the_specification_names() {
    assert!(specification().contains("`123456789` is CBF43926"));
    assert_eq!(crc32fast::hash(b"123456789"), 0xCBF4_3926);
}

/// Reads metadata by the tables of §5 and nothing else.
struct Reader {
    /// Type of each section.
    sections: HashMap<String, String>,
    /// Tables by type: structures have fields (name, type), choices have alternatives (index, fields).
    tables: HashMap<String, Vec<Vec<String>>>,
}

impl Reader {
    fn new(text: &str) -> Reader {
        let (mut sections, mut tables, mut current) = (HashMap::new(), HashMap::new(), String::new());
        for line in text.lines().skip_while(|l| !l.starts_with("## 5")).take_while(|l| !l.starts_with("## 6")) {
            if let Some(heading) = line.strip_prefix("#### ") {
                let (name, listed) = heading.split_once(", section").unwrap_or((heading, ""));
                current = name.to_string();
                tables.insert(current.clone(), vec![]);
                for section in listed.split('`').skip(1).step_by(2) {
                    sections.insert(section.to_string(), current.clone());
                }
            } else if line.starts_with('|') && !line.starts_with("|--") {
                let cells = line.trim_matches('|').split('|').map(|c| c.trim().to_string()).collect();
                tables.get_mut(&current).expect("a heading comes first").push(cells);
            }
        }
        Reader { sections, tables }
    }

    /// Reads one value of a type and leaves the rest of the bytes; `out` gets the value in words.
    fn read<'b>(&self, kind: &str, bytes: &'b [u8], out: &mut String) -> &'b [u8] {
        if let Some((element, count)) = kind.rsplit_once(" × ") {
            return (0..count.parse().expect("a count")).fold(bytes, |rest, _: u32| self.read(element, rest, out));
        }
        if let Some(element) = kind.strip_prefix("list of ") {
            let (count, rest) = number::<8>(bytes);
            return (0..count).fold(rest, |rest, _| self.read(element, rest, out));
        }
        if let Some(element) = kind.strip_prefix("option of ") {
            return match number::<1>(bytes) {
                (0, rest) => rest,
                (1, rest) => self.read(element, rest, out),
                (tag, _) => panic!("tag {tag} of {kind}"),
            };
        }
        let (value, rest) = match kind {
            "u32" => number::<4>(bytes),
            "u64" => number::<8>(bytes),
            "bool" => number::<1>(bytes),
            "f32" => (float32(bytes), &bytes[4..]),
            "f64" => (float64(bytes), &bytes[8..]),
            "string" => {
                let (length, rest) = number::<8>(bytes);
                let (text, rest) = rest.split_at(length as usize);
                out.push_str(std::str::from_utf8(text).expect("UTF-8"));
                out.push(' ');
                return rest;
            }
            name => return self.table(name, bytes, out),
        };
        out.push_str(&format!("{value} "));
        rest
    }

    fn table<'b>(&self, name: &str, bytes: &'b [u8], out: &mut String) -> &'b [u8] {
        let table = self.tables.get(name).unwrap_or_else(|| panic!("type {name} is not specified"));
        if table[0][0] == "field" {
            return table[1..].iter().fold(bytes, |rest, row| self.read(&row[1], rest, out));
        }
        let (index, rest) = number::<4>(bytes);
        let row = table[1..].iter().find(|r| r[0] == index.to_string()).expect("a specified alternative");
        out.push_str(&format!("{} ", row[1]));
        let fields = row[2].split(", ").filter(|f| !f.is_empty());
        fields.fold(rest, |rest, field| self.read(field.split_once(' ').expect("name and type").1, rest, out))
    }

    fn section(&self, container: &Container, name: &str) -> String {
        let mut out = String::new();
        let kind = self.sections.get(name).unwrap_or_else(|| panic!("metadata of {name} is not specified"));
        let rest = self.read(kind, container.data(container.section(name).expect("it is there")), &mut out);
        assert!(rest.is_empty(), "{} bytes of {name} are not specified", rest.len());
        out
    }
}

fn number<const N: usize>(bytes: &[u8]) -> (u64, &[u8]) {
    let (number, rest) = bytes.split_at(N);
    (number.iter().rev().fold(0, |n, &b| n << 8 | u64::from(b)), rest)
}

/// Numbers with an exact short form are all that the cube's metadata is asked for.
fn float32(bytes: &[u8]) -> u64 {
    f32::from_le_bytes(bytes[..4].try_into().expect("four bytes")).to_bits().into()
}

fn float64(bytes: &[u8]) -> u64 {
    f64::from_le_bytes(bytes[..8].try_into().expect("eight bytes")).to_bits()
}

#[test]
fn a_reader_made_from_the_specification_alone_reads_all_metadata() {
    let reader = Reader::new(&specification());
    let cube = cube();
    let container = with_all_records(&cube);
    let metas = container.sections().iter().filter(|s| s.element == ElementType::Meta);
    let read: Vec<(&str, String)> = metas.map(|s| (s.name.as_str(), reader.section(&container, &s.name))).collect();
    assert_eq!(read.len(), reader.sections.len(), "every section that is specified was read");
    let of = |name: &str| &read.iter().find(|(n, _)| *n == name).expect("read").1;
    let bits = |v: f32| v.to_bits();
    assert!(of("materials.meta").contains("grün") && of("materials.meta").ends_with("lamp.png 67 Clamp Clamp "));
    for light in ["a Point", "b Spot", "c Directional", "d Quad", "e Sky"] {
        assert!(of("scene.extras").contains(light), "{}", of("scene.extras"));
    }
    let grid = bits(-0.25);
    assert_eq!(of("patches.meta"), &format!("{grid} {grid} {grid} {} ", bits(1.5)));
    assert!(of("pack.meta").starts_with("6 3 Bc4 Sqrt ") && of("pack.meta").ends_with(" 8 1 "));
    assert!(of("pack.half").starts_with(&format!("6 3 7 Sqrt {} {} ", bits(0.5), bits(2.0))), "{}", of("pack.half"));
    assert_eq!(of("series.meta"), "");
    assert_eq!(of("lightmap.meta"), "4 2 ");
    assert!(of("volume.meta").ends_with(&format!("{} 4 2 1 ", bits(1.0))), "{}", of("volume.meta"));
    assert!(of("accuracy.meta").contains("emission {\"use_scene_emission\":true} "), "{}", of("accuracy.meta"));
    assert!(of("provenance").starts_with("voxel-simplify 1.0 --frozen cube.obj 1f2e3d4c"));

    let (paper, mut builder) = (cube.packed_as_the_paper(), minimal());
    paper.write(&mut builder);
    let read = reader.section(&open(&builder), "pack.meta");
    assert!(read.starts_with(&format!("6 3 3 Bc1 Log {} ", bits(4.0))), "{read}");
}
