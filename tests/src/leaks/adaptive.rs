//! Scenes of the other families with patches that are small where light changes (`--adaptive`).

use super::{LeakScene, boxes, place::TURNED, sealed};

/// Sealed rooms behind every wall, turned, and standing boxes.
pub fn scenes() -> Vec<LeakScene> {
    let rooms = sealed::scenes().into_iter().filter(|s| s.name.ends_with(TURNED.name));
    let standing = boxes::scenes().into_iter().filter(|s| s.name.starts_with("box standing"));
    let adaptive = |s: LeakScene| LeakScene { name: format!("{}, adaptive patches", s.name), adaptive: true, ..s };
    rooms.chain(standing).map(adaptive).collect()
}
