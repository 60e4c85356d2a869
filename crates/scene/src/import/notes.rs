//! The sentences of the import report: one for each kind of thing, with a count or names.

use std::collections::HashSet;

/// Names that a sentence lists before it only counts.
const LISTED: usize = 5;
/// Characters of a name that are shown; a damaged file may have names of megabytes.
const SHOWN: usize = 80;

/// What happened during an import, in order of first occurrence.
#[derive(Default)]
pub struct Notes(Vec<Note>);

struct Note {
    what: String,
    count: usize,
    /// The first few names.
    names: Vec<String>,
    seen: HashSet<String>,
}

impl Notes {
    /// `n` more things of the kind that `what` describes; nothing for 0.
    pub fn count(&mut self, what: &str, n: usize) {
        if n > 0 {
            self.note(what).count += n;
        }
    }

    /// A sentence without a count.
    pub fn say(&mut self, sentence: &str) {
        self.note(sentence);
    }

    /// `what` happened to the thing called `name`; the same name counts once.
    pub fn name(&mut self, what: &str, name: &str) {
        let note = self.note(what);
        if note.seen.insert(name.to_owned()) {
            note.count += 1;
            if note.names.len() < LISTED {
                let shown: String = name.chars().take(SHOWN).flat_map(char::escape_debug).collect();
                note.names.push(if name.is_empty() { "(without a name)".into() } else { shown });
            }
        }
    }

    fn note(&mut self, what: &str) -> &mut Note {
        let at = self.0.iter().position(|note| note.what == what).unwrap_or_else(|| {
            self.0.push(Note { what: what.into(), count: 0, names: vec![], seen: HashSet::new() });
            self.0.len() - 1
        });
        &mut self.0[at]
    }

    /// `what`, `what: count`, or `what: name, name and 3 more`.
    pub fn into_warnings(self) -> Vec<String> {
        let sentence = |note: Note| {
            let rest = note.count - note.names.len();
            match (note.names.is_empty(), rest) {
                (true, 0) => note.what,
                (true, _) => format!("{}: {}", note.what, note.count),
                (false, 0) => format!("{}: {}", note.what, note.names.join(", ")),
                (false, _) => format!("{}: {} and {rest} more", note.what, note.names.join(", ")),
            }
        };
        self.0.into_iter().map(sentence).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_of_thing_is_said_once_with_its_count_or_its_names() {
        let mut notes = Notes::default();
        notes.count("nothing", 0);
        notes.count("faces dropped", 2);
        for name in ["a", "b", "a", "c", "d", "e", "f", "g"] {
            notes.name("materials clamped", name);
        }
        notes.count("faces dropped", 3);
        notes.name("files missing", "");
        notes.say("the scene is far away");
        notes.say("the scene is far away");
        let said = [
            "faces dropped: 5",
            "materials clamped: a, b, c, d, e and 2 more",
            "files missing: (without a name)",
            "the scene is far away",
        ];
        assert_eq!(notes.into_warnings(), said);
    }
}
