//! OBJ text as people have it to OBJ text that tobj accepts.
//!
//! One bad number or index makes tobj refuse the whole file, and some lines make it panic. So the text is
//! rewritten in a plain form first: positions and texture coordinates, then faces whose indices are positive,
//! in range and complete. The first texture coordinate is made up, so that every corner can have one. Materials
//! are numbered and the number stands as the name of an object, because material names may hold anything.

use std::{borrow::Cow, collections::HashMap, fmt::Write};

use crate::import::notes::Notes;

/// Corners that a face may have; cutting a polygon takes up to the cube of this.
const MAX_CORNERS: usize = 1024;

/// The rewritten file.
pub struct Clean {
    pub text: String,
    /// What follows each `mtllib`.
    pub libraries: Vec<String>,
    /// Material names by the number that `text` has for them; `""` for faces before the first `usemtl`.
    pub materials: Vec<String>,
}

/// Rewrites `text`; what cannot be kept goes to `notes`.
pub fn clean(text: &str, notes: &mut Notes) -> Clean {
    let mut points = Points { text: "vt 0 0\n".into(), sound: vec![], coordinates: 0 };
    for line in logical_lines(text) {
        points.take(&line, notes);
    }
    let mut faces = Faces { points: &points, text: String::new(), seen: (0, 0), dropped: Dropped::default() };
    let (mut libraries, mut materials) = (vec![], vec![String::new()]);
    let mut numbers = HashMap::from([(String::new(), 0)]);
    faces.start_material(0);
    for line in logical_lines(text) {
        let (keyword, rest) = split(&line);
        match keyword {
            "v" => faces.seen.0 += 1,
            "vt" => faces.seen.1 += 1,
            "f" | "fo" => faces.take(rest),
            "mtllib" => libraries.push(rest.to_owned()),
            "usemtl" => {
                let number = *numbers.entry(rest.to_owned()).or_insert_with(|| {
                    materials.push(rest.to_owned());
                    materials.len() - 1
                });
                faces.start_material(number);
            }
            "" | "vn" | "g" | "o" | "s" => {}
            "l" | "p" => notes.count("lines and points are ignored", 1),
            other => notes.name("statements that are not understood are ignored", other),
        }
    }
    faces.dropped.tell(notes);
    let text = faces.text;
    Clean { text: points.text + &text, libraries, materials }
}

/// Lines without comments, with those joined that end in a backslash.
fn logical_lines(text: &str) -> impl Iterator<Item = Cow<'_, str>> {
    let mut lines = text.trim_start_matches('\u{feff}').split(['\n', '\r']);
    std::iter::from_fn(move || {
        let mut line = Cow::Borrowed(lines.next()?);
        while let Some(start) = line.trim_end().strip_suffix('\\') {
            // The line end of a CRLF file leaves an empty piece between the two.
            let next = lines.by_ref().take(2).find(|l| !l.is_empty()).unwrap_or_default();
            line = Cow::Owned(format!("{start} {next}"));
        }
        match line.trim_start().starts_with('#') {
            true => Some(Cow::Borrowed("")),
            false => Some(line),
        }
    })
}

/// Keyword and the rest of a line.
fn split(line: &str) -> (&str, &str) {
    let line = line.trim();
    let at = line.find(char::is_whitespace).unwrap_or(line.len());
    (&line[..at], line[at..].trim())
}

/// Vertices and texture coordinates of the whole file.
struct Points {
    text: String,
    /// Whether each vertex is three finite numbers.
    sound: Vec<bool>,
    coordinates: usize,
}

impl Points {
    fn take(&mut self, line: &str, notes: &mut Notes) {
        let (keyword, rest) = split(line);
        let mut words = rest.split_whitespace();
        let mut number = |fallback| match words.next() {
            Some(word) => word.parse::<f64>().ok().filter(|x| x.abs() <= f64::from(f32::MAX)),
            None => fallback,
        };
        match keyword {
            "v" => {
                let position = [number(None), number(None), number(None)];
                let sound = position.iter().all(Option::is_some);
                self.sound.push(sound);
                let [x, y, z] = position.map(|c| if sound { c.unwrap_or(0.0) } else { 0.0 });
                writeln!(self.text, "v {x} {y} {z}").expect("a string takes any text");
                notes.count("vertices that are not three finite numbers", usize::from(!sound));
                notes.count("vertex colours are ignored", usize::from(words.count() >= 3));
            }
            "vt" => {
                self.coordinates += 1;
                let (u, v) = (number(None), number(Some(0.0)));
                notes.count(
                    "texture coordinates that are no numbers count as 0",
                    usize::from(u.is_none() || v.is_none()),
                );
                writeln!(self.text, "vt {} {}", u.unwrap_or(0.0), v.unwrap_or(0.0)).expect("a string takes any text");
            }
            _ => {}
        }
    }
}

struct Faces<'a> {
    points: &'a Points,
    text: String,
    /// Vertices and texture coordinates so far, from which negative indices count back.
    seen: (usize, usize),
    dropped: Dropped,
}

#[derive(Default)]
struct Dropped {
    short: usize,
    long: usize,
    unreadable: usize,
    out_of_range: usize,
    bad_vertex: usize,
    no_coordinate: usize,
}

/// Why a face is dropped.
enum Flaw {
    Unreadable,
    OutOfRange,
    BadVertex,
}

impl Faces<'_> {
    fn start_material(&mut self, number: usize) {
        writeln!(self.text, "o {number}").expect("a string takes any text");
    }

    fn take(&mut self, corners: &str) {
        match corners.split_whitespace().count() {
            0..3 => self.dropped.short += 1,
            3..=MAX_CORNERS => {
                let start = self.text.len();
                self.text.push('f');
                for corner in corners.split_whitespace() {
                    if let Err(flaw) = self.corner(corner) {
                        self.text.truncate(start);
                        match flaw {
                            Flaw::Unreadable => self.dropped.unreadable += 1,
                            Flaw::OutOfRange => self.dropped.out_of_range += 1,
                            Flaw::BadVertex => self.dropped.bad_vertex += 1,
                        }
                        return;
                    }
                }
                self.text.push('\n');
            }
            _ => self.dropped.long += 1,
        }
    }

    /// Writes one corner as `vertex/coordinate`; normals are not needed.
    fn corner(&mut self, corner: &str) -> Result<(), Flaw> {
        let mut parts = corner.split('/');
        let index = |word: &str| word.parse::<i64>().map_err(|_| Flaw::Unreadable);
        let vertex = index(parts.next().unwrap_or_default())?;
        let vertex = resolve(vertex, self.seen.0, self.points.sound.len()).ok_or(Flaw::OutOfRange)?;
        if !self.points.sound[vertex] {
            return Err(Flaw::BadVertex);
        }
        let coordinate = match parts.next().filter(|word| !word.is_empty()) {
            None => 0,
            Some(word) => match resolve(index(word)?, self.seen.1, self.points.coordinates) {
                Some(coordinate) => coordinate + 1,
                None => {
                    self.dropped.no_coordinate += 1;
                    0
                }
            },
        };
        write!(self.text, " {}/{}", vertex + 1, coordinate + 1).expect("a string takes any text");
        Ok(())
    }
}

/// Position in the list of an OBJ index: from 1, or from -1 backwards from what was seen.
fn resolve(index: i64, seen: usize, total: usize) -> Option<usize> {
    let position = if index > 0 { index - 1 } else { (seen as i64).checked_add(index).filter(|_| index < 0)? };
    usize::try_from(position).ok().filter(|&p| p < total)
}

impl Dropped {
    fn tell(&self, notes: &mut Notes) {
        notes.count("faces with fewer than three corners are dropped", self.short);
        notes.count(&format!("faces with more than {MAX_CORNERS} corners are dropped"), self.long);
        notes.count("faces that cannot be read are dropped", self.unreadable);
        notes.count("faces with an index out of range are dropped", self.out_of_range);
        notes.count("faces with a vertex that is not three finite numbers are dropped", self.bad_vertex);
        notes.count("face corners whose texture coordinate does not exist take (0, 0)", self.no_coordinate);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faces(text: &str) -> (Vec<String>, Vec<String>) {
        let mut notes = Notes::default();
        let clean = clean(text, &mut notes);
        let faces = clean.text.lines().filter(|l| l.starts_with('f')).map(str::to_owned).collect();
        (faces, notes.into_warnings())
    }

    const THREE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 1\n";

    #[test]
    fn indices_of_every_kind_become_positive_ones() {
        for face in ["f 1 2 3", "f -3 -2 -1", "f 1//7 2//8 3//9", "f 1/ 2/ 3/", "f\t1 2 3 # note"] {
            let face = face.replace(" # note", "");
            assert_eq!(faces(&format!("{THREE}{face}\n")), (vec!["f 1/1 2/1 3/1".into()], vec![]), "{face}");
        }
        assert_eq!(faces(&format!("{THREE}f 1/1 2/-1 3/2/5")).0, ["f 1/2 2/3 3/3"]);
    }

    #[test]
    fn line_ends_of_any_system_and_continued_lines_are_read() {
        for text in ["v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n", "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3"] {
            assert_eq!(faces(text).0.len(), 1, "{text:?}");
        }
        for end in ["\n", "\r\n"] {
            let text = format!("{THREE}f 1 2 \\{end} 3{end}f 1 2 3");
            assert_eq!(faces(&text).0, ["f 1/1 2/1 3/1"; 2], "{end:?}");
        }
        assert_eq!(faces("f 1 2 3 \\").0.len(), 0, "nothing follows the backslash");
    }

    #[test]
    fn faces_may_name_vertices_that_come_later() {
        assert_eq!(faces(&format!("f 1 2 3\n{THREE}")).0, ["f 1/1 2/1 3/1"]);
    }

    #[test]
    fn every_flaw_costs_its_face_only_and_is_counted() {
        let text = format!(
            "{THREE}v nan 0 0\nv 1e39 0 0\nv 1 2\nf 1 2\nf 1 2 9\nf 0 1 2\nf -9 1 2\nf 1 2 x\nf 1 2 4\nf 1 2 5\n\
             f 1 2 6\nf 1/9 2 3\nl 1 2\np 1\ncurv 0 1\nf {}\nf 99999999999999999999 1 2\nf -9223372036854775808 1 2\n",
            "1 ".repeat(1025)
        );
        let (kept, said) = faces(&text);
        assert_eq!(kept, ["f 1/1 2/1 3/1"]);
        let expected = [
            "vertices that are not three finite numbers: 3",
            "lines and points are ignored: 2",
            "statements that are not understood are ignored: curv",
            "faces with fewer than three corners are dropped: 1",
            "faces with more than 1024 corners are dropped: 1",
            "faces that cannot be read are dropped: 2",
            "faces with an index out of range are dropped: 4",
            "faces with a vertex that is not three finite numbers are dropped: 3",
            "face corners whose texture coordinate does not exist take (0, 0): 1",
        ];
        assert_eq!(said, expected);
    }

    #[test]
    fn material_and_library_names_keep_their_spaces() {
        let mut notes = Notes::default();
        let text = "mtllib my  lib.mtl \nusemtl two words\nf 1 2 3\nusemtl\tother\nusemtl two words\n";
        let clean = clean(text, &mut notes);
        assert_eq!(clean.libraries, ["my  lib.mtl"]);
        assert_eq!(clean.materials, ["", "two words", "other"]);
        let objects: Vec<&str> = clean.text.lines().filter(|l| l.starts_with('o')).collect();
        assert_eq!(objects, ["o 0", "o 1", "o 2", "o 1"]);
    }
}
