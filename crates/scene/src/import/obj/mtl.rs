//! MTL material libraries: diffuse colour, emission, and what else they hold that is ignored.
//!
//! As with OBJ, the text is made plain first and then read by tobj, which panics on a colour of two numbers.
//! Source: Wavefront, Material Library File (.mtl). `Ke` and `map_Ke` are the usual extension for emission.

use crate::import::notes::Notes;

/// One material of a library.
#[derive(Debug, Default, PartialEq)]
pub struct MtlMaterial {
    pub name: String,
    /// `Kd`, linear.
    pub reflectance: Option<[f64; 3]>,
    /// `map_Kd`.
    pub reflectance_map: Option<Map>,
    /// `Ke`, radiance in W/(m² sr).
    pub emission: Option<[f64; 3]>,
    /// `map_Ke`.
    pub emission_map: Option<Map>,
    glossy: bool,
    transparent: bool,
    bumpy: bool,
}

/// A texture statement.
#[derive(Debug, PartialEq)]
pub struct Map {
    pub file: String,
    pub clamp: bool,
}

impl MtlMaterial {
    /// Notes what of the material is ignored by contract.
    pub fn note_ignored(&self, notes: &mut Notes) {
        let kinds = [
            (self.glossy, "gloss is ignored, surfaces are diffuse; materials"),
            (self.transparent, "transparency is ignored, surfaces are opaque; materials"),
            (self.bumpy, "bump and normal maps are ignored; materials"),
        ];
        for (_, what) in kinds.iter().filter(|(is, _)| *is) {
            notes.count(what, 1);
        }
    }
}

/// Reads a library.
pub fn parse(text: &str, notes: &mut Notes) -> Vec<MtlMaterial> {
    let plain = plain(text, notes);
    let Ok((materials, _)) = tobj::load_mtl_buf(&mut plain.as_bytes()) else {
        notes.count("material libraries that cannot be read are ignored", 1);
        return vec![];
    };
    materials.into_iter().map(|m| material(m, notes)).collect()
}

fn material(m: tobj::Material, notes: &mut Notes) -> MtlMaterial {
    let mut map = |statement: Option<&str>| statement.and_then(|s| texture_statement(s, notes));
    MtlMaterial {
        reflectance_map: map(m.diffuse_texture.as_deref()),
        emission_map: map(m.unknown_param.get("map_Ke").map(String::as_str)),
        name: m.name,
        reflectance: m.diffuse,
        emission: m.emissive,
        glossy: m.specular.is_some_and(|s| s.iter().any(|&c| c > 0.0)),
        transparent: m.dissolve.is_some_and(|d| d < 1.0) || m.dissolve_texture.is_some(),
        bumpy: m.normal_texture.is_some(),
    }
}

/// The statements that matter, spelt and completed as tobj wants them.
fn plain(text: &str, notes: &mut Notes) -> String {
    let mut plain = String::new();
    for line in text.trim_start_matches('\u{feff}').split(['\n', '\r']) {
        let line = line.trim();
        let at = line.find(char::is_whitespace).unwrap_or(line.len());
        let (keyword, rest) = (line[..at].to_ascii_lowercase(), line[at..].trim());
        let numbers: Vec<f64> = rest.split_whitespace().map_while(|w| w.parse().ok()).take(3).collect();
        match keyword.as_str() {
            "newmtl" => plain += &format!("newmtl {}\n", if rest.is_empty() { "(without a name)" } else { rest }),
            "kd" | "ke" | "ks" => match numbers[..] {
                [r, g, b] => plain += &format!("K{} {r} {g} {b}\n", &keyword[1..]),
                // The format lets green and blue be left out where they equal red.
                [grey] => plain += &format!("K{} {grey} {grey} {grey}\n", &keyword[1..]),
                _ => notes.name("colours that are not numbers are ignored", line),
            },
            "d" if !numbers.is_empty() => plain += &format!("d {}\n", numbers[0]),
            "map_kd" | "map_ke" | "map_d" | "bump" | "map_bump" | "norm" if !rest.is_empty() => {
                let spelt = match keyword.as_str() {
                    "map_kd" => "map_Kd",
                    "map_ke" => "map_Ke",
                    "map_d" => "map_d",
                    _ => "bump",
                };
                plain += &format!("{spelt} {rest}\n");
            }
            _ => {}
        }
    }
    plain
}

/// Options and file name of a texture statement.
fn texture_statement(statement: &str, notes: &mut Notes) -> Option<Map> {
    let (mut rest, mut clamp) = (statement.trim(), false);
    while let Some((option, after)) = next_word(rest).filter(|(word, _)| word.starts_with('-')) {
        let (most, numeric) = match option {
            "-o" | "-s" | "-t" => (3, true),
            "-mm" => (2, true),
            "-clamp" | "-blendu" | "-blendv" | "-cc" | "-imfchan" | "-type" => (1, false),
            "-bm" | "-boost" | "-texres" => (1, true),
            _ => break, // a file name that starts with a dash
        };
        if matches!(option, "-o" | "-s" | "-t") {
            notes.count("texture options -o, -s and -t are ignored", 1);
        }
        rest = after;
        for _ in 0..most {
            match next_word(rest) {
                Some((word, after)) if !numeric || word.parse::<f64>().is_ok() => {
                    clamp |= option == "-clamp" && word == "on";
                    rest = after;
                }
                _ => break,
            }
        }
    }
    (!rest.is_empty()).then(|| Map { file: rest.to_owned(), clamp })
}

fn next_word(text: &str) -> Option<(&str, &str)> {
    let at = text.find(char::is_whitespace).unwrap_or(text.len());
    (at > 0).then(|| (&text[..at], text[at..].trim_start()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(text: &str) -> (MtlMaterial, Vec<String>) {
        let mut notes = Notes::default();
        let mut materials = parse(&format!("newmtl m\n{text}"), &mut notes);
        assert_eq!(materials.len(), 1);
        (materials.remove(0), notes.into_warnings())
    }

    #[test]
    fn colours_and_maps_are_read_in_any_spelling() {
        let (m, said) =
            one("\tKd 0.63 0.065 0.05 # Red\r\n\tKE 17 12 4\r\nmap_kd a b.png\r\nmap_Ke glow.png\r\nNs 10\r\n");
        assert_eq!((m.reflectance, m.emission), (Some([0.63, 0.065, 0.05]), Some([17.0, 12.0, 4.0])));
        assert_eq!(m.reflectance_map.unwrap().file, "a b.png");
        assert_eq!(m.emission_map.unwrap().file, "glow.png");
        assert!(said.is_empty(), "{said:?}");
    }

    #[test]
    fn colours_of_one_number_are_grey_and_of_two_are_refused() {
        assert_eq!(one("Kd 0.4").0.reflectance, Some([0.4; 3]));
        for bad in ["Kd 0.4 0.5", "Kd spectral a.rfl", "Kd", "Kd x y z"] {
            let (m, said) = one(bad);
            assert_eq!((m.reflectance, said), (None, vec![format!("colours that are not numbers are ignored: {bad}")]));
        }
    }

    #[test]
    fn texture_options_are_stepped_over() {
        for (statement, file, clamp) in [
            ("a.png", "a.png", false),
            ("-clamp on my a.png", "my a.png", true),
            ("-clamp off -bm 0.3 a.png", "a.png", false),
            ("-s 1 1 1 -o 0.5 -mm 0 1 a.png", "a.png", false),
            ("-s 2 2 a.png", "a.png", false),
            ("-dash.png", "-dash.png", false),
        ] {
            let map = one(&format!("map_Kd {statement}")).0.reflectance_map;
            assert_eq!(map, Some(Map { file: file.into(), clamp }), "{statement}");
        }
        assert_eq!(one("map_Kd -clamp on").0.reflectance_map, None);
        assert_eq!(one("map_Kd").0.reflectance_map, None);
    }

    #[test]
    fn gloss_transparency_and_bumps_are_noted() {
        let mut notes = Notes::default();
        one("Ks 1 1 1\nd 0.5\nmap_bump b.png").0.note_ignored(&mut notes);
        assert_eq!(notes.into_warnings().len(), 3);
        let mut notes = Notes::default();
        one("Ks 0 0 0\nd 1").0.note_ignored(&mut notes);
        assert!(notes.into_warnings().is_empty());
    }

    #[test]
    fn text_that_is_no_library_gives_no_materials() {
        for text in ["", "Kd 1 1 1", "\0\0\0", "newmtl"] {
            let materials = parse(text, &mut Notes::default());
            assert_eq!(materials.len(), usize::from(text == "newmtl"), "{text:?}");
        }
    }
}
