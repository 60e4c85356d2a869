//! What a file is that is no container, told from its first bytes, so that the message can say what to do.
//!
//! Radiance scenes share our file ending and meshes are handed to the wrong stage by habit; these are the
//! cases that a person meets. The sentences are hints: no decision hangs on them.

use crate::layout::IDENTIFIER;

/// How much of the file is looked at.
const WINDOW: usize = 4096;

const TO_SCENE: &str = "; a scene goes to `allbounce voxel-simplify` or `allbounce bake`";

/// A hint in brackets for a file that does not start with our identifier; empty if there is nothing to say.
pub fn hint(bytes: &[u8]) -> String {
    let Some(kind) = kind(&bytes[..bytes.len().min(WINDOW)]) else { return String::new() };
    format!(" ({kind})")
}

fn kind(start: &[u8]) -> Option<String> {
    let seven_bit = IDENTIFIER.map(|b| b & 0x7f);
    match start {
        [] => None,
        _ if start[0] == IDENTIFIER[0] || start.starts_with(&seven_bit[..4]) => {
            Some("it was one: newlines or the eighth bit were converted in transfer, or it is cut short".into())
        }
        _ if start.starts_with(b"glTF") => Some(format!("it is a binary glTF file{TO_SCENE}")),
        _ if start.starts_with(b"\x89PNG") => Some("it is a PNG picture".into()),
        _ if start.starts_with(b"\x76\x2f\x31\x01") => Some("it is an OpenEXR picture".into()),
        _ => text_of(start).and_then(text_kind),
    }
}

/// The window as text, if it is text; a character may be cut at its end.
fn text_of(start: &[u8]) -> Option<&str> {
    let text = match std::str::from_utf8(start) {
        Ok(text) => text,
        Err(e) if e.error_len().is_none() => std::str::from_utf8(&start[..e.valid_up_to()]).ok()?,
        Err(_) => return None,
    };
    (!text.chars().any(|c| c.is_control() && !c.is_whitespace())).then_some(text)
}

fn text_kind(text: &str) -> Option<String> {
    let lines = || text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let has_line_starting = |words: &[&str]| lines().any(|line| line.first().is_some_and(|w| words.contains(w)));
    // `modifier type identifier`, the head of every Radiance primitive.
    let primitive = |line: &Vec<&str>| {
        let types = ["plastic", "metal", "glass", "light", "glow", "polygon", "sphere", "cylinder", "ring", "source"];
        line.len() == 3 && types.contains(&line[1])
    };
    Some(
        if text.starts_with("#?RADIANCE") || lines().any(|l| primitive(&l)) || has_line_starting(&["!xform", "void"]) {
            "it is a Radiance file: its scenes also end in .rad, but they are another format".into()
        } else if has_line_starting(&["v", "mtllib", "usemtl"]) {
            format!("it is a Wavefront OBJ mesh{TO_SCENE}")
        } else if text.trim_start().starts_with('{') {
            format!("it is JSON, perhaps a glTF scene, lights or a camera{TO_SCENE}")
        } else {
            "it is text; Radiance scenes also end in .rad, but they are another format".into()
        },
    )
}
